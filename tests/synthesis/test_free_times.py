"""Numbers left free: slopes are those of plans made anew, the search keeps its ranges, files say what was free."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from gaitsmith.errors import BadInput
from gaitsmith.synthesis import verify
from gaitsmith.synthesis.files.gait_file import claims_hash, gait_document, gait_of
from gaitsmith.synthesis.files.motion_file import read_motion
from gaitsmith.synthesis.motions.settings import Settings
from gaitsmith.synthesis.requests.free_times import Freedom, descended, freed_motion
from gaitsmith.synthesis.solution.sensitivity import slopes

GOAL = np.array([0.62, 0.45, 0.9])
LOW, HIGH = np.zeros(3), np.array([1.0, 1.0, 0.5])


def _search(sums=((0.0, 0.0, 0.0),), most=(1.0,), missing=lambda values: False):
    asked = []

    def cost(values):
        return 100.0 + float(np.array([50.0, 30.0, 5.0]) @ (values - GOAL) ** 2)

    def plan(values, neighbour):
        asked.append(values)
        assert neighbour.gait is not None
        return SimpleNamespace(objective=cost(values), gait=None if missing(values) else object())

    start = np.array([0.5, 0.3, 0.2])
    freedom = Freedom(LOW, HIGH, np.full(3, 0.1), np.array(sums), np.array(most))
    slope = lambda values, _: np.array([100.0, 60.0, 10.0]) * (values - GOAL)  # noqa: E731
    return *descended(start, freedom, SimpleNamespace(objective=cost(start), gait=object()), slope, plan), asked


def test_the_search_nears_the_least_cost_within_its_ranges():
    values, found, asked = _search()
    assert np.all(np.abs(values - [0.62, 0.45, 0.5]) < [0.03, 0.05, 0.05])
    assert found.objective < 101.0
    assert len(asked) < 20
    assert all(np.all(tried >= LOW) and np.all(tried <= HIGH) for tried in asked)


def test_the_search_keeps_sums_and_passes_over_what_has_no_plan():
    values, _, asked = _search(sums=((1.0, 1.0, 0.0),), most=(0.9,), missing=lambda tried: tried[0] > 0.55)
    assert all(tried[0] + tried[1] <= 0.9 + 1e-9 for tried in asked)
    assert any(tried[0] > 0.55 for tried in asked)
    assert 0.5 < values[0] <= 0.55


@pytest.fixture(scope="module")
def freed(planner, dynamic):
    """The dynamic step with the duration of its double support free."""
    first, settings = dynamic.main, Settings()
    motion = first.gait.motion
    k = next(k for k, phase in enumerate(motion.phases) if phase.contact == "toe")
    motion = replace(
        motion, phases=tuple(replace(p, between=(0.03, 0.06)) if i == k else p for i, p in enumerate(motion.phases))
    )
    run = lambda tried, found: planner.plan(tried, settings, neighbour=found)  # noqa: E731
    return k, motion, freed_motion(planner, motion, first, settings, run)


def test_the_slope_is_that_of_a_plan_made_anew(planner, dynamic):
    settings, change, motion = Settings(), 1e-3, dynamic.main.gait.motion
    first = planner.plan(motion, settings, neighbour=dynamic.main)  # a warm plan imposes more instants than a cold one
    moved = replace(motion, phases=(replace(motion.phases[0], duration=motion.phases[0].duration + change),))
    moved = replace(moved, phases=moved.phases + motion.phases[1:])
    (promised,) = slopes(planner.biped, planner.functions, first, [motion, moved], settings)
    again = planner.plan(moved, settings, neighbour=first)
    assert again.objective - first.objective == pytest.approx(promised, rel=0.1)


def test_a_free_duration_lowers_the_objective_and_is_in_the_file(robot, dynamic, freed):
    k, motion, result = freed
    assert result.objective < dynamic.main.objective * (1.0 - 5e-3)
    assert 0.03 <= result.gait.motion.phases[k].duration <= 0.06
    read = gait_of(gait_document(result.gait))
    assert read.motion.phases[k].between == motion.phases[k].between
    assert verify(read, robot, 60).ok


def test_a_duration_outside_of_its_range_is_no_proof(robot, freed):
    k, _, result = freed
    phases = list(result.gait.motion.phases)
    phases[k] = replace(phases[k], between=(0.9 * phases[k].duration, 0.95 * phases[k].duration))
    forged = replace(result.gait, motion=replace(result.gait.motion, phases=tuple(phases)))
    forged.certificate["claims"] = claims_hash(forged)
    problems = verify(forged, robot, 60).problems
    assert any(f"{phases[k].name} lasts" in problem for problem in problems)


@pytest.mark.parametrize(("text", "named"), [("[1.0, 1.2]", "duration"), ("[1.2, 0.5]", "duration_range")])
def test_a_start_outside_of_the_range_is_refused(planner, tmp_path, text, named):
    source = Path(__file__).parents[2] / "examples" / "motions" / "side_step.toml"
    path = tmp_path / "motion.toml"
    path.write_text(source.read_text().replace("[0.5, 1.2]", text, 1))
    with pytest.raises(BadInput) as refused:
        read_motion(path, planner.biped)
    assert named in refused.value.field
