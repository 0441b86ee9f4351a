"""The paper's references as printed: BHR-B2's preset ``paper`` walks with them, and each is what the paper prints."""

import numpy as np
import pytest
from tests.control.walking import DT, Loop, parameters

from gaitsmith.control.state import Tick
from gaitsmith.whole_body.reference import HIPS, WORLD

SPEED, TICKS = 0.4, 4000
UPRIGHT = 0.02  # rad


def walked(ticks: int, **printed: bool) -> Loop:
    """BHR-B2 with the preset ``paper`` and some references more, after some ticks of a walk from the first on."""
    loop = Loop("bhr_b2", parameters("bhr_b2", "paper", printed=printed), speed=(SPEED, 0.0))
    loop.controller.walk()
    loop.run(ticks)
    return loop


def swing_of(groups: Tick) -> int:
    return int(groups.body.legs.other[groups.template.step.stance[0]])


def test_the_robot_walks_with_the_papers_curves() -> None:
    loop = walked(TICKS)
    frames = loop.groups.body.frames
    assert np.abs(frames.tilt).max() < UPRIGHT
    assert loop.plant.com[0] / (TICKS * DT) == pytest.approx(SPEED, rel=0.3)
    assert loop.groups.template.step.count[0] > 8


def test_the_stance_sole_is_told_where_to_be() -> None:
    """Eqs. 8 and 9: not where it is, but where the curve says; the difference is lost to the torso's posture."""
    groups = walked(1630).groups
    stance, step = int(groups.template.step.stance[0]), groups.template.step
    told, there = step.foot_desired[stance, 0], groups.body.frames.relative_position[stance]
    assert np.abs(told - there)[:2].max() > 5e-3
    assert abs(told[2] - there[2]) < 5e-3


def test_the_joints_reference_is_one_increment_from_where_they_are() -> None:
    """Section 4.1: q^d = q + Δq."""
    groups = walked(1630).groups
    legs, reference = groups.body.legs, groups.reference
    for leg in range(2):
        for joint in legs.joints[leg]:
            gone = reference.joint[0, joint] - groups.body.q[7 + joint]
            assert gone == pytest.approx(reference.joint[1, joint] * DT, abs=1e-9)


@pytest.mark.parametrize("inertial", [False, True])
def test_the_swing_soles_acceleration_is_relative_or_inertial(inertial: bool) -> None:
    """Eq. 19 either way asks for the same place and velocity; eq. 20 as printed adds no acceleration."""
    groups = walked(800, swing_frame=inertial).groups
    leg, frames, reference = swing_of(groups), groups.body.frames, groups.reference
    assert reference.sole_frame[leg] == (WORLD if inertial else HIPS)
    assert not np.any(reference.sole_acceleration[leg])
    place, velocity = groups.template.step.foot_desired[leg, :2]
    if inertial:
        turn = np.array([[frames.cos_yaw[0], -frames.sin_yaw[0], 0.0], [frames.sin_yaw[0], frames.cos_yaw[0], 0.0]])
        turn = np.vstack([turn, [0.0, 0.0, 1.0]])
        place, velocity = frames.hip_position + turn @ place, frames.hip_velocity + turn @ velocity
    np.testing.assert_allclose(reference.sole_position[leg], place, atol=1e-12)
    np.testing.assert_allclose(reference.sole_velocity[leg], velocity, atol=1e-12)
