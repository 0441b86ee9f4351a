"""Whole-body QP (Han 2023, eqs. 17-26): joint torques and sole wrenches that follow the reference best.

The accelerations are eliminated through the dynamics, so the variables are the joint torques and one local wrench
per bearing sole. Bounds on torque and wrench are bounds on the variables alone and can always be met; in a tick that
cannot meet the rows that keep a joint off its stops, they become costs, and the tick is counted.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import IntVector, Matrix, Vector, kernel
from gaitsmith.dynamics.tree import TreeState
from gaitsmith.qp.quadratic_program import INFEASIBLE, OPTIMAL, QuadraticProgram, solve
from gaitsmith.whole_body.contact import (
    CONTACT_ROWS,
    WRENCH_SIZE,
    ContactBounds,
    Contacts,
    contact_bounds,
    observe_contacts,
    transmits,
)
from gaitsmith.whole_body.forward_dynamics import MotionMap, forward_dynamics_map, variable_count
from gaitsmith.whole_body.frames import Frames
from gaitsmith.whole_body.legs import Legs
from gaitsmith.whole_body.reference import NONE, Reference
from gaitsmith.whole_body.tasks import (
    TaskTable,
    add_body,
    add_joints,
    add_sole_turn,
    add_stance,
    add_swing,
    add_torso,
    add_wrench,
)

_ITERATIONS = 80
_NEAR = 0.1  # rad: a stop is watched from here on, or earlier when approached fast
_FIRM = 1e4  # (rad/s²)⁻²: cost on a stop's row that cannot be met
_DECAY = 0.98  # per tick, of the torque that is held when no new one can be computed


class JointBounds(NamedTuple):
    """Bounds on the joints besides their torque limits.

    Attributes:
        torque_step: largest change of a torque from one tick to the next, N·m.
        stop_rate: how fast a joint may approach its stop: the rate of a critically damped approach, 1/s.
    """

    torque_step: float
    stop_rate: float


class WholeBody(NamedTuple):
    """Result of the whole-body QP.

    Attributes:
        torque: (nj,) N·m, the last accepted solution.
        wrench: (n, 6) force and moment on each sole at its origin, world axes, N and N·m; 0 for a sole in the air.
        acceleration: (nv,) that the solution predicts.
        fresh: (1,) 1 until a first solution: the change of torque is not bounded then.
        solves: (1,) since the reset.
        fallbacks: (1,) ticks without a solution.
        infeasible: (1,) of these, ticks whose bounds contradict each other.
        stops_dropped: (1,) ticks that could not keep every joint off its stops, and braked them as hard as they could.
        status: (1,) of the last solve.
        iterations: (1,) of the last solve.
        stop_rows: (1,) rows of joint stops in the last solve.
    """

    torque: Vector
    wrench: Matrix
    acceleration: Vector
    fresh: IntVector
    solves: IntVector
    fallbacks: IntVector
    infeasible: IntVector
    stops_dropped: IntVector
    status: IntVector
    iterations: IntVector
    stop_rows: IntVector


def make_whole_body(nv: int, n_joints: int, n_soles: int) -> WholeBody:
    """Storage for a robot with ``nv`` degrees of freedom, ``n_joints`` joints and ``n_soles`` soles."""
    counts = {name: np.zeros(1, dtype=np.int64) for name in WholeBody._fields[4:]}
    return WholeBody(
        torque=np.zeros(n_joints),
        wrench=np.zeros((n_soles, 6)),
        acceleration=np.zeros(nv),
        fresh=np.ones(1, dtype=np.int64),
        **counts,
    )


def problem_size(n_joints: int, n_soles: int) -> tuple[int, int]:
    """Largest number of variables and of rows of the QP."""
    return variable_count(n_joints, n_soles), CONTACT_ROWS * n_soles + n_joints


@kernel
def _torque_bounds(
    qp: QuadraticProgram, legs: Legs, joints: JointBounds, tasks: TaskTable, body: WholeBody, n: int
) -> None:
    """Start of the QP: limits of torques and of their change, cost of their change (eq. 24)."""
    for i in range(n):
        qp.gradient[i] = 0.0
        qp.lower[i], qp.upper[i] = -math.inf, math.inf
        for j in range(i + 1):
            qp.hessian[i, j] = 0.0
        qp.hessian[i, i] = tasks.regularisation
    step = math.inf if body.fresh[0] == 1 else joints.torque_step
    for j in range(body.torque.shape[0]):
        limit, last = legs.torque_limit[j], body.torque[j]
        qp.lower[j] = min(max(-limit, last - step), limit)
        qp.upper[j] = max(min(limit, last + step), -limit)
        qp.hessian[j, j] += tasks.torque_change
        qp.gradient[j] -= tasks.torque_change * last


@kernel
def _stop_rows(
    qp: QuadraticProgram, legs: Legs, joints: JointBounds, motion: MotionMap, q: Vector, v: Vector, n: int, row: int
) -> int:
    """Rows ``q̈ ≤ r² (stop - q) - 2 r q̇`` of joints near a stop: a critically damped approach does not pass it."""
    m, rate = row, joints.stop_rate
    near = _NEAR * rate * rate
    for j in range(legs.position_low.shape[0]):
        angle, speed = q[7 + j], 2.0 * rate * v[6 + j]
        above = rate * rate * (legs.position_high[j] - angle) - speed
        below = rate * rate * (legs.position_low[j] - angle) - speed
        if above > near and below < -near:
            continue
        for i in range(n):
            qp.rows[m, i] = motion.map[6 + j, i]
        qp.row_lower[m] = below - motion.free[6 + j]
        qp.row_upper[m] = above - motion.free[6 + j]
        m += 1
    return m


@kernel
def _brake_at_stops(qp: QuadraticProgram, n: int, first: int, last: int) -> None:
    """Add a cost on what the present solution misses in rows ``first`` to ``last``: brake as hard as can be."""
    for m in range(first, last):
        value = 0.0
        for i in range(n):
            value += qp.rows[m, i] * qp.solution[i]
        wanted = min(max(value, qp.row_lower[m]), qp.row_upper[m])
        if wanted == value:
            continue
        for i in range(n):
            scaled = _FIRM * qp.rows[m, i]
            qp.gradient[i] -= scaled * wanted
            for j in range(n):
                qp.hessian[i, j] += scaled * qp.rows[m, j]


@kernel
def _assemble(
    qp: QuadraticProgram,
    state: TreeState,
    legs: Legs,
    reference: Reference,
    frames: Frames,
    contacts: Contacts,
    tasks: TaskTable,
    bounds: ContactBounds,
    joints: JointBounds,
    motion: MotionMap,
    body: WholeBody,
    q: Vector,
    v: Vector,
    n: int,
) -> int:
    """Cost and bounds of the tick's QP; returns the number of rows of the contacts, the first ones."""
    _torque_bounds(qp, legs, joints, tasks, body, n)
    m = 0
    for leg in range(contacts.kind.shape[0]):
        if contacts.kind[leg] == NONE:
            if tasks.swing.weight > 0.0:
                add_swing(qp, reference, frames, tasks, motion, n, leg)
        else:
            add_stance(qp, legs, contacts, frames, tasks, motion, n, leg)
            add_wrench(qp, legs, reference, contacts, tasks, leg)
            m = contact_bounds(qp, contacts, legs, bounds, leg, m)
        if tasks.swing_turn.weight > 0.0:
            add_sole_turn(qp, reference, legs, contacts, frames, tasks, motion, n, leg)
    add_torso(qp, state, legs, reference, frames, tasks, motion, n)
    add_body(qp, state, reference, frames, tasks, motion, n)
    add_joints(qp, legs, reference, tasks, motion, n, q, v)
    for i in range(n):
        for j in range(i):
            qp.hessian[j, i] = qp.hessian[i, j]
    qp.size[0] = n
    qp.size[1] = _stop_rows(qp, legs, joints, motion, q, v, n, m)
    return m


@kernel
def _accept(
    qp: QuadraticProgram, legs: Legs, frames: Frames, contacts: Contacts, motion: MotionMap, body: WholeBody, n: int
) -> None:
    """Copy the solution into torque, world wrenches at the soles' origins, and predicted accelerations."""
    for j in range(body.torque.shape[0]):
        body.torque[j] = qp.solution[j]
    for k in range(motion.free.shape[0]):
        body.acceleration[k] = motion.free[k]
        for j in range(n):
            body.acceleration[k] += motion.map[k, j] * qp.solution[j]
    for leg in range(contacts.kind.shape[0]):
        wrench, variable = body.wrench[leg], contacts.first[leg]
        for i in range(WRENCH_SIZE):
            wrench[i] = 0.0
        if contacts.kind[leg] == NONE:
            continue
        for axis in range(WRENCH_SIZE):
            if transmits(contacts.kind[leg], legs.half_width[leg], axis):
                first = 3 * (axis // 3)
                for i in range(3):
                    wrench[first + i] += contacts.axes[leg, i, axis - first] * qp.solution[variable]
                variable += 1
        x = contacts.pivot[leg, 0] - frames.sole_position[leg, 0]
        y = contacts.pivot[leg, 1] - frames.sole_position[leg, 1]
        z = contacts.pivot[leg, 2] - frames.sole_position[leg, 2]
        wrench[3] += y * wrench[2] - z * wrench[1]
        wrench[4] += z * wrench[0] - x * wrench[2]
        wrench[5] += x * wrench[1] - y * wrench[0]


@kernel
def solve_whole_body(
    qp: QuadraticProgram,
    state: TreeState,
    legs: Legs,
    reference: Reference,
    frames: Frames,
    contacts: Contacts,
    tasks: TaskTable,
    bounds: ContactBounds,
    joints: JointBounds,
    motion: MotionMap,
    body: WholeBody,
    q: Vector,
    v: Vector,
) -> bool:
    """Solve eq. 25 for this tick; without a solution the last torque decays.

    Returns:
        True if the QP was solved. ``body`` says what happened.
    """
    body.solves[0] += 1
    if observe_contacts(legs, frames, reference.contact, contacts):
        for i in range(qp.active.shape[0]):
            qp.active[i] = 0
    n = forward_dynamics_map(state, legs, contacts, motion, body.torque.shape[0])
    body.status[0], body.iterations[0] = 3, 0
    if n >= 0:
        m = _assemble(qp, state, legs, reference, frames, contacts, tasks, bounds, joints, motion, body, q, v, n)
        stops = qp.size[1] - m
        if stops != body.stop_rows[0]:
            for i in range(qp.gradient.shape[0] + m, qp.active.shape[0]):
                qp.active[i] = 0
        body.stop_rows[0] = stops
        body.status[0], body.iterations[0] = solve(qp, _ITERATIONS)
        if body.status[0] == INFEASIBLE and stops > 0:
            qp.size[1] = m
            body.stops_dropped[0] += 1
            body.status[0], body.iterations[0] = solve(qp, _ITERATIONS)
            if body.status[0] == OPTIMAL:
                _brake_at_stops(qp, n, m, m + stops)
                body.status[0], body.iterations[0] = solve(qp, _ITERATIONS)
        if body.status[0] == OPTIMAL:
            _accept(qp, legs, frames, contacts, motion, body, n)
            body.fresh[0] = 0
            return True
    body.fallbacks[0] += 1
    if body.status[0] == INFEASIBLE:
        body.infeasible[0] += 1
    for j in range(body.torque.shape[0]):
        body.torque[j] *= _DECAY
    return False
