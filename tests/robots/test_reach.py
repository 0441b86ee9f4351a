"""Default heights are in reach."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.robots.samples import BHR, MODELS, build
from tests.robots.test_assumptions import short

from gaitsmith.errors import BadInput
from gaitsmith.kinematics.posture import standing_posture
from gaitsmith.robots import load_robot
from gaitsmith.robots.reach import heights

CARDS = [(BHR / "card.toml", BHR), (MODELS / "six_joint_legs.toml", MODELS), (MODELS / "with_arms.toml", MODELS)]


@pytest.mark.parametrize(("card", "folder"), CARDS)
def test_a_short_cards_heights_can_be_stood_at(card: Path, folder: Path) -> None:
    robot = build(short(card), folder)
    for height in (robot.card.gait.height, *robot.card.gait_limits.height):
        standing_posture(robot, height, robot.card.gait.width)


def test_ankles_that_hardly_bend_narrow_the_heights() -> None:
    stiff = {f"{side}_ankle": {"position": [-0.4, 0.3]} for side in ("left", "right")}
    robot, free = build(short() | {"limits": stiff}), build(short())
    low, high = robot.card.gait_limits.height
    assert low > free.card.gait_limits.height[0] + 0.05
    standing_posture(robot, low, robot.card.gait.width)
    standing_posture(robot, high, robot.card.gait.width)


def test_the_ends_are_where_the_postures_end() -> None:
    robot = load_robot(MODELS / "with_arms.toml")
    found = heights(robot.model, robot.legs, robot.card.limits, 0.39, robot.card.gait.width)
    assert found is not None
    for height, beyond in zip(found, (-0.02, 0.02), strict=True):
        standing_posture(robot, height - 0.1 * beyond, robot.card.gait.width)
        with pytest.raises(BadInput):
            standing_posture(robot, height + beyond, robot.card.gait.width)


def test_heights_of_a_card_that_are_out_of_reach_are_said() -> None:
    robot = build(
        short() | {"gait_limits": {"height": [0.2, 0.73]}, "limits": {"left_knee": {"position": [0.05, 1.5]}}}
    )
    assert [note for note in robot.notes if "soles are flat from" in note]
    assert not [note for note in load_robot("bhr_b2").notes if "soles are flat" in note]
