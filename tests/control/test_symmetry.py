"""A mirrored robot in a mirrored world gets mirrored torques; a turned one gets the same."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import numpy.typing as npt
import pytest
from tests.control.walking import ROBOTS, Loop, gait, parameters

from gaitsmith.control import Controller
from gaitsmith.robots import Robot

Array = npt.NDArray[np.float64]

SAME = 1e-5  # of the torque limit: the QP magnifies rounding, and 2 s of it add up
ACROSS = np.array([1.0, -1.0, 1.0])  # a position, mirrored in the plane y = 0
ABOUT = np.array([-1.0, 1.0, -1.0])  # a rotation
TICKS = 2000

names = pytest.mark.parametrize("name", ROBOTS)


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
    given.sole_force[:] = seen.sole_force[::-1]


@names
def test_mirrored_walk(name: str) -> None:
    """Standing, shifting the weight, starting to one side or the other, walking forward, sideways and in a bend."""
    turn = 0.2 if name != "bhr_b2" else 0.0
    loop = Loop(name, speed=(0.1, 0.05), yaw_rate=turn)
    mirror = Controller(loop.robot, parameters(name), gait=gait(name, speed=(0.1, -0.05), yaw_rate=-turn))
    partners, sign = mirror_of_joints(loop.robot)
    limit = float(np.max(loop.robot.torque_limit))
    for tick in range(TICKS):
        if tick == 100:
            loop.controller.walk()
            mirror.walk()
        torque = loop.step()
        feed_mirrored(loop.controller, mirror, partners, sign)
        expected = sign * torque[partners]
        np.testing.assert_allclose(mirror.tick(), expected, rtol=0.0, atol=SAME * limit, err_msg=f"tick {tick}")
    assert loop.controller.telemetry.step_count[0] >= 3
    assert mirror.telemetry.stance[0] == 1.0 - loop.controller.telemetry.stance[0]


@names
@pytest.mark.parametrize("yaw", [-2.0, 3.0])
def test_turned_walk(name: str, yaw: float) -> None:
    """The same robot seen by a map that is turned and shifted gets the same torques; its heading passes through π."""
    turn = 0.2 if name != "bhr_b2" else 0.0
    loop = Loop(name, speed=(0.1, 0.05), yaw_rate=turn)
    other = Controller(loop.robot, parameters(name), gait=loop.gait)
    c, s = math.cos(yaw), math.sin(yaw)
    rotation, half = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]), 0.5 * yaw
    limit = float(np.max(loop.robot.torque_limit))
    for tick in range(TICKS):
        if tick == 100:
            loop.controller.walk()
            other.walk()
        torque = loop.step()
        seen, given = loop.controller.measurement, other.measurement
        for field in ("joint_position", "joint_velocity", "sole_force"):
            getattr(given, field)[:] = getattr(seen, field)
        given.base_position[:] = rotation @ seen.base_position + [3.0, -2.0, 0.0]
        given.base_velocity[:] = np.append(rotation @ seen.base_velocity[:3], seen.base_velocity[3:])
        w, x, y, z = seen.base_quaternion
        ch, sh = math.cos(half), math.sin(half)
        given.base_quaternion[:] = ch * w - sh * z, ch * x - sh * y, ch * y + sh * x, ch * z + sh * w
        np.testing.assert_allclose(other.tick(), torque, rtol=0.0, atol=SAME * limit, err_msg=f"tick {tick}")
    assert loop.controller.telemetry.step_count[0] >= 3
