"""Tasks on accelerations as a cost of joint torques and sole wrenches, by ``q̈ = M⁻¹(Sᵀτ + Jᵀλ + τ_p - h)``.

That is q̈ = T x + t of the variables x = (τ, λ). Tasks ½ w (a q̈ - b)² add up to ½ xᵀ Yᵀ W Y x + (W (A t - b))ᵀ Y x with
Y = A T; the row of a joint is one of T itself, that of a leg is zero outside it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import IntVector, Matrix, Vector, kernel
from gaitsmith.compiled.lanes import LANES, entry, none, padded, plus, put, storage, take, times
from gaitsmith.dynamics.linear_algebra import factor_tree, solve_tree
from gaitsmith.qp.quadratic_program import QuadraticProgram
from gaitsmith.whole_body.contact import WRENCH_SIZE, Contacts, transmits
from gaitsmith.whole_body.frames import Body
from gaitsmith.whole_body.legs import Legs
from gaitsmith.whole_body.reference import NONE

ROWS = 7  # of tasks: torso 3, centre of mass 3, hip height
ROWS_OF_A_SOLE = 7  # at most: its pivot 3, its turn 3, its turn about an edge


class Motion(NamedTuple):
    """Dynamics and tasks of one tick's accelerations; sizes are padded, see :mod:`gaitsmith.compiled.lanes`.

    At most n variables and m tasks beside those of single joints.

    Attributes:
        factor: (nv, nv) of M.
        response: (nv + 1, n + 1) T and, as the column after the last variable, t; below them a 1 in that column.
        rows: (m, nv + 1) Jacobians A of the tasks, and -b.
        weight: (m,) of the tasks.
        target: (nj,) wanted acceleration of the joints.
        joint_weight: (nj,) of these tasks.
        reach: (m + nj, n + 1) Y and, as the column after the last variable, A t - b.
        weighted: (m + nj, n + 1) the same times the weights.
        filled: (1,) rows so far.
        turn: (3,) a rotation's error, world axes, rad.
    """

    factor: Matrix
    response: Matrix
    rows: Matrix
    weight: Vector
    target: Vector
    joint_weight: Vector
    reach: Matrix
    weighted: Matrix
    filled: IntVector
    turn: Vector


def variable_count(n_joints: int, n_soles: int) -> int:
    """Largest number of variables of the QP."""
    return n_joints + WRENCH_SIZE * n_soles


def make_motion(nv: int, n_joints: int, n_soles: int) -> Motion:
    """Storage for a robot with ``nv`` degrees of freedom."""
    n, m = variable_count(n_joints, n_soles), ROWS + ROWS_OF_A_SOLE * n_soles

    def matrix(rows: int, columns: int) -> Matrix:
        return storage(padded(rows), columns)

    return Motion(
        factor=matrix(nv, nv),
        response=matrix(nv + 1, n + 1),
        rows=matrix(m, nv + 1),
        weight=np.zeros(padded(m)),
        target=np.zeros(n_joints),
        joint_weight=np.zeros(n_joints),
        reach=matrix(m + n_joints, n + 1),
        weighted=matrix(m + n_joints, n + 1),
        filled=np.zeros(1, dtype=np.int64),
        turn=np.zeros(3),
    )


@kernel
def _add_passive(legs: Legs, q: Vector, v: Vector, response: Matrix, column: int) -> None:
    """Add the torques of the joints' springs, damping and dry friction, whose sign is smooth: no joint chatters."""
    for j in range(legs.passive.shape[0]):
        speed = v[6 + j]
        torque = -legs.passive[j, 0] * (q[7 + j] - legs.passive[j, 1]) - legs.passive[j, 2] * speed
        torque -= legs.passive[j, 3] * speed / math.sqrt(speed * speed + legs.passive[j, 4] ** 2)
        response[6 + j, column] += torque


@kernel
def _push(contacts: Contacts, legs: Legs, leg: int, nv: int, first: int, response: Matrix) -> int:
    """Generalised force per unit of a sole's variables, columns from ``first`` on; returns the column after them."""
    axes, jacobian, column = contacts.axes[leg], contacts.jacobian[leg], first
    for axis in range(WRENCH_SIZE):
        if not transmits(contacts.kind[leg], legs.half_width[leg], axis):
            continue
        row = 3 * (axis // 3)
        x, y, z = axes[0, axis - row], axes[1, axis - row], axes[2, axis - row]
        for k in range(nv):
            response[k, column] = x * jacobian[row, k] + y * jacobian[row + 1, k] + z * jacobian[row + 2, k]
        column += 1
    return column


@kernel
def begin_motion(body: Body, contacts: Contacts, motion: Motion) -> int:
    """Dynamics of this tick, no task yet; returns the number of variables, or -1 if M is not positive definite."""
    legs, n_joints, response = body.legs, body.legs.torque_limit.shape[0], motion.response
    nv, n = n_joints + 6, n_joints
    for k in range(nv + 1):
        for i in range(response.shape[1]):
            response[k, i] = 0.0
        if 6 <= k < nv:
            response[k, k - 6] = 1.0
    for j in range(n_joints):
        motion.joint_weight[j] = 0.0
    for leg in range(contacts.kind.shape[0]):
        contacts.first[leg] = n
        if contacts.kind[leg] != NONE:
            n = _push(contacts, legs, leg, nv, n, response)
    for k in range(nv):
        response[k, n] = -body.state.bias[k]
    response[nv, n] = 1.0
    _add_passive(legs, body.q, body.v, response, n)
    motion.filled[0] = 0
    if not factor_tree(body.state.mass_matrix, body.tree.dof_parent, motion.factor):
        return -1
    solve_tree(motion.factor, body.tree.dof_parent, response, n + 1)
    return int(n)


@kernel
def add_row(motion: Motion, nv: int, target: float, weight: float) -> None:
    """Keep row ``filled``, which the caller has filled, as the task ``½ weight (row q̈ - target)²``."""
    m = motion.filled[0]
    motion.rows[m, nv] = -target
    motion.weight[m] = weight
    motion.filled[0] = m + 1


@kernel
def add_joint(motion: Motion, joint: int, target: float, weight: float) -> None:
    """The same for the acceleration of one joint."""
    motion.target[joint], motion.joint_weight[joint] = target, weight


@kernel
def _products(left: Matrix, turned: bool, right: Matrix, i: int, c: int, inner: int, out: Matrix) -> None:
    """Eight columns from c of four rows from i of ``left right``, or of ``leftᵀ right``."""
    a, b, d, e = none(), none(), none(), none()
    if turned:
        for k in range(inner):
            line = take(right, k, c)
            a, b = plus(a, entry(left, k, i), line), plus(b, entry(left, k, i + 1), line)
            d, e = plus(d, entry(left, k, i + 2), line), plus(e, entry(left, k, i + 3), line)
    else:
        for k in range(inner):
            line = take(right, k, c)
            a, b = plus(a, entry(left, i, k), line), plus(b, entry(left, i + 1, k), line)
            d, e = plus(d, entry(left, i + 2, k), line), plus(e, entry(left, i + 3, k), line)
    put(out, i, c, a)
    put(out, i + 1, c, b)
    put(out, i + 2, c, d)
    put(out, i + 3, c, e)


@kernel
def _last_column(motion: Motion, nv: int, n: int) -> None:
    """A t - b of the tasks that are no joint's, where it is alone in its eight columns."""
    rows, response, reach = motion.rows, motion.response, motion.reach
    for i in range(0, motion.filled[0], 4):
        a = b = d = e = 0.0
        for k in range(nv + 1):
            share = entry(response, k, n)
            a, b = a + entry(rows, i, k) * share, b + entry(rows, i + 1, k) * share
            d, e = d + entry(rows, i + 2, k) * share, e + entry(rows, i + 3, k) * share
        reach[i, n], reach[i + 1, n], reach[i + 2, n], reach[i + 3, n] = a, b, d, e


@kernel
def _reach(motion: Motion, nv: int, n: int) -> int:
    """Y and its weighted rows; returns their number."""
    response, m = motion.response, motion.filled[0]
    for i in range(0, m, 4):
        for c in range(0, n, LANES):
            _products(motion.rows, False, response, i, c, nv + 1, motion.reach)
    if n % LANES == 0:
        _last_column(motion, nv, n)
    for i in range(m):
        for c in range(0, n, LANES):
            put(motion.weighted, i, c, times(take(motion.reach, i, c), motion.weight[i]))
    for j in range(motion.target.shape[0]):
        if motion.joint_weight[j] == 0.0:
            continue
        for c in range(0, n, LANES):
            line = plus(take(response, 6 + j, c), -motion.target[j], take(response, nv, c))
            put(motion.reach, m, c, line)
            put(motion.weighted, m, c, times(line, motion.joint_weight[j]))
        if n % LANES == 0:
            motion.reach[m, n] = response[6 + j, n] - motion.target[j]
        m += 1
    return int(m)


@kernel
def express_cost(motion: Motion, qp: QuadraticProgram, nv: int, n: int) -> None:
    """Make the tasks a cost of the QP's n variables: Hessian, whose storage is padded, and gradient."""
    hessian, weighted, reach, m = qp.hessian, motion.weighted, motion.reach, _reach(motion, nv, n)
    for i in range(0, n, 4):
        for c in range(i // LANES * LANES, n, LANES):
            _products(weighted, True, reach, i, c, m, hessian)
    if n % LANES == 0:  # the gradient is not in the last eight columns
        for c in range(0, n, LANES):
            found = none()
            for k in range(m):
                found = plus(found, entry(reach, k, n), take(weighted, k, c))
            put(hessian, n, c, found)
    for i in range(n):
        qp.gradient[i] = entry(hessian, n, i) if n % LANES == 0 else entry(hessian, i, n)
        line = hessian[i]
        for j in range(i):
            line[j] = entry(hessian, j, i)


@kernel
def accelerations(motion: Motion, x: Vector, n: int, out: Vector) -> None:
    """q̈ of the n variables x, into ``out`` (nv,)."""
    for k in range(out.shape[0]):
        row = motion.response[k]
        found, more = row[n], 0.0
        for j in range(n // 2):
            found += row[2 * j] * x[2 * j]
            more += row[2 * j + 1] * x[2 * j + 1]
        if n % 2 == 1:
            found += row[n - 1] * x[n - 1]
        out[k] = found + more


@kernel
def joint_row(motion: Motion, joint: int, n: int, row: Vector) -> float:
    """A joint's acceleration per unit of each of n variables, into ``row``; returns it with all of them zero."""
    for j in range(n):
        row[j] = motion.response[6 + joint, j]
    return float(motion.response[6 + joint, n])
