"""Inverse kinematics of one leg as a quadratic program per tick (Han 2023, eqs. 28-32).

The endpoint is the origin of the sole frame. The paper takes the sole's front edge so that the ankle enters the
position task; here the orientation task alone drives the ankle, and template, whole-body control, and touchdown all
speak of the same point.

Positions, velocities, and rotations are in the torso frame; the caller converts. The reference is integrated: each
step starts from the last reference, not from the measured joints, or the difference that eq. 27 feeds back would
vanish.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from gaitsmith.compiled import Cube, IntMatrix, IntVector, Matrix, Vector, kernel
from gaitsmith.errors import BadInput
from gaitsmith.kinematics.leg import LegKinematics as LegKinematics
from gaitsmith.kinematics.leg import leg_forward as leg_forward
from gaitsmith.kinematics.leg import make_leg_kinematics as make_leg_kinematics
from gaitsmith.qp.quadratic_program import OPTIMAL, QuadraticProgram, make_quadratic_program, solve

Array = npt.NDArray[np.float64]

_TRUST = 0.3  # rad, largest joint step of solve_leg
_ROUNDS = 100
_PRECISION = 1e-10  # m and rad
_STARTS = (0.4, 0.25, 0.6, 0.5)  # shares of the joint ranges to start from, should q0 lead nowhere


class InverseKinematics(NamedTuple):
    """Scratch of one leg with n joints; after a step, the pose that the step started from.

    Attributes:
        position: (3) sole frame's origin in the torso frame, m.
        rotation: (3, 3) sole frame to torso frame.
        jacobian: (6, n) linear, then angular, torso axes.
        task: (6, n) rows of the cost.
        error: (6) what the rows should amount to, m and rad.
    """

    position: Vector
    rotation: Matrix
    jacobian: Matrix
    task: Matrix
    error: Vector


class InverseGains(NamedTuple):
    """Gains of eqs. 28-32: k_IK (1/s), Q2 (above 0), Q3, and Q4 on the orientation about the axes the leg controls."""

    gain: float
    step_weight: float
    change_weight: float
    pitch_weight: float


class LegTable(NamedTuple):
    """:class:`LegKinematics` of all legs, one row each, and the active sets of their quadratic programs."""

    anchor: Cube
    axis: Cube
    slides: IntMatrix
    zero: Matrix
    sole_position: Matrix
    sole_rotation: Cube
    turning: IntMatrix
    lower: Matrix
    upper: Matrix
    velocity_limit: Matrix
    active: IntMatrix


def make_leg_table(chains: list[LegKinematics]) -> LegTable:
    """Table of legs with equal numbers of joints."""
    rows = [np.array([chain[k] for chain in chains]) for k in range(len(LegKinematics._fields))]
    shape = (len(chains), len(chains[0].zero))
    return LegTable(*rows, np.zeros(shape, dtype=np.int64))  # type: ignore[call-arg]


@kernel
def leg_row(table: LegTable, leg: int) -> LegKinematics:
    """One row of the table."""
    return LegKinematics(
        table.anchor[leg],
        table.axis[leg],
        table.slides[leg],
        table.zero[leg],
        table.sole_position[leg],
        table.sole_rotation[leg],
        table.turning[leg],
        table.lower[leg],
        table.upper[leg],
        table.velocity_limit[leg],
    )


def make_inverse_kinematics(n: int) -> InverseKinematics:
    """Scratch for a leg of n joints."""
    return InverseKinematics(np.zeros(3), np.zeros((3, 3)), np.zeros((6, n)), np.zeros((6, n)), np.zeros(6))


@kernel
def orientation_error(kin: LegKinematics, actual: Matrix, target: Matrix, out: Vector) -> None:
    """Turn (rad, sole axes) that brings the sole to its target about the axes that the leg controls; else zero.

    With pitch alone it is the turn about the sole's y axis that brings its x axis closest to the target's, so a roll
    or yaw that the leg cannot correct does not disturb the pitch. Otherwise it is the components of the rotation
    vector.
    """
    out[0] = out[1] = out[2] = 0.0
    axes = kin.turning[0] + kin.turning[1] + kin.turning[2]
    if axes == 1 and kin.turning[1] == 1:
        ahead = up = 0.0
        for i in range(3):
            ahead += actual[i, 0] * target[i, 0]
            up += actual[i, 2] * target[i, 0]
        out[1] = math.atan2(-up, ahead)
        return
    trace = 0.0
    for i in range(3):
        for j in range(3):
            trace += actual[i, j] * target[i, j]
        out[0] += 0.5 * (actual[i, 2] * target[i, 1] - actual[i, 1] * target[i, 2])
        out[1] += 0.5 * (actual[i, 0] * target[i, 2] - actual[i, 2] * target[i, 0])
        out[2] += 0.5 * (actual[i, 1] * target[i, 0] - actual[i, 0] * target[i, 1])
    sine = math.sqrt(out[0] ** 2 + out[1] ** 2 + out[2] ** 2)
    angle = math.atan2(sine, 0.5 * (trace - 1.0))
    for axis in range(3):
        out[axis] *= kin.turning[axis] * (angle / sine if sine > 1e-9 else 1.0)


@kernel
def leg_step(
    kin: LegKinematics,
    ik: InverseKinematics,
    qp: QuadraticProgram,
    active: IntVector,
    gains: InverseGains,
    reference: Vector,
    rate: Vector,
    target_position: Vector,
    target_velocity: Vector,
    target_rotation: Matrix,
    dt: float,
) -> int:
    """Advance the joint reference by one tick (eqs. 28-32).

    Minimises ‖J Δq - (v + k (p - p(q))) dt‖² + Q2 ‖Δq‖² + Q3 ‖Δq - Δq_last‖² + Q4 ‖J_θ Δq - θ‖² within the joints'
    position and velocity limits. A reference outside its position limits is moved onto them first.

    Args:
        kin: the leg, with its limits.
        ik: scratch.
        qp: a problem of n variables without rows.
        active: (n) the leg's active set, kept from tick to tick.
        gains: k_IK and weights.
        reference: (n) joint reference, rad or m, advanced in place.
        rate: (n) joint velocity reference, rad/s or m/s; on entry that of the last tick.
        target_position: (3) of the sole frame's origin, torso frame, m.
        target_velocity: (3) torso frame, m/s.
        target_rotation: (3, 3) sole frame to torso frame.
        dt: tick, s.

    Returns:
        Status of the quadratic program. Unless OPTIMAL the reference stays and the rate is zero.
    """
    n = reference.shape[0]
    pitch_weight = gains.pitch_weight
    for j in range(n):
        qp.active[j] = active[j]
        reference[j] = min(max(reference[j], kin.lower[j]), kin.upper[j])
    leg_forward(kin, reference, ik.position, ik.rotation, ik.jacobian)
    for i in range(3):
        ik.error[i] = (target_velocity[i] + gains.gain * (target_position[i] - ik.position[i])) * dt
    orientation_error(kin, ik.rotation, target_rotation, ik.error[3:])
    for j in range(n):
        for i in range(3):
            ik.task[i, j] = ik.jacobian[i, j]
            total = 0.0
            for k in range(3):
                total += ik.rotation[k, i] * ik.jacobian[3 + k, j]
            ik.task[3 + i, j] = total * kin.turning[i]
    for j in range(n):
        last = rate[j] * dt
        slope = -gains.change_weight * last
        for i in range(6):
            slope -= (1.0 if i < 3 else pitch_weight) * ik.task[i, j] * ik.error[i]
        qp.gradient[j] = slope
        for k in range(j + 1):
            total = 0.0
            for i in range(6):
                total += (1.0 if i < 3 else pitch_weight) * ik.task[i, j] * ik.task[i, k]
            qp.hessian[j, k] = qp.hessian[k, j] = total
        qp.hessian[j, j] += gains.step_weight + gains.change_weight
        reach = kin.velocity_limit[j] * dt
        qp.lower[j] = max(kin.lower[j] - reference[j], -reach)
        qp.upper[j] = min(kin.upper[j] - reference[j], reach)
    status, _ = solve(qp, 20 * n)
    for j in range(n):
        active[j] = qp.active[j]
        if status == OPTIMAL:
            before = reference[j]
            reference[j] = min(max(before + qp.solution[j], kin.lower[j]), kin.upper[j])
            rate[j] = qp.solution[j] / dt
        else:
            rate[j] = 0.0
    return status


def solve_leg(kin: LegKinematics, position: Array, rotation: Array, q0: Array | None = None) -> Array:
    """Joint values that put the sole at a pose, within the joint limits.

    Args:
        kin: the leg.
        position: (3) of the sole frame's origin, torso frame, m.
        rotation: (3, 3) sole frame to torso frame; only the turns that the leg controls are met.
        q0: (n) joint values to start from.

    Returns:
        (n) joint values, rad or m; position and orientation are met to 1e-10.

    Raises:
        BadInput: the pose is out of reach or not finite.
    """
    target, turn = np.asarray(position, dtype=np.float64), np.ascontiguousarray(rotation, dtype=np.float64)
    if target.shape != (3,) or turn.shape != (3, 3) or not (np.isfinite(target).all() and np.isfinite(turn).all()):
        raise BadInput("sole pose", target.tolist(), "three finite coordinates and a rotation matrix")
    n = kin.zero.shape[0]
    ik, qp = make_inverse_kinematics(n), make_quadratic_program(n, 0)
    free = kin._replace(velocity_limit=np.full(n, _TRUST))
    still, miss = np.zeros(3), np.inf
    starts = [kin.lower + share * (kin.upper - kin.lower) for share in _STARTS]
    for start in starts if q0 is None else [np.asarray(q0, dtype=np.float64), *starts]:
        q, rate, active = np.array(start), np.zeros(n), np.zeros(n, dtype=np.int64)
        damping, error = 1e-6, np.inf
        for _ in range(_ROUNDS):
            gains = InverseGains(1.0, damping, 0.0, 1.0)
            if leg_step(free, ik, qp, active, gains, q, rate, target, still, turn, 1.0) != OPTIMAL:
                break
            error = float(np.max(np.abs(ik.error)))
            damping = 1e-12 + 1e-3 * error * error
            if error < _PRECISION:
                return q
        miss = min(miss, error)
    raise BadInput(
        "sole position",
        target.round(4).tolist(),
        "a pose within the leg's reach and joint limits",
        f"missed by {miss:.3g}",
    )
