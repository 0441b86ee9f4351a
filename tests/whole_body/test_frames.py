"""Frames of a tick against MuJoCo and finite differences, in any state."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import numpy.typing as npt
import pytest
from tests.control.walking import ROBOTS, robot
from tests.whole_body.bodies import Body, Engine, moving

from gaitsmith.whole_body.reference import level_rotation

Array = npt.NDArray[np.float64]

ORACLE = 1e-9  # two ways to compute the same
STEP = 1e-6  # s, central differences
DIFFERENCE = 1e-6  # m/s and rad/s, their truncation and rounding

states = pytest.mark.parametrize(("name", "seed"), [(name, seed) for name in ROBOTS for seed in range(4)])


def heading(torso: Array) -> Array:
    """Heading axes as columns: the world turned by the torso's yaw."""
    yaw = math.atan2(torso[1, 0], torso[0, 0])
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


@states
def test_agrees_with_the_engine(name: str, seed: int) -> None:
    """Heading, tilt, hip midpoint, soles, Jacobians, velocity products."""
    q, v = moving(name, seed)
    frames, engine, machine = Body(name).place(q, v).frames, Engine(name, q, v), robot(name)
    torso = engine.data.xmat[machine.torso_body].reshape(3, 3)
    axes = heading(torso)
    np.testing.assert_allclose([frames.cos_yaw[0], frames.sin_yaw[0]], axes[:2, 0], atol=ORACLE)
    level = axes.T @ torso  # Ry(pitch) Rx(roll)
    pitch = math.asin(-level[2, 0])
    roll = math.atan2(level[2, 1], level[2, 2])
    np.testing.assert_allclose(frames.tilt, [roll, pitch], atol=ORACLE)
    hip = engine.data.xpos[machine.torso_body] + torso @ machine.hip_midpoint
    jacobian, bias = engine.point(machine.torso_body, hip)
    np.testing.assert_allclose(frames.hip_position, hip, atol=ORACLE)
    np.testing.assert_allclose(frames.hip_jacobian, jacobian, atol=ORACLE)
    np.testing.assert_allclose(frames.hip_bias, bias, atol=ORACLE)
    np.testing.assert_allclose(frames.hip_velocity, jacobian[:3] @ v, atol=ORACLE)
    np.testing.assert_allclose(frames.torso_spin, jacobian[3:] @ v, atol=ORACLE)
    np.testing.assert_allclose(frames.tilt_rate, (axes.T @ jacobian[3:] @ v)[:2], atol=ORACLE)
    assert frames.yaw_rate[0] == pytest.approx((jacobian[3:] @ v)[2], abs=ORACLE)
    com = engine.data.subtree_com[machine.torso_body]
    np.testing.assert_allclose(frames.com_offset, (axes.T @ (com - hip))[:2], atol=ORACLE)
    for leg in range(len(machine.legs)):
        sole = engine.sole(leg)
        np.testing.assert_allclose(frames.sole_position[leg], sole.position, atol=ORACLE)
        np.testing.assert_allclose(frames.sole_rotation[leg], sole.rotation, atol=ORACLE)
        np.testing.assert_allclose(frames.sole_jacobian[leg], sole.jacobian, atol=ORACLE)
        np.testing.assert_allclose(frames.sole_bias[leg], sole.bias, atol=ORACLE)
        np.testing.assert_allclose(frames.sole_twist[leg], sole.jacobian @ v, atol=ORACLE)
        np.testing.assert_allclose(frames.relative_position[leg], axes.T @ (sole.position - hip), atol=ORACLE)
        ahead = axes.T @ sole.rotation[:, 0]
        assert frames.sole_pitch[leg] == pytest.approx(math.atan2(-ahead[2], ahead[0]), abs=ORACLE)
        assert frames.sole_yaw[leg] == pytest.approx(math.atan2(ahead[1], ahead[0]), abs=ORACLE)


@states
def test_rates_by_finite_differences(name: str, seed: int) -> None:
    """Relative and CoM velocities, in the heading frame held still."""
    q, v = moving(name, seed)
    now = Body(name).place(q, v)
    axes = heading(now.state.body_rotation[now.legs.torso[0]])
    ends = []
    for sign in (-1.0, 1.0):
        moved = q.copy()
        mujoco.mj_integratePos(robot(name).model, moved, v, sign * STEP)
        ends.append(Body(name).place(moved, v))
    for leg in range(now.n):
        places = [end.frames.sole_position[leg] - end.frames.hip_position for end in ends]
        rate = axes.T @ (places[1] - places[0]) / (2.0 * STEP)
        np.testing.assert_allclose(now.frames.relative_velocity[leg], rate, atol=DIFFERENCE)
    rate = axes.T @ (ends[1].state.com - ends[0].state.com) / (2.0 * STEP)
    np.testing.assert_allclose(now.frames.com_velocity, rate, atol=DIFFERENCE)


@pytest.mark.parametrize("name", ROBOTS)
def test_constants_of_the_legs(name: str) -> None:
    """Each joint belongs to one leg or to none; sides and partners are those of the card; arms hold home."""
    legs, machine = Body(name).legs, robot(name)
    for row, leg in enumerate(machine.legs):
        assert set(np.flatnonzero(legs.leg_of_joint == row)) == set(leg.joint_indices)
        assert legs.side[row] == leg.side == (1.0 if leg.name == "left" else -1.0)
        assert machine.legs[legs.other[row]].side == -leg.side
    np.testing.assert_array_equal(legs.home, machine.home)


@pytest.mark.parametrize(("yaw", "pitch"), [(0.0, 0.0), (0.7, 0.0), (0.0, 0.3), (-2.5, -0.4)])
def test_level_rotation_has_heading_and_pitch_but_no_roll(yaw: float, pitch: float) -> None:
    out = np.zeros((3, 3))
    level_rotation(math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch), out)
    turn = heading(np.array([[math.cos(yaw), 0, 0], [math.sin(yaw), 0, 0], [0, 0, 0]]))
    nod = np.array([[math.cos(pitch), 0, math.sin(pitch)], [0, 1, 0], [-math.sin(pitch), 0, math.cos(pitch)]])
    np.testing.assert_allclose(out, turn @ nod, atol=1e-15)
