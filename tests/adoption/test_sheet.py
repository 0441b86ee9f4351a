"""A sheet's ends are values that walked; the search for them is a bisection that ends."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from tests.experiments.made_up import made_up_stage, made_up_summary

from gaitsmith.adoption import sheet
from gaitsmith.adoption.sheet import Bracket, measure, reserves, walks
from gaitsmith.adoption.trials import walked
from gaitsmith.experiments.episodes import Episodes
from gaitsmith.experiments.result import silent
from gaitsmith.experiments.store import Store
from gaitsmith.robots import load_robot
from gaitsmith.simulation import Scenario

ROBOT = load_robot("thbip_ii")


@pytest.mark.parametrize("edge", [0.11, 0.27, 0.39, 0.5])
def test_a_bracket_ends_at_a_value_that_walked(edge: float) -> None:
    bracket = Bracket("speed_x", 1, 0.1, 0.4)
    tried = []
    while (value := bracket.next()) is not None:
        tried.append(value)
        bracket.learn(value, value <= edge)
    assert 0.1 <= bracket.inside <= edge
    assert bracket.inside in (0.1, *tried)
    assert len(tried) <= 1 + sheet._ROUNDS
    assert edge - bracket.inside <= 0.3 / 2**sheet._ROUNDS or bracket.inside == 0.4


def test_the_sheet_lies_within_what_walked_and_within_the_cards_limits(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def run(scenarios: Sequence[Scenario], *_: Any, **__: Any) -> Episodes:
        fell = made_up_summary(fell_at=2.0)
        return Episodes({s: made_up_summary() if abs(s.speed[0]) <= 0.2 else fell for s in scenarios}, False, 0)

    monkeypatch.setattr(sheet, "run_all", run)
    monkeypatch.setattr(sheet, "_pushes", lambda *_: {"forward": 1.0})
    found = measure(ROBOT, "thbip_ii", Store(tmp_path), 1, silent)
    assert set(found) == {"speed_x", "speed_y", "yaw_rate", "height", "period", "push"}
    limits = ROBOT.card.gait_limits
    for part in ("speed_y", "yaw_rate", "height", "period"):
        assert found[part] == pytest.approx(getattr(limits, part), abs=1e-3)
    assert -0.2 <= found["speed_x"][0] <= 0.0 < 0.1 <= found["speed_x"][1] <= 0.2


def test_heights_out_of_the_legs_reach_are_not_tried(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    asked = []

    def run(scenarios: Sequence[Scenario], *_: Any, **__: Any) -> Episodes:
        asked.extend(scenarios)
        return Episodes(dict.fromkeys(scenarios, made_up_summary()), False, 0)

    low, high = ROBOT.card.gait.height - 0.02, ROBOT.card.gait.height
    monkeypatch.setattr(sheet, "run_all", run)
    monkeypatch.setattr(sheet, "in_reach", lambda robot, height, width: low <= height <= high)
    monkeypatch.setattr(sheet, "_pushes", lambda *_: {})
    found = measure(ROBOT, "thbip_ii", Store(tmp_path), 1, silent)
    assert all(low <= scenario.height <= high for scenario in asked if scenario.height is not None)
    assert low <= found["height"][0] < found["height"][1] <= high


def test_a_walk_that_falls_slips_or_turns_away_is_none() -> None:
    assert walks(made_up_summary())
    assert not walks(made_up_summary(fell_at=3.0))
    assert not walks(made_up_summary(stages=(made_up_stage(vx_error=-0.1),)))
    assert not walks(made_up_summary(stages=(made_up_stage(yaw_rate_error=0.3),)))
    standing = made_up_stage(vx_mean=0.001, vx_error=-0.099)
    assert not walked(made_up_summary(stages=(standing,))).ok
    assert walked(made_up_summary()).ok


def test_reserves_are_those_of_the_worst_joint() -> None:
    joints = [name for leg in ROBOT.legs for name in leg.joints]
    peaks = dict.fromkeys(ROBOT.joint_names, 0.0) | {
        joints[2]: 0.25 * ROBOT.torque_limit[ROBOT.joint_names.index(joints[2])]
    }
    found = reserves(ROBOT, made_up_summary(torque_peak=peaks, velocity_peak=dict.fromkeys(ROBOT.joint_names, 0.0)))
    assert found == {"torque_reserve": 0.75, "velocity_reserve": 1.0}
