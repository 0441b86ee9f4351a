"""Libraries whose gaits turn, and whose ground rises: mixed like all others, without a seam, walked as commanded."""

import math

import pytest
from tests.library.test_family import sampled, seams

from gaitsmith.errors import BadInput
from gaitsmith.library.building import build, failures
from gaitsmith.library.family import Family
from gaitsmith.library.folder import Folder
from gaitsmith.library.spec import checked_spec
from gaitsmith.planned.table import SOLES
from gaitsmith.robots import load_robot
from gaitsmith.simulation import Simulation, library_run
from gaitsmith.simulation.diagnosis import _ground
from gaitsmith.simulation.library_run import plans_for_slopes
from gaitsmith.simulation.scenario import make_scenario
from gaitsmith.synthesis.motions.biped import biped_from

GRID = {"robot": "thbip_ii", "speed": [0.2], "period": [0.7], "yaw_rate": [0.0, 0.2], "slope": [0.0, 4.0]}
LEVEL, TURNING, RISING = {(0, 0, 0, 0): 1.0}, {(0, 0, 1, 0): 1.0}, (0, 0, 0, 1)


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    folder = Folder(tmp_path_factory.mktemp("grounds") / "library")
    return folder, build(checked_spec(GRID), folder)


@pytest.fixture(scope="module")
def folder(built):
    return built[0]


@pytest.fixture(scope="module")
def family(folder):
    return Family(folder, load_robot("thbip_ii"))


def made(folder, **fields):
    return Simulation(make_scenario({"library": str(folder.path), "robot": "thbip_ii", **fields}), record=False)


def test_all_but_turns_on_slopes_are_planned_and_those_say_why(built):
    found = built[1]
    (failed,) = failures(found)
    assert failed["point"] == "000-000-001-001"
    assert "turn on a slope" in failed["reason"]
    assert found.base == "000-000-000-000"
    assert {"start-000", "stop-000", "start-001", "stop-001"} <= {*found.records}
    assert {**found.records} == {**built[0].whole()[1]}


def test_gaits_that_turn_differently_are_mixed_without_a_seam(family):
    assert family.rest == LEVEL
    own = seams(family.plan.table)  # each gait's: how exactly its curves are fitted
    half = family.weights({"speed": 0.2, "period": 0.7, "yaw_rate": 0.1})
    assert half == {(0, 0, 0, 0): pytest.approx(0.5), (0, 0, 1, 0): pytest.approx(0.5)}
    for before, after in ((LEVEL, TURNING), (TURNING, half), (half, LEVEL)):
        family.write(0, before, before)
        family.write(1, before, after)
        found = seams(family.plan.table)
        assert found[0] < own[0] + 1e-6
        assert found[1] < own[1] + 1e-3


def test_on_a_slope_between_two_of_the_grid_start_loop_and_stop_are_mixed(folder, family):
    level = seams(family.plan.table, whole=True)
    family = Family(folder, load_robot("thbip_ii"), 1.0)
    assert family.rest == {(0, 0, 0, 0): pytest.approx(0.75), RISING: pytest.approx(0.25)}
    found = seams(family.plan.table, whole=True)
    assert found[0] < level[0] + 1e-6
    assert found[1] < level[1] + 1e-3
    motion, _ = sampled(family.plan.table, 0, 0.0)
    assert motion[0, SOLES + 4] == pytest.approx(-math.radians(1.0), abs=1e-4)  # the sole lies on the ground


def test_it_turns_as_fast_as_commanded_and_walks_straight_again(folder):
    run = made(folder, speed=[0.2, 0.0], yaw_rate=0.1, duration=7.0, changes=[{"time": 4.5, "yaw_rate": 0.0}])
    summary = run.run().summary
    assert summary.fall is None
    turning, after = summary.stages[1], summary.stages[2]
    assert turning.command.yaw_rate == pytest.approx(0.1)
    assert turning.yaw_rate_error == pytest.approx(0.0, abs=0.01)
    assert turning.vx_mean == pytest.approx(0.2, rel=0.02)
    assert after.yaw_rate_error == pytest.approx(0.0, abs=0.06)  # its first steps are those before the change


def test_it_walks_a_slope_between_two_of_the_grid(folder):
    summary = made(folder, speed=[0.2, 0.0], terrain="ramp:2", duration=5.0).run().summary
    assert summary.fall is None
    assert summary.stages[1].vx_mean == pytest.approx(0.2, rel=0.02)


@pytest.mark.parametrize(
    ("slope", "given", "field", "valid"),
    [
        (6.0, {}, "terrain", "0 to 4"),
        (0.0, {"yaw_rate": 0.3}, "yaw_rate", "0 to 0.2"),
        (1.0, {"yaw_rate": 0.1}, "speed", "could be planned"),
        (0.0, {"speed": (0.2, 0.1)}, "speed", "sideways"),
    ],
)
def test_what_the_grid_does_not_hold_is_refused(folder, family, slope, given, field, valid, monkeypatch):
    if not slope:
        monkeypatch.setattr(library_run, "Family", lambda *given: family)
    with pytest.raises(BadInput, match=field) as error:
        made(folder, **({"speed": [0.2, 0.0], "duration": 5.0, "terrain": f"ramp:{slope}"} | given))
    assert valid in str(error.value)


def test_the_slope_that_gaits_were_planned_for_is_no_cause_of_a_fall(folder, tmp_path):
    level = Folder(tmp_path)
    level.begin(checked_spec(GRID | {"slope": []}), load_robot("thbip_ii"))
    for library, planned in ((str(folder.path), True), (str(level.path), False), ("", False)):
        scenario = make_scenario({"robot": "thbip_ii", "library": library, "terrain": "ramp:2"})
        assert plans_for_slopes(scenario) == planned
        assert bool(_ground(scenario, 1.0)) != planned


@pytest.mark.parametrize("yaw_rate", [-0.3, 0.0, 0.3])
def test_all_gaits_of_a_library_begin_on_the_same_foot(yaw_rate):
    spec = checked_spec(GRID | {"yaw_rate": [-0.3, 0.0, 0.3], "slope": []})
    motions = spec.motions(biped_from(load_robot("thbip_ii")))
    _, motion = motions[(0, 0, spec.yaw_rate.index(yaw_rate))]
    assert motion.phases[0].support == "right"
    turn = motion.phases[-1].heading - motion.phases[0].heading
    assert turn == pytest.approx(2.0 * 0.7 * yaw_rate, abs=1e-9)
    assert spec.bases[0] == (0, 0, 1)
