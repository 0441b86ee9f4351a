"""Every task drives the motion to its own target, and is followed the closer the more it weighs."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from tests.whole_body.bodies import Body, Engine, moving, task
from tests.whole_body.test_frames import heading

from gaitsmith.whole_body.problem import JointBounds
from gaitsmith.whole_body.reference import FLAT, HEEL, HIPS, NONE, WORLD
from gaitsmith.whole_body.tasks import turn_error

Array = npt.NDArray[np.float64]

LIGHT, HEAVY = 1e-4, 1e6
FOLLOWED = 2e-3  # of what a light weight misses
STIFF, DAMPED = 60.0, 9.0  # 1/s², 1/s: of every task here
FREE = JointBounds(torque_step=np.inf, stop_rate=1e6)

turns = st.tuples(*[st.floats(-1.0, 1.0)] * 3)


class Row(NamedTuple):
    """A task under test.

    Attributes:
        field: of the table.
        kinds: contacts.
        ask: writes a reference that differs from the state in place, rate and acceleration.
        reach: target and achieved acceleration.
    """

    field: str
    kinds: tuple[int, int]
    ask: Callable[[Body, np.random.Generator], None]
    reach: Callable[[Body, Engine, Array], tuple[Array, Array]]


def axes(body: Body) -> Array:
    """Heading axes as columns."""
    return heading(body.state.body_rotation[body.legs.torso[0]])


def spring(error: Array, rate: Array, acceleration: Array) -> Array:
    """What a task with the stiffness and damping of these tests wants."""
    return acceleration + STIFF * error + DAMPED * rate


def turned(rotation: Array, rng: np.random.Generator) -> Array:
    """A rotation that differs by up to a third of a radian."""
    return Rotation.from_rotvec(rng.uniform(-0.2, 0.2, 3)).as_matrix() @ rotation


def turn_to(actual: Array, wanted: Array) -> Array:
    """sin θ times the axis, world, of the rotation from one to another."""
    vector = Rotation.from_matrix(wanted @ actual.T).as_rotvec()
    angle = float(np.linalg.norm(vector))
    return vector * (math.sin(angle) / angle if angle > 0.0 else 1.0)


def ask_sole(frame: int) -> Callable[[Body, np.random.Generator], None]:
    def ask(body: Body, rng: np.random.Generator) -> None:
        reference = body.reference
        here = body.frames.sole_position if frame == WORLD else body.frames.relative_position
        reference.sole_frame[:] = frame
        reference.sole_position[:] = here + rng.uniform(-0.1, 0.1, here.shape)
        reference.sole_velocity[:] = rng.uniform(-0.5, 0.5, here.shape)
        reference.sole_acceleration[:] = rng.uniform(-5.0, 5.0, here.shape)

    return ask


def reach_sole_world(body: Body, engine: Engine, acceleration: Array) -> tuple[Array, Array]:
    sole, reference = engine.sole(1), body.reference
    velocity = sole.jacobian[:3] @ body.v
    wanted = spring(
        reference.sole_position[1] - sole.position,
        reference.sole_velocity[1] - velocity,
        reference.sole_acceleration[1],
    )
    return wanted, (sole.jacobian @ acceleration + sole.bias)[:3]


def reach_sole_hips(body: Body, engine: Engine, acceleration: Array) -> tuple[Array, Array]:
    """All of it in the heading frame held still, relative to the hip midpoint."""
    sole, reference, to = engine.sole(1), body.reference, axes(body).T
    hip = body.frames.hip_position
    jacobian, bias = engine.point(body.robot.torso_body, hip)
    velocity = to @ ((sole.jacobian - jacobian)[:3] @ body.v)
    wanted = spring(
        reference.sole_position[1] - to @ (sole.position - hip),
        reference.sole_velocity[1] - velocity,
        reference.sole_acceleration[1],
    )
    return wanted, to @ ((sole.jacobian - jacobian) @ acceleration + sole.bias - bias)[:3]


def ask_sole_turn(body: Body, rng: np.random.Generator) -> None:
    reference = body.reference
    for leg in range(body.n):
        reference.sole_rotation[leg] = turned(body.frames.sole_rotation[leg], rng)
    reference.sole_spin[:] = rng.uniform(-0.5, 0.5, (body.n, 3))
    reference.sole_angular_acceleration[:] = rng.uniform(-5.0, 5.0, (body.n, 3))


def reach_sole_turn(body: Body, engine: Engine, acceleration: Array) -> tuple[Array, Array]:
    sole, reference = engine.sole(1), body.reference
    wanted = spring(
        turn_to(sole.rotation, reference.sole_rotation[1]),
        reference.sole_spin[1] - sole.jacobian[3:] @ body.v,
        reference.sole_angular_acceleration[1],
    )
    return wanted, (sole.jacobian @ acceleration + sole.bias)[3:]


def reach_edge_turn(body: Body, engine: Engine, acceleration: Array) -> tuple[Array, Array]:
    """About the edge, the sole's y axis, alone."""
    wanted, reached = reach_sole_turn(body, engine, acceleration)
    edge = engine.sole(1).rotation[:, 1]
    return np.array([edge @ wanted]), np.array([edge @ reached])


def ask_torso(body: Body, rng: np.random.Generator) -> None:
    reference = body.reference
    reference.torso_weight[:] = 1.0
    reference.torso_rotation[:] = turned(reference.torso_rotation, rng)
    reference.torso_spin[:] = rng.uniform(-0.5, 0.5, 3)
    reference.torso_angular_acceleration[:] = rng.uniform(-5.0, 5.0, 3)


def reach_torso(axis: int) -> Callable[[Body, Engine, Array], tuple[Array, Array]]:
    def reach(body: Body, engine: Engine, acceleration: Array) -> tuple[Array, Array]:
        reference, direction = body.reference, axes(body)[:, axis]
        jacobian, bias = engine.point(body.robot.torso_body, body.frames.hip_position)
        torso = engine.data.xmat[body.robot.torso_body].reshape(3, 3)
        wanted = spring(
            turn_to(torso, reference.torso_rotation),
            reference.torso_spin - jacobian[3:] @ body.v,
            reference.torso_angular_acceleration,
        )
        return np.array([direction @ wanted]), np.array([direction @ (jacobian @ acceleration + bias)[3:]])

    return reach


def ask_com(body: Body, rng: np.random.Generator) -> None:
    body.reference.com_weight[:] = 1.0
    body.reference.com[0] += rng.uniform(-0.1, 0.1, 3)
    body.reference.com[1:] = rng.uniform(-2.0, 2.0, (2, 3))


def reach_com(*rows: int) -> Callable[[Body, Engine, Array], tuple[Array, Array]]:
    def reach(body: Body, engine: Engine, acceleration: Array) -> tuple[Array, Array]:
        state, com, to = body.state, body.reference.com, axes(body).T
        wanted = to @ spring(com[0] - state.com, com[1] - state.com_velocity, com[2])
        reached = to @ (state.com_jacobian @ acceleration + state.com_bias)
        return wanted[list(rows)], reached[list(rows)]

    return reach


def ask_hips(body: Body, rng: np.random.Generator) -> None:
    body.reference.hip_height_weight[:] = 1.0
    body.reference.hip_height[:] = body.frames.hip_position[2] + 0.05, rng.uniform(-0.5, 0.5), rng.uniform(-5.0, 5.0)


def reach_hips(body: Body, engine: Engine, acceleration: Array) -> tuple[Array, Array]:
    height = body.reference.hip_height
    jacobian, bias = engine.point(body.robot.torso_body, body.frames.hip_position)
    error, rate = height[0] - body.frames.hip_position[2], height[1] - jacobian[2] @ body.v
    return np.array([spring(error, rate, height[2])]), np.array([jacobian[2] @ acceleration + bias[2]])


def ask_joints(body: Body, rng: np.random.Generator) -> None:
    body.reference.joint_weight[:] = 1.0
    body.reference.joint[0] += rng.uniform(-0.2, 0.2, body.nj)
    body.reference.joint[1:] = rng.uniform(-2.0, 2.0, (2, body.nj))


def reach_joints(leg: int) -> Callable[[Body, Engine, Array], tuple[Array, Array]]:
    def reach(body: Body, engine: Engine, acceleration: Array) -> tuple[Array, Array]:
        joint, own = body.reference.joint, np.flatnonzero(body.legs.leg_of_joint == leg)
        wanted = spring(joint[0] - body.q[7:], joint[1] - body.v[6:], joint[2])
        return wanted[own], acceleration[6:][own]

    return reach


ROWS = {
    "swing in the world": Row("swing", (FLAT, NONE), ask_sole(WORLD), reach_sole_world),
    "swing relative to the hips": Row("swing", (FLAT, NONE), ask_sole(HIPS), reach_sole_hips),
    "turn of a sole in the air": Row("swing_turn", (FLAT, NONE), ask_sole_turn, reach_sole_turn),
    "turn of a sole about its edge": Row("swing_turn", (FLAT, HEEL), ask_sole_turn, reach_edge_turn),
    **{name: Row(name, (FLAT, FLAT), ask_torso, reach_torso(k)) for k, name in enumerate(("roll", "pitch", "yaw"))},
    "com": Row("com", (FLAT, FLAT), ask_com, reach_com(0, 1)),
    "com height": Row("com_height", (FLAT, FLAT), ask_com, reach_com(2)),
    "hip height": Row("hip_height", (FLAT, FLAT), ask_hips, reach_hips),
    "leg joints": Row("leg_joint", (FLAT, NONE), ask_joints, reach_joints(1)),
    "other joints": Row("posture", (FLAT, NONE), ask_joints, reach_joints(-1)),
}


def missed(name: str, row: Row, seed: int, weight: float) -> float:
    """How far the motion that a QP without bounds finds is from the task's target."""
    quiet = {field: task(0.0) for field in ("swing", "swing_turn", "com", "com_height", "hip_height", "leg_joint")}
    body = Body(name, **{**quiet, row.field: task(weight, STIFF, DAMPED)}, cop=0.0)
    body.legs = body.legs._replace(torque_limit=np.full(body.nj, 1e6))
    body.bounds = body.bounds._replace(
        friction=1e3, normal_low=-1e6, normal_high=1e6, zmp_margin=-1e3, yaw_friction=1e3
    )
    body.joints = FREE
    body.legs = body.legs._replace(hip_midpoint=np.array([0.05, 0.02, -0.1]))
    q, v = moving(name, seed)
    v[3:6] *= 10.0
    row.ask(body.place(q, v), np.random.default_rng(seed))
    assert body.solve(*row.kinds)
    wanted, reached = row.reach(body, Engine(name, q, v), body.result.acceleration)
    return float(np.linalg.norm(reached - wanted))


@pytest.mark.parametrize("row", ROWS)
def test_a_task_is_followed_the_closer_the_more_it_weighs(row: str) -> None:
    """From hardly to exactly, in any state, for any error in place, rate and acceleration."""
    for seed in range(4):
        light, heavy = (missed("with_arms", ROWS[row], seed, weight) for weight in (LIGHT, HEAVY))
        assert heavy < FOLLOWED * light, seed


@pytest.mark.parametrize("name", ["bhr_b2", "thbip_ii"])
@pytest.mark.parametrize("share", [0.0, 1.0])
def test_a_weight_of_zero_switches_a_row_off(name: str, share: float) -> None:
    """The reference's weights multiply the table's: what they switch off may ask for anything."""
    results = []
    for wild in (0.0, 1e3):
        body = Body(name).place(*moving(name, 1))
        reference = body.reference
        for weights in (reference.torso_weight, reference.com_weight, reference.hip_height_weight):
            weights[:] = share
        reference.joint_weight[:] = reference.cop_weight[:] = share
        reference.com[2], reference.hip_height[2], reference.joint[2] = wild, wild, wild
        reference.torso_angular_acceleration[:], reference.cop[:] = wild, wild
        assert body.solve(FLAT, FLAT)
        results.append(body.result.torque.copy())
    assert np.allclose(*results, rtol=0.0, atol=1e-9) == (share == 0.0)


@given(turns, turns)
def test_turn_error_is_the_sine_of_the_turn(first: tuple[float, ...], second: tuple[float, ...]) -> None:
    """Along the axis of the rotation that brings one to the other, in world axes."""
    actual, wanted = Rotation.from_rotvec(first).as_matrix(), Rotation.from_rotvec(second).as_matrix()
    out = np.zeros(3)
    turn_error(actual, wanted, out)
    np.testing.assert_allclose(out, turn_to(actual, wanted), atol=1e-12)
