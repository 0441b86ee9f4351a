"""The standing posture stands: soles flat on the ground, centre of mass above the ankles, joints within limits."""

import shutil
from pathlib import Path

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitsmith.errors import BadInput
from gaitsmith.kinematics.posture import standing_posture
from gaitsmith.robots import Robot, load_robot

PLACED = 1e-8  # m, soles and centre of mass
LEVEL = 1e-8  # slope of the sole along its length

MODELS = Path(__file__).resolve().parent.parent / "models"
ROBOTS = [load_robot(name) for name in ("bhr_b2", MODELS / "six_joint_legs.toml", MODELS / "with_arms.toml")]
robots = st.sampled_from(range(len(ROBOTS)))


@settings(max_examples=30)
@given(robots, st.floats(0.0, 1.0), st.floats(0.6, 1.3))
def test_soles_centre_of_mass_and_limits(index: int, share: float, spread: float) -> None:
    """At every height of the card's range, judged by MuJoCo."""
    robot = ROBOTS[index]
    low, high = robot.card.gait_limits.height
    height, width = low + share * (high - low), spread * robot.card.gait.width
    q = standing_posture(robot, height, width)
    data = mujoco.MjData(robot.model)
    data.qpos[:] = q
    mujoco.mj_fwdPosition(robot.model, data)
    torso = data.xmat[robot.torso_body].reshape(3, 3)
    hip = data.xpos[robot.torso_body] + torso @ robot.hip_midpoint
    np.testing.assert_allclose(torso, np.eye(3), atol=1e-15)
    for leg in robot.legs:
        sole = data.site(leg.sole_site)
        expected = [data.subtree_com[robot.torso_body][0], hip[1] + leg.side * width, 0.0]
        np.testing.assert_allclose(sole.xpos, expected, atol=PLACED)
        assert abs(sole.xmat[6]) <= LEVEL
        assert abs(sole.xmat[3]) <= LEVEL
    assert abs(hip[2] - height) <= PLACED
    assert np.all((q[7:] >= robot.position_low) & (q[7:] <= robot.position_high))


@pytest.mark.parametrize("robot", ROBOTS, ids=[robot.card.name for robot in ROBOTS])
def test_what_is_out_of_reach_is_named_with_its_range(robot: Robot) -> None:
    """Too high and too low name the height's range, and its ends are good; too wide names the width."""
    width = robot.card.gait.width
    for height in (0.02, 5.0):
        with pytest.raises(BadInput) as caught:
            standing_posture(robot, height, width)
        assert caught.value.field == "height"
        low, _, high, *_ = caught.value.valid.split()
        for end in (low, high):
            standing_posture(robot, float(end), width)
    with pytest.raises(BadInput, match="width"):
        standing_posture(robot, robot.card.gait.height, 3.0)


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -0.1, 0.0])
def test_nonsense_is_refused(value: float) -> None:
    """Neither height nor width accepts a number that is no length."""
    for arguments in ((value, 0.05), (0.6, value)):
        with pytest.raises(BadInput):
            standing_posture(ROBOTS[0], *arguments)


def test_limits_that_leave_no_flat_foot_are_named(tmp_path: Path) -> None:
    """An ankle that cannot level the sole is not a matter of width."""
    text = (MODELS / "six_joint_legs.toml").read_text()
    for side in ("left", "right"):
        text = text.replace(
            f"{side}_ankle_pitch = {{ position = [-1.6, 1.0]", f"{side}_ankle_pitch = {{ position = [0.9, 1.0]"
        )
        text = text.replace(
            f"{side}_hip_pitch = {{ position = [-2.0, 1.2]", f"{side}_hip_pitch = {{ position = [0.5, 1.2]"
        )
    assert "0.9, 1.0" in text
    (tmp_path / "card.toml").write_text(text)
    shutil.copy(MODELS / "six_joint_legs.xml", tmp_path)
    robot = load_robot(tmp_path)
    with pytest.raises(BadInput, match="no flat foot"):
        standing_posture(robot, robot.card.gait.height, robot.card.gait.width)
