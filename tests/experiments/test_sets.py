"""Sets are data: what they ask for fits their robot, and scales with any other."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from gaitsmith.errors import BadInput
from gaitsmith.experiments import load_set
from gaitsmith.experiments.limits import QUANTITIES
from gaitsmith.experiments.push_grid import momentum_unit
from gaitsmith.experiments.sets import leg_length, set_names
from gaitsmith.simulation.scenario import check_scenario

TEMPLATE_SETS = [name for name in set_names() if name not in ("planned", "kick")]


@pytest.mark.parametrize("name", TEMPLATE_SETS)
def test_every_trial_fits_the_set_s_robot_and_measures_known_quantities(name):
    found = load_set(name)
    names = [trial.name for trial in found.trials]
    assert len(set(names)) == len(names)
    for trial in found.trials:
        assert {limit.quantity for limit in trial.limits} | set(trial.entry.report) <= set(QUANTITIES)
        assert 0 <= trial.least <= len(trial.scenarios)
        for scenario in trial.scenarios:
            check_scenario(scenario, found.robot)
    for grid in found.grids:
        check_scenario(grid.scenario(grid.cells[-1]), found.robot)
        assert (grid.least or 0) <= len(grid.cells)


def test_inputs_of_the_gait_are_held_for_twenty_seconds():
    for trial in load_set("walks").trials:
        if trial.name.split("_")[0] in ("height", "lift", "period", "alpha"):
            (scenario,) = trial.scenarios
            times = [*(change.time for change in scenario.changes), scenario.duration]
            assert all(after - before >= 20.0 for before, after in pairwise(times))
            assert scenario.speed == (0.2, 0.0)


def test_trials_keep_the_preset_that_they_name_and_the_rest_take_the_one_asked_for():
    presets = {trial.name: trial.scenarios[0].preset for trial in load_set("walks").trials}
    assert {name for name, preset in presets.items() if preset == "paper"} == {"paper_0", "paper_0.4"}
    assert set(presets.values()) == {"paper", "default"}


def test_a_set_scales_with_the_robot():
    own, other = load_set("courses"), load_set("courses", "bhr_b2")
    scale = leg_length(other.robot) / leg_length(own.robot)
    assert leg_length(own.robot) == pytest.approx(0.39)
    for mine, theirs in zip(own.trials, other.trials, strict=True):
        (small,), (large,) = mine.scenarios, theirs.scenarios
        assert large.duration / small.duration == pytest.approx(math.sqrt(scale), rel=1e-5)
        np.testing.assert_allclose(large.speed or 0.0, math.sqrt(scale) * np.array(small.speed or 0.0), atol=1e-6)
        if small.yaw_rate:
            assert large.yaw_rate * large.duration == pytest.approx(small.yaw_rate * small.duration, rel=1e-5)
    units = [momentum_unit(found.robot, leg_length(found.robot)) for found in (own, other)]
    for mine, theirs in zip(own.grids, other.grids, strict=True):
        assert theirs.impulse / units[1] == pytest.approx(mine.impulse / units[0], rel=1e-3)


def test_a_strength_is_the_same_share_of_any_robot_s_momentum_unit():
    for robot in ("thbip_ii", "bhr_b2"):
        found = load_set("strangers", robot)
        (grid,) = found.grids
        assert grid.impulse == pytest.approx(0.09 * momentum_unit(found.robot, grid.base.height), abs=1e-3)
        assert grid.name.endswith("in place")


def test_seeds_draw_within_their_range_and_always_the_same():
    (first, second) = (load_set("courses_estimated").trials[3].scenarios for _ in range(2))
    assert first == second
    assert len({scenario.friction for scenario in first}) == len(first)
    assert all(0.95 <= scenario.mass_factor <= 1.05 and 0.5 <= scenario.friction <= 1.0 for scenario in first)


def test_an_extending_set_changes_every_trial_and_keeps_the_rest():
    plain, estimated = load_set("courses"), load_set("courses_estimated")
    for mine, theirs in zip(plain.trials, estimated.trials, strict=True):
        same = theirs.scenarios[0].model_copy(update={"state": "true", "torque_delay": 0.0, "mass_factor": 1.0})
        assert same.model_copy(update={"friction": 0.8}) == mine.scenarios[0]
    assert not estimated.grids


@pytest.mark.parametrize(
    ("text", "field"),
    [
        ("robot = 'bhr_b2'\ntrials = 3", "trials"),
        ("robot = 'bhr_b2'\n[[trials]]\nname = 'a'\nlimits = { beauty = 1.0 }", "limits"),
        ("robot = 'bhr_b2'\n[[trials]]\nname = 'a'\nsped = 1.0", "sped"),
        ("robot = 'bhr_b2'\n[[trials]]\nname = 'a'\nscenario = { sped = 1.0 }", "sped"),
        ("robot = 'bhr_b2'\nevery = 3\n[[trials]]\nname = 'a'", "trials"),
        ("not toml", "--set"),
    ],
)
def test_a_set_that_cannot_be_used_is_refused_by_name(tmp_path, text, field):
    path = tmp_path / "set.toml"
    path.write_text(text)
    with pytest.raises(BadInput) as caught:
        load_set(str(path))
    assert field in caught.value.field


def test_with_a_gait_file_the_set_for_them_is_taken_and_one_that_commands_is_refused(monkeypatch):
    monkeypatch.setattr("gaitsmith.experiments.sets.completed", lambda fields: dict(fields) | {"duration": 20.0})
    found = load_set(None, gait="gait.json")
    assert (found.name, load_set(None).name) == ("planned", "walks")
    episodes = [scenario for trial in found.trials for scenario in trial.scenarios]
    assert {scenario.gait for scenario in episodes + [grid.base for grid in found.grids]} == {("gait.json",)}
    for name in TEMPLATE_SETS:
        with pytest.raises(BadInput, match="the gait decides"):
            load_set(name, gait="gait.json")


@pytest.mark.parametrize("name", ["planned", "kick"])
def test_a_set_for_a_planned_gait_is_refused_without_one(name):
    """It would walk by the template, and pass."""
    with pytest.raises(BadInput, match="--gait: got 'none'"):
        load_set(name)
