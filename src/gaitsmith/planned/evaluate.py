"""Values and two time derivatives of all curves of a plan at one instant."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import Matrix, Vector, kernel
from gaitsmith.planned.table import PER_SOLE, SOLES, TERMS, PlanTable


class PlanSample(NamedTuple):
    """A plan at one instant, relative to the support sole.

    Attributes:
        motion: (3, channels) values, first and second time derivatives of the table's motion.
        effort: (channels,) torques and wrenches.
        basis: (3, TERMS) scratch.
    """

    motion: Matrix
    effort: Vector
    basis: Matrix


def make_plan_sample(n_soles: int, n_joints: int) -> PlanSample:
    """Storage for a robot with that many soles and joints."""
    return PlanSample(
        motion=np.zeros((3, SOLES + PER_SOLE * n_soles + n_joints)),
        effort=np.zeros(n_joints + PER_SOLE * n_soles),
        basis=np.zeros((3, TERMS)),
    )


@kernel
def _chebyshev(x: float, rate: float, basis: Matrix) -> None:
    """Chebyshev polynomials at x with time derivatives, for a rate dx/dt."""
    basis[0, 0], basis[1, 0], basis[2, 0] = 1.0, 0.0, 0.0
    basis[0, 1], basis[1, 1], basis[2, 1] = x, rate, 0.0
    for k in range(2, basis.shape[1]):
        basis[0, k] = 2.0 * x * basis[0, k - 1] - basis[0, k - 2]
        basis[1, k] = 2.0 * (rate * basis[0, k - 1] + x * basis[1, k - 1]) - basis[1, k - 2]
        basis[2, k] = 2.0 * (2.0 * rate * basis[1, k - 1] + x * basis[2, k - 1]) - basis[2, k - 2]


@kernel
def evaluate(plan: PlanTable, section: int, time: float, sample: PlanSample) -> None:
    """Fill ``sample`` at a time within a section, s from its beginning; beyond its ends the ends hold."""
    span = plan.duration[section]
    share = min(max(time / span, 0.0), 1.0)
    _chebyshev(2.0 * share - 1.0, 2.0 / span, sample.basis)
    basis, motion, effort = sample.basis, sample.motion, sample.effort
    for c in range(motion.shape[1]):
        motion[0, c] = plan.motion[section, 0, c]
        motion[1, c] = 0.0
        motion[2, c] = 0.0
    for c in range(effort.shape[0]):
        effort[c] = plan.effort[section, 0, c]
    for k in range(1, basis.shape[1]):
        value, first, second = basis[0, k], basis[1, k], basis[2, k]
        for c in range(motion.shape[1]):
            term = plan.motion[section, k, c]
            motion[0, c] += value * term
            motion[1, c] += first * term
            motion[2, c] += second * term
        for c in range(effort.shape[0]):
            effort[c] += value * plan.effort[section, k, c]


@kernel
def orientation(motion: Matrix, first: int, heading: float, rotation: Matrix, spin: Vector, turn: Vector) -> None:
    """Rotation to the world, angular velocity and angular acceleration (world axes) from yaw, pitch and roll.

    R = Rz(yaw) Ry(pitch) Rx(roll); ω = yaw' z + pitch' Rz y + roll' Rz Ry x, and its derivative.

    Args:
        motion: (3, channels) values and time derivatives.
        first: channel of the yaw; pitch and roll follow.
        heading: added to the yaw, rad.
        rotation: (3, 3), receives the rotation.
        spin: (3,), receives the angular velocity, rad/s.
        turn: (3,), receives the angular acceleration, rad/s².
    """
    yaw, pitch, roll = motion[0, first] + heading, motion[0, first + 1], motion[0, first + 2]
    yaw_rate, pitch_rate, roll_rate = motion[1, first], motion[1, first + 1], motion[1, first + 2]
    yaw_turn, pitch_turn, roll_turn = motion[2, first], motion[2, first + 1], motion[2, first + 2]
    cy, sy, cp, sp = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
    cr, sr = math.cos(roll), math.sin(roll)
    rotation[0, 0], rotation[0, 1], rotation[0, 2] = cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr
    rotation[1, 0], rotation[1, 1], rotation[1, 2] = sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr
    rotation[2, 0], rotation[2, 1], rotation[2, 2] = -sp, cp * sr, cp * cr
    spin[0] = roll_rate * cy * cp - pitch_rate * sy
    spin[1] = roll_rate * sy * cp + pitch_rate * cy
    spin[2] = yaw_rate - roll_rate * sp
    turn[0] = (
        roll_turn * cy * cp
        - pitch_turn * sy
        - roll_rate * (yaw_rate * sy * cp + pitch_rate * cy * sp)
        - pitch_rate * yaw_rate * cy
    )
    turn[1] = (
        roll_turn * sy * cp
        + pitch_turn * cy
        + roll_rate * (yaw_rate * cy * cp - pitch_rate * sy * sp)
        - pitch_rate * yaw_rate * sy
    )
    turn[2] = yaw_turn - roll_turn * sp - roll_rate * pitch_rate * cp
