"""Whole-body QP (Han 2023, eqs. 17-26): joint torques and sole wrenches that follow the tasks best.

The accelerations are eliminated through the dynamics, so the variables are the joint torques and one local wrench
per sole in contact, and every bound is a bound on the variables alone: the problem always has a solution.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import IntVector, Matrix, Vector, kernel
from gaitsmith.dynamics.tree import TreeState
from gaitsmith.qp.quadratic_program import QuadraticProgram, solve
from gaitsmith.whole_body.contact_wrench import CONTACT_ROWS, contact_bounds, moment_axis, wrench_size
from gaitsmith.whole_body.forward_dynamics import WRENCH_VARIABLES, MotionMap, map_motion
from gaitsmith.whole_body.frames import Frames, Legs
from gaitsmith.whole_body.targets import Targets, TaskGains
from gaitsmith.whole_body.tasks import add_attitude, add_joint, add_stance, add_standing, add_swing

_ITERATIONS = 60


class WholeBody(NamedTuple):
    """Result of the whole-body QP.

    Attributes:
        torque: (nj,) N·m, the last accepted solution.
        wrench: (2, 6) force and moment on each sole, world axes, N and N·m; 0 for a sole in the air.
        acceleration: (nv,) that the solution predicts.
        counts: (4,) solves, fallbacks, infeasible, consecutive fallbacks.
        status: (2,) status and iterations of the last solve.
        contact: (2,) contacts of the last solve, to know when the active set no longer applies.
    """

    torque: Vector
    wrench: Matrix
    acceleration: Vector
    counts: IntVector
    status: IntVector
    contact: IntVector


def make_whole_body(nv: int, n_joints: int) -> WholeBody:
    """Storage for a robot with ``nv`` degrees of freedom and ``n_joints`` joints."""
    return WholeBody(
        torque=np.zeros(n_joints),
        wrench=np.zeros((2, 6)),
        acceleration=np.zeros(nv),
        counts=np.zeros(4, dtype=np.int64),
        status=np.zeros(2, dtype=np.int64),
        contact=np.zeros(2, dtype=np.int64),
    )


def problem_size(n_joints: int) -> tuple[int, int]:
    """Largest number of variables and of rows of the QP."""
    return n_joints + WRENCH_VARIABLES, 2 * CONTACT_ROWS


@kernel
def _assemble(
    qp: QuadraticProgram,
    state: TreeState,
    legs: Legs,
    targets: Targets,
    frames: Frames,
    gains: TaskGains,
    motion: MotionMap,
    body: WholeBody,
    n: int,
) -> None:
    """Cost and bounds of the tick's QP."""
    n_joints = body.torque.shape[0]
    for i in range(n):
        qp.gradient[i] = 0.0
        qp.lower[i] = -math.inf
        qp.upper[i] = math.inf
        for j in range(i + 1):
            qp.hessian[i, j] = 0.0
    for j in range(n_joints):
        qp.lower[j] = -targets.torque_limit[j]
        qp.upper[j] = targets.torque_limit[j]
        if targets.joint_weight[j] > 0.0:
            add_joint(qp, motion, n, 6 + j, targets.joint_acceleration[j], targets.joint_weight[j])
        qp.hessian[j, j] += gains.torque_change
        qp.gradient[j] -= gains.torque_change * body.torque[j]
    standing = targets.in_contact[0] + targets.in_contact[1] == 2
    first, m = n_joints, 0
    for leg in range(2):
        if targets.in_contact[leg] == 1:
            add_stance(qp, legs, frames, gains, motion, n, leg)
            m = contact_bounds(qp, legs, gains, leg, first, m)
            first += wrench_size(legs.half_width[leg])
            if not standing:
                ankle = legs.ankle_pitch[leg]
                qp.hessian[ankle, ankle] += gains.ankle_torque
                qp.gradient[ankle] -= gains.ankle_torque * targets.ankle_torque[leg]
        else:
            add_swing(qp, targets, frames, gains, motion, n, leg)
    add_attitude(qp, frames, gains, motion, n)
    if standing:
        add_standing(qp, state, targets, frames, gains, motion, n)
    for i in range(n):
        qp.hessian[i, i] += gains.regularisation
        for j in range(i):
            qp.hessian[j, i] = qp.hessian[i, j]
    qp.size[0] = n
    qp.size[1] = m


@kernel
def _accept(
    qp: QuadraticProgram, legs: Legs, targets: Targets, frames: Frames, motion: MotionMap, body: WholeBody, n: int
) -> None:
    """Copy the solution into torque, world wrenches and predicted accelerations."""
    nv = motion.free.shape[0]
    n_joints = body.torque.shape[0]
    for j in range(n_joints):
        body.torque[j] = qp.solution[j]
    for k in range(nv):
        body.acceleration[k] = motion.free[k]
        for j in range(n):
            body.acceleration[k] += motion.map[k, j] * qp.solution[j]
    first = n_joints
    for leg in range(2):
        for i in range(6):
            body.wrench[leg, i] = 0.0
        if targets.in_contact[leg] == 0:
            continue
        size = wrench_size(legs.half_width[leg])
        for variable in range(size):
            base, axis = 0, variable
            if variable >= 3:
                base, axis = 3, moment_axis(legs.half_width[leg], variable - 3)
            for i in range(3):
                body.wrench[leg, base + i] += frames.contact_rotation[leg, i, axis] * qp.solution[first + variable]
        first += size


@kernel
def solve_whole_body(
    qp: QuadraticProgram,
    state: TreeState,
    legs: Legs,
    targets: Targets,
    frames: Frames,
    gains: TaskGains,
    motion: MotionMap,
    body: WholeBody,
) -> bool:
    """Solve eq. 25 for this tick; on failure ``body.torque`` keeps the last accepted solution.

    Returns:
        True if the QP was solved. ``body.counts`` and ``body.status`` say what happened.
    """
    body.counts[0] += 1
    for leg in range(2):
        if body.contact[leg] != targets.in_contact[leg]:
            for i in range(qp.active.shape[0]):
                qp.active[i] = 0
        body.contact[leg] = targets.in_contact[leg]
    n = map_motion(state, legs, targets, frames, motion, body.torque.shape[0])
    if n < 0:
        body.status[0], body.status[1] = 3, 0
    else:
        _assemble(qp, state, legs, targets, frames, gains, motion, body, n)
        body.status[0], body.status[1] = solve(qp, _ITERATIONS)
        if body.status[0] == 0:
            _accept(qp, legs, targets, frames, motion, body, n)
            body.counts[3] = 0
            return True
    body.counts[1] += 1
    body.counts[3] += 1
    if body.status[0] == 1:
        body.counts[2] += 1
    return False
