"""A mirrored robot in a mirrored world gets mirrored torques."""

from __future__ import annotations

import mujoco
import numpy as np
import numpy.typing as npt
import pytest
from tests.control.walking import ROBOTS, Loop, gait, parameters

from gaitsmith.control import Controller
from gaitsmith.robots import Robot

Array = npt.NDArray[np.float64]

MIRRORED = 1e-6  # of the torque limit: the QP magnifies rounding 1e8 times, and 1.5 s of it add up
ACROSS = np.array([1.0, -1.0, 1.0])  # a position, mirrored in the plane y = 0
ABOUT = np.array([-1.0, 1.0, -1.0])  # a rotation


def mirror_of_joints(robot: Robot) -> tuple[list[int], Array]:
    """For each joint the one on the other side, and the sign between the two."""
    names = list(robot.joint_names)
    swapped = {name: name.replace("left", "*").replace("right", "left").replace("*", "right") for name in names}
    data = mujoco.MjData(robot.model)
    mujoco.mj_kinematics(robot.model, data)
    axes = [data.xaxis[robot.model.dof_jntid[dof]] for dof in robot.joint_dofs]
    partners = [names.index(swapped[name]) for name in names]
    return partners, np.array([np.sign((axes[j] * ABOUT) @ axes[k]) for j, k in enumerate(partners)])


def feed_mirrored(source: Controller, target: Controller, partners: list[int], sign: Array) -> None:
    """Give ``target`` the mirror image of what ``source`` measures."""
    seen, given = source.measurement, target.measurement
    given.base_position[:] = ACROSS * seen.base_position
    given.base_quaternion[:] = seen.base_quaternion * [1.0, *ABOUT]
    given.base_velocity[:] = seen.base_velocity * [*ACROSS, *ABOUT]
    given.joint_position[:] = sign * seen.joint_position[partners]
    given.joint_velocity[:] = sign * seen.joint_velocity[partners]
    given.accelerometer[:] = ACROSS * seen.accelerometer
    given.gyro[:] = ABOUT * seen.gyro
    given.sole_force[:] = seen.sole_force[::-1]


@pytest.mark.parametrize("name", ROBOTS)
def test_mirrored_walk(name: str) -> None:
    """1.5 s of standing, starting to the left or to the right, walking forward and sideways."""
    loop = Loop(name, speed=(0.1, 0.05))
    mirror = Controller(loop.robot, parameters(name), gait=gait(name, speed=(0.1, -0.05)))
    mirror.reset()
    partners, sign = mirror_of_joints(loop.robot)
    limit = float(np.max(loop.robot.torque_limit))
    for tick in range(1500):
        if tick == 100:
            loop.controller.walk()
            mirror.walk()
        torque = loop.step()
        feed_mirrored(loop.controller, mirror, partners, sign)
        expected = sign * torque[partners]
        np.testing.assert_allclose(mirror.tick(), expected, rtol=0.0, atol=MIRRORED * limit, err_msg=f"tick {tick}")
    assert loop.controller.telemetry.step_count[0] >= 3
    assert mirror.telemetry.stance[0] == 1.0 - loop.controller.telemetry.stance[0]
