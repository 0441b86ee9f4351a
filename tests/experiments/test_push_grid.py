"""Grids push in every direction at every phase, and count honestly."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from tests.experiments.made_up import REASON, made_up_summary
from tests.simulation.standing import robot

from gaitsmith.documents import checked
from gaitsmith.errors import BadInput
from gaitsmith.experiments import PushOptions, episodes, push_grids
from gaitsmith.experiments.episodes import Episodes
from gaitsmith.experiments.largest import Search, resolution_for, search_largest
from gaitsmith.experiments.limits import Limit
from gaitsmith.experiments.push_grid import (
    SURVIVAL,
    Cell,
    GridOutcome,
    PushGrid,
    first_limit,
    survival_time,
    survived,
)
from gaitsmith.experiments.sets import TrialSet
from gaitsmith.experiments.store import Store
from gaitsmith.robots import load_robot
from gaitsmith.simulation import Episode
from gaitsmith.simulation.scenario import make_scenario

WALK = make_scenario({"speed": [0.4, 0.0], "height": 0.66, "period": 0.4})
GRID = PushGrid(15.0, WALK, least=48, goal=96, separation=Limit("separation", 0.04))
SMALL = PushGrid(15.0, WALK, least=2, directions=2, phases=2)


def test_pushes_point_evenly_around_and_through_the_stride():
    pushes = [GRID.scenario(cell).pushes[0] for cell in GRID.cells]
    np.testing.assert_allclose([np.linalg.norm(push.impulse) for push in pushes], 15.0, rtol=1e-8)
    directions = [math.degrees(math.atan2(push.impulse[1], push.impulse[0])) % 360.0 for push in pushes[::12]]
    np.testing.assert_allclose(directions, np.arange(8) * 45.0, atol=1e-6)
    np.testing.assert_allclose([push.phase for push in pushes[:12]], np.arange(12) / 12)
    assert all(push.duration == 0.1 for push in pushes)


def test_the_slowest_stride_leaves_time_to_survive():
    scenario = GRID.scenario(Cell(0, 11))
    assert scenario.duration - scenario.pushes[0].time >= 2 * 1.6 * WALK.period + SURVIVAL - 1e-9
    assert scenario.pushes[0].time - scenario.walk_from >= 3.0


@pytest.mark.parametrize(
    ("summary", "seconds"),
    [
        (made_up_summary(pushed_at=4.5), SURVIVAL),
        (made_up_summary(pushed_at=4.5, fell_at=5.0), 0.5),
        (made_up_summary(pushed_at=4.5, fell_at=15.0), SURVIVAL),
        (made_up_summary(pushed_at=4.5, duration=9.0), 4.5),
        (made_up_summary(pushes=(None,)), 0.0),
        (made_up_summary(pushes=(None,), fell_at=3.0), 0.0),
    ],
)
def test_survival_counts_from_the_push(summary, seconds):
    assert survival_time(summary) == pytest.approx(seconds)
    assert survived(summary) == (seconds == SURVIVAL)


def _outcome(*fates: str, separation: float = 0.08) -> GridOutcome:
    kinds = {
        "stood": made_up_summary(pushed_at=4.5, min_foot_separation=separation),
        "fell": made_up_summary(pushed_at=4.5, fell_at=6.0, min_foot_separation=-0.1),
    }
    return GridOutcome(SMALL, {cell: kinds[fate] for cell, fate in zip(SMALL.cells, fates, strict=False)})


def test_verdicts():
    assert _outcome("stood", "stood", "stood", "stood").verdict() == "pass"
    assert _outcome("stood", "stood", "fell", "fell").verdict() == "pass"
    assert _outcome("stood", "fell", "fell", "fell").verdict() == "miss"
    assert _outcome("stood", "stood").verdict() == "not run"
    assert _outcome("fell", "fell", "fell").verdict() == "miss"  # whatever the last one does


def test_separation_is_judged_over_survivors():
    tight = GridOutcome(GRID, dict.fromkeys(GRID.cells, made_up_summary(pushed_at=4.5, min_foot_separation=0.03)))
    assert tight.verdict() == "miss"
    assert _outcome("stood", "fell").closest == (0.08, Cell(0, 0))


def test_a_document_says_what_fell_where_and_why():
    document = _outcome("stood", "fell", "stood").document()
    assert document["survival_time"] == [[10.0, pytest.approx(1.5)], [10.0, None]]
    assert (document["survived"], document["run"], document["total"], document["least"]) == (2, 3, 4, 2)
    assert document["first_limits"] == {"torque of left_knee saturated": 1}
    (fall,) = document["falls"]
    assert (fall["direction_deg"], fall["phase"], fall["reason"]) == (0.0, 0.5, REASON)


def test_the_first_limit_of_a_fall():
    assert first_limit(REASON) == "torque of left_knee saturated"
    assert first_limit("simulation diverged; no limit was hit in the 1.5 s before") == "simulation diverged"


@pytest.mark.parametrize("largest", [0.4, 7.0, 15.0, 16.2, 33.3, 80.0])
def test_bisection_finds_the_largest(largest):
    search, tries = Search(replace(GRID, directions=1)), 0
    while (impulse := search.next_impulse(0)) is not None:
        search.learn(0, impulse, impulse <= largest)
        tries += 1
    assert search.low[0] <= largest < search.high[0] <= search.low[0] + search.resolution
    assert tries <= 12
    assert search.everywhere == search.low[0]


def test_after_one_fall_the_other_phases_are_not_pushed(tmp_path, monkeypatch):
    """Above 20 N·s the robot falls at the third of four phases."""
    pushed = []

    def fake(scenario, **_):
        (push,) = scenario.pushes
        pushed.append((np.linalg.norm(push.impulse), push.phase))
        fell = pushed[-1][0] > 20.0 and push.phase == 0.5
        return Episode(made_up_summary(pushed_at=4.5, fell_at=6.0 if fell else None), None, False)

    monkeypatch.setattr(episodes, "run_episode", fake)
    grid = replace(GRID, directions=1, phases=4)
    (search,), interrupted = search_largest([grid], robot(), Store(tmp_path), 1, lambda *_: None, 1.0)
    assert (search.low, search.high, interrupted) == ([20.0], [21.0], False)
    tried = {impulse: [phase for size, phase in pushed if size == impulse] for impulse, _ in pushed}
    assert all(phases == [0.0, 0.25, 0.5, 0.75][: 4 if impulse < 20.5 else 3] for impulse, phases in tried.items())


def test_an_interrupted_search_tells_what_it_knows_and_not_more(tmp_path, monkeypatch):
    """All phases of direction 0 stood, one of direction 1 fell before the end, direction 2 is not decided."""
    from gaitsmith.experiments import largest, pushing

    grid = replace(GRID, directions=3, phases=2)
    outcomes = {Cell(0, 0): None, Cell(0, 1): None, Cell(1, 0): 6.0, Cell(2, 0): None}
    found = {grid.scenario(cell): made_up_summary(pushed_at=4.5, fell_at=fell) for cell, fell in outcomes.items()}
    monkeypatch.setattr(largest, "run_all", lambda *_, **__: Episodes(found, interrupted=True, resumed=0))
    monkeypatch.setattr(pushing, "load_set", lambda *_: TrialSet("made_up", robot(), (), (grid,), {}))
    options = PushOptions(largest=True, directions=3, phases=2, out=str(tmp_path))
    result = push_grids(options)
    (search,) = result.document["largest"]
    assert (search["survived"], search["failed"]) == ([15.0, 0.0, None], [None, 15.0, None])
    assert search["everywhere"] is None
    assert result.rows[0][1:] == ("unknown", "0°: ≥ 15, 120°: ≥ 0, 240°: unknown")
    assert result.interrupted
    assert "interrupted" in result.notes[-1]


def test_the_bracket_shrinks_with_the_robot():
    large, small = resolution_for(robot()), resolution_for(load_robot("thbip_ii"))
    assert (large, small) == (1.0, 0.2)


def test_a_strength_is_an_impulse_over_mass_and_leg(tmp_path):
    result = push_grids(PushOptions(strength=0.1, height=0.66, directions=1, phases=1, out=str(tmp_path)))
    expected = 0.1 * robot().mass * math.sqrt(9.81 * 0.66)
    assert result.document["grids"][0]["impulse"] == pytest.approx(expected, abs=1e-3)


def test_bisection_ends_at_the_ceiling():
    search = Search(replace(GRID, directions=1))
    while (impulse := search.next_impulse(0)) is not None:
        search.learn(0, impulse, True)
    assert (search.low[0], search.high[0]) == (search.ceiling, None)


def test_a_tiny_grid_really_runs_and_is_not_repeated(tmp_path):
    told = []
    options = PushOptions(impulse=2.0, height=0.66, directions=2, phases=1, out=str(tmp_path))
    first = push_grids(options, progress=lambda *what: told.append(what))
    assert first.columns == ("pushes", "target", "survived", "separation", "verdict")
    assert told[-1] == (2, 2, "pushing")
    (grid,) = first.document["grids"]
    assert (grid["run"], grid["total"], grid["verdict"]) == (2, 2, "report")
    assert (tmp_path / "push.json").is_file()
    again = push_grids(options)
    assert again.document == first.document
    assert "2 of 2 episodes found" in again.notes[0]


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"preset": "none"}, "preset"),
        ({"impulse": math.nan}, "impulse"),
        ({"impulse": -3.0}, "impulse"),
        ({"height": 9.0}, "height"),
        ({"period": -1.0}, "period"),
        ({"speed": math.inf}, "speed"),
        ({"strength": 0.0}, "strength"),
        ({"set": "none"}, "set"),
        ({"directions": 0}, "directions"),
        ({"phases": 999}, "phases"),
    ],
)
def test_options_that_cannot_be_used_are_named(tmp_path, options, field):
    with pytest.raises(BadInput) as caught:
        push_grids(checked(PushOptions, options | {"out": str(tmp_path)}))
    assert caught.value.field.removeprefix("--") == field


def test_grids_outside_the_card_s_limits_are_skipped(tmp_path, monkeypatch):
    from gaitsmith.experiments import pushing

    grid = PushGrid(15.0, make_scenario({"height": 0.9, "period": 0.4}))
    monkeypatch.setattr(pushing, "load_set", lambda *_: TrialSet("made_up", robot(), (), (grid,), {}))
    result = push_grids(PushOptions(out=str(tmp_path)))
    assert result.rows == (("15 N·s, T 0.4 s, H 0.9 m, in place", "", "", "", "skipped"),)
    assert result.notes[0].startswith("nothing was run")
    assert "height 0.9" in result.notes[1]


@pytest.mark.parametrize("largest", [False, True])
def test_one_grid_pushes_a_gait_file_as_it_is(tmp_path, monkeypatch, largest):
    from gaitsmith.experiments import pushing

    seen = []
    monkeypatch.setattr("gaitsmith.experiments.sets.completed", lambda fields: dict(fields) | {"duration": 20.0})
    monkeypatch.setattr(pushing, "why_unfit", lambda *_: "")
    monkeypatch.setattr(pushing, "_run_grids", lambda grids, *_: seen.extend(grids) or ([], [], False))
    monkeypatch.setattr(pushing, "search_largest", lambda grids, *_: seen.extend(grids) or ([], False))
    options = PushOptions(gait="gait.json", impulse=3.0, largest=largest, out=str(tmp_path))
    assert push_grids(options).document["set"] == "planned"
    ((impulse, base),) = [(grid.impulse, grid.base) for grid in seen]
    assert (impulse, base.gait, base.speed, base.height, base.period) == (3.0, ("gait.json",), None, None, None)
