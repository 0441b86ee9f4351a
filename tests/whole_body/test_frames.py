"""Frames of a tick against MuJoCo and finite differences, on the states of a walk."""

from __future__ import annotations

import mujoco
import numpy as np
import numpy.typing as npt
import pytest
from tests.control.walking import ROBOTS, records, robot
from tests.reference.rigid_body import RigidBody

Array = npt.NDArray[np.float64]

ORACLE = 1e-9  # relative, two ways to compute the same
STEP = 1e-6  # s, central differences
DIFFERENCE = 1e-6  # m/s and rad/s, their truncation and rounding on a walking robot

names = pytest.mark.parametrize("name", ROBOTS)


def close(actual: Array, expected: Array) -> None:
    scale = max(1.0, float(np.max(np.abs(expected))))
    np.testing.assert_allclose(actual, expected, rtol=0.0, atol=ORACLE * scale)


@names
def test_agrees_with_mujoco(name: str) -> None:
    """Heading, tilt, hip midpoint, soles, Jacobians, velocity products."""
    body = RigidBody(robot(name))
    for record in records(name):
        frames, control = record.groups.frames, record.groups.control
        now = body.at(control.q, control.v)
        yaw, c, s, rate = frames.heading
        close(np.array([c, s, np.cos(yaw), np.sin(yaw)]), np.tile(now.heading[:2, 0], 2))
        close(rate, now.turning[2])
        close(frames.tilt, np.array([*now.tilt, *now.turning[:2]]))
        close(frames.hip_position, now.hip.position)
        close(frames.hip_jacobian, now.hip.jacobian)
        close(frames.hip_bias, now.hip.bias)
        close(frames.com_velocity, now.com_velocity)
        for leg, sole in enumerate(now.soles):
            close(frames.sole_position[leg], sole.position)
            close(frames.sole_rotation[leg], sole.rotation)
            close(frames.sole_jacobian[leg], sole.jacobian)
            close(frames.sole_bias[leg], sole.bias)
            close(frames.relative[leg], now.offset(leg))
            close(frames.sole_pitch[leg], now.pitch(leg))
            close(frames.contact_rotation[leg], now.contact_axes(leg, robot(name).legs[leg].sole.half_width))


@names
def test_sole_frames_are_the_model_sites(name: str) -> None:
    """The sole frame is the site that the card names."""
    data = mujoco.MjData(robot(name).model)
    for record in records(name)[::20]:
        data.qpos[:] = record.groups.control.q
        mujoco.mj_kinematics(robot(name).model, data)
        for leg in range(2):
            site = data.site(robot(name).legs[leg].sole_site)
            close(record.groups.frames.sole_position[leg], site.xpos)
            close(record.groups.frames.sole_rotation[leg], site.xmat.reshape(3, 3))


@names
def test_rates_by_finite_differences(name: str) -> None:
    """Tilt rates and relative velocities, in the heading frame held still."""
    body, model = RigidBody(robot(name)), robot(name).model
    for record in records(name)[::10]:
        control, frames = record.groups.control, record.groups.frames
        now = body.at(control.q, control.v)
        ends = []
        for sign in (-1.0, 1.0):
            q = control.q.copy()
            mujoco.mj_integratePos(model, q, control.v, sign * STEP)
            ends.append(body.at(q, control.v))
        for leg in range(2):
            offsets = [now.in_heading(end.soles[leg].position - end.hip.position) for end in ends]
            rate = (offsets[1] - offsets[0]) / (2.0 * STEP)
            np.testing.assert_allclose(frames.relative[leg, 1], rate, atol=DIFFERENCE * 10.0)
        com = [now.in_heading(end.com.position) for end in ends]
        np.testing.assert_allclose(frames.com_velocity, (com[1] - com[0]) / (2.0 * STEP), atol=DIFFERENCE * 10.0)


@names
def test_contact_frames_are_right_handed(name: str) -> None:
    """Orthonormal; a line sole's y axis is level, for its edge cannot roll."""
    for record in records(name):
        for leg in range(2):
            axes = record.groups.frames.contact_rotation[leg]
            close(axes.T @ axes, np.eye(3))
            close(np.linalg.det(axes), np.array(1.0))
            close(axes[:, 0], record.groups.frames.sole_rotation[leg, :, 0])
            if robot(name).legs[leg].sole.half_width == 0.0:
                assert axes[2, 1] == 0.0


@names
def test_constants_of_the_legs(name: str) -> None:
    """Each joint belongs to one leg or to none; a positive ankle torque with sign +1 presses the toe down."""
    legs = records(name)[0].groups.legs
    for row, leg in enumerate(robot(name).legs):
        assert set(np.flatnonzero(legs.leg_of_joint == row)) == set(leg.joint_indices)
        axis = robot(name).model.jnt_axis[robot(name).model.dof_jntid[6 + leg.ankle_pitch]]
        assert legs.ankle_sign[row] == np.sign(axis[1])
