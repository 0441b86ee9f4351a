"""Whole-body QP (Han 2023, eqs. 17-26): joint torques and sole wrenches that follow the reference best.

The accelerations are eliminated through the dynamics, so the variables are the joint torques and one local wrench
per bearing sole. Bounds on torque and wrench are bounds on the variables alone and can always be met; in a tick that
cannot meet the rows that keep a joint off its stops, they become costs, and the tick is counted.
"""

from __future__ import annotations

import math

from gaitsmith.compiled import kernel
from gaitsmith.qp.quadratic_program import INFEASIBLE, OPTIMAL, QuadraticProgram, solve
from gaitsmith.whole_body.contact import WRENCH_SIZE, contact_bounds, observe_contacts, transmits
from gaitsmith.whole_body.forward_dynamics import accelerations, begin_motion, express_cost, joint_row
from gaitsmith.whole_body.problem import WholeBody
from gaitsmith.whole_body.reference import NONE
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


@kernel
def _torque_bounds(g: WholeBody, tasks: TaskTable, n: int) -> None:
    """Limits of torques and of their change, cost of their change (eq. 24)."""
    qp, solution, limits = g.program, g.solution, g.body.legs.torque_limit
    for i in range(n):
        qp.lower[i], qp.upper[i] = -math.inf, math.inf
        qp.hessian[i, i] += tasks.regularisation
    step = math.inf if solution.fresh[0] == 1 else g.joint_bounds.torque_step * solution.elapsed[0]
    for j in range(solution.torque.shape[0]):
        limit, last = limits[j], solution.torque[j]
        qp.lower[j] = min(max(-limit, last - step), limit)
        qp.upper[j] = max(min(limit, last + step), -limit)
        qp.hessian[j, j] += tasks.torque_change
        qp.gradient[j] -= tasks.torque_change * last


@kernel
def _stop_rows(g: WholeBody, n: int, row: int) -> int:
    """Rows ``q̈ ≤ r² (stop - q) - 2 r q̇`` of joints near a stop: a critically damped approach does not pass it."""
    qp, legs, q, v = g.program, g.body.legs, g.body.q, g.body.v
    m, rate = row, g.joint_bounds.stop_rate
    near = _NEAR * rate * rate
    for j in range(legs.position_low.shape[0]):
        angle, speed = q[7 + j], 2.0 * rate * v[6 + j]
        above = rate * rate * (legs.position_high[j] - angle) - speed
        below = rate * rate * (legs.position_low[j] - angle) - speed
        if above > near and below < -near:
            continue
        free = joint_row(g.motion, j, n, qp.rows[m])
        qp.row_lower[m], qp.row_upper[m] = below - free, above - free
        qp.span[m, 0], qp.span[m, 1] = 0, n
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
def _assemble(g: WholeBody, tasks: TaskTable, n: int) -> int:
    """Cost and bounds of the tick's QP; returns the number of rows of the contacts, the first ones."""
    qp, contacts = g.program, g.contacts
    for leg in range(contacts.kind.shape[0]):
        if contacts.kind[leg] != NONE:
            add_stance(g, tasks, leg)
        elif tasks.swing.weight > 0.0:
            add_swing(g, tasks, leg)
        if tasks.swing_turn.weight > 0.0:
            add_sole_turn(g, tasks, leg)
    add_torso(g, tasks)
    add_body(g, tasks)
    add_joints(g, tasks)
    express_cost(g.motion, qp, g.body.v.shape[0], n)
    _torque_bounds(g, tasks, n)
    m = 0
    for leg in range(contacts.kind.shape[0]):
        if contacts.kind[leg] != NONE:
            add_wrench(g, tasks, leg)
            m = contact_bounds(qp, contacts, g.body.legs, g.contact_bounds, leg, m)
    qp.size[0] = n
    qp.size[1] = _stop_rows(g, n, m)
    return m


@kernel
def _accept(g: WholeBody, n: int) -> None:
    """Copy the solution into torque, world wrenches at the soles' origins, and predicted accelerations."""
    solution, contacts, found, half_width = g.solution, g.contacts, g.program.solution, g.body.legs.half_width
    for j in range(solution.torque.shape[0]):
        solution.torque[j] = found[j]
    accelerations(g.motion, found, n, solution.acceleration)
    for leg in range(contacts.kind.shape[0]):
        wrench, variable = solution.wrench[leg], contacts.first[leg]
        for i in range(WRENCH_SIZE):
            wrench[i] = 0.0
        if contacts.kind[leg] == NONE:
            continue
        for axis in range(WRENCH_SIZE):
            if transmits(contacts.kind[leg], half_width[leg], axis):
                first = 3 * (axis // 3)
                for i in range(3):
                    wrench[first + i] += contacts.axes[leg, i, axis - first] * found[variable]
                variable += 1
        pivot, origin = contacts.pivot[leg], g.body.frames.sole_position[leg]
        x, y, z = pivot[0] - origin[0], pivot[1] - origin[1], pivot[2] - origin[2]
        wrench[3] += y * wrench[2] - z * wrench[1]
        wrench[4] += z * wrench[0] - x * wrench[2]
        wrench[5] += x * wrench[1] - y * wrench[0]


@kernel
def _forget(qp: QuadraticProgram, first: int) -> None:
    """Start the next solve without the constraints from ``first`` on."""
    for i in range(first, qp.active.shape[0]):
        qp.active[i] = 0


@kernel
def solve_whole_body(g: WholeBody, tasks: TaskTable) -> bool:
    """Solve eq. 25 for this tick; without a solution the last torque decays.

    Returns:
        True if the QP was solved. ``g.solution`` says what happened.
    """
    qp, solution, contacts = g.program, g.solution, g.contacts
    solution.solves[0] += 1
    if observe_contacts(g.body.legs, g.body.frames, g.reference.contact, contacts):
        _forget(qp, 0)
    n = begin_motion(g.body, contacts, g.motion)
    solution.status[0], solution.iterations[0] = 3, 0
    if n >= 0:
        m = _assemble(g, tasks, n)
        stops = qp.size[1] - m
        if stops != solution.stop_rows[0]:
            _forget(qp, qp.gradient.shape[0] + m)
        solution.stop_rows[0] = stops
        solution.status[0], solution.iterations[0] = solve(qp, _ITERATIONS)
        if solution.status[0] == INFEASIBLE and stops > 0:
            qp.size[1] = m
            solution.stops_dropped[0] += 1
            solution.status[0], solution.iterations[0] = solve(qp, _ITERATIONS)
            if solution.status[0] == OPTIMAL:
                _brake_at_stops(qp, n, m, m + stops)
                solution.status[0], solution.iterations[0] = solve(qp, _ITERATIONS)
        if solution.status[0] == OPTIMAL:
            _accept(g, n)
            solution.fresh[0] = 0
            return True
    solution.fallbacks[0] += 1
    if solution.status[0] == INFEASIBLE:
        solution.infeasible[0] += 1
    for j in range(solution.torque.shape[0]):
        solution.torque[j] *= _DECAY
    return False
