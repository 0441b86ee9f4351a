"""Arms follow a commanded posture while the legs walk: smoothly, within their limits, all of a command at once."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.control.walking import DT, Loop, robot

from gaitsmith.errors import BadInput

NAME = "with_arms"
RAISED = {"left_shoulder_pitch": -1.2, "right_elbow": -1.5}


def index(joint: str) -> int:
    return robot(NAME).joint_names.index(joint)


def test_arms_follow_while_the_robot_walks_and_a_reset_takes_them_home() -> None:
    loop = Loop(NAME)
    loop.controller.command(speed=(0.1, 0.0))
    loop.controller.walk()
    loop.run(500)
    before = np.array([loop.controller.reference.joint[0, index(joint)] for joint in RAISED])
    loop.controller.posture(RAISED, rates={"left_shoulder_pitch": 1.0})
    references = []
    for _ in range(2500):
        loop.step()
        references.append([loop.controller.reference.joint[0, index(joint)] for joint in RAISED])
    moved = np.array(references)
    rates = np.diff(np.vstack([before, moved]), axis=0) / DT
    assert np.abs(rates[:, 0]).max() == pytest.approx(1.0, abs=1e-6)
    assert np.abs(rates[:, 1]).max() <= robot(NAME).velocity_limit[index("right_elbow")] + 1e-9
    assert np.abs(np.diff(rates, axis=0)).max() < 0.5  # rad/s a tick: no jump of speed
    reached = [loop.controller.telemetry.joint_position[index(joint)] for joint in RAISED]
    assert reached == pytest.approx(list(RAISED.values()), abs=0.05)
    assert loop.controller.state == "walking"
    loop.restart()
    loop.step()
    assert loop.controller.reference.joint[0, index("left_shoulder_pitch")] == pytest.approx(
        robot(NAME).home[index("left_shoulder_pitch")]
    )


def test_a_command_is_taken_over_whole_or_not_yet() -> None:
    loop = Loop(NAME)
    loop.controller.posture(RAISED)
    letters, goal = loop.groups.control.letters, loop.groups.template.posture.goal
    letters[0] += 1
    loop.step()
    assert not np.isin(goal[0], list(RAISED.values())).any()
    letters[0] += 1
    loop.step()
    assert [goal[0, index(joint)] for joint in RAISED] == list(RAISED.values())


@pytest.mark.parametrize(
    ("angles", "rates", "named"),
    [
        ({"left_knee": 0.5}, {}, "outside the legs"),
        ({"tail": 0.5}, {}, "outside the legs"),
        ({"right_elbow": 0.5}, {}, "-2.5 to 0 rad"),
        ({"right_elbow": float("nan")}, {}, "-2.5 to 0 rad"),
        ({"right_elbow": True}, {}, "-2.5 to 0 rad"),
        ({"right_elbow": -0.5}, {"right_elbow": 9.0}, "0 to 8 rad/s"),
    ],
)
def test_bad_postures_are_refused_and_change_nothing(angles: Any, rates: Any, named: str) -> None:
    loop = Loop(NAME)
    with pytest.raises(BadInput, match=named) as caught:
        loop.controller.posture({"left_elbow": -0.3} | angles, rates)
    assert "\n" not in str(caught.value)
    assert not np.isin(loop.groups.template.posture.mailbox[0], -0.3).any()
