"""Costs of accelerations as costs of joint torques and sole wrenches, by ``q̈ = M⁻¹(Sᵀτ + Jᵀλ + τ_p - h)``.

Tasks add up ½ q̈ᵀ W q̈ - cᵀ q̈, where the row of a joint is one number and that of a leg is zero outside it. With
P = M⁻¹ W M⁻¹, r = τ_p - h and B = [Sᵀ Jᵀ], that is ½ xᵀ Bᵀ P B x + (P r - M⁻¹ c)ᵀ B x of the variables x = (τ, λ).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import Matrix, Vector, kernel
from gaitsmith.compiled.lanes import LANES, none, padded, plus, put, take
from gaitsmith.dynamics.linear_algebra import factor_tree, solve_tree
from gaitsmith.qp.quadratic_program import QuadraticProgram
from gaitsmith.whole_body.contact import WRENCH_SIZE, Contacts, transmits
from gaitsmith.whole_body.frames import Body
from gaitsmith.whole_body.legs import Legs
from gaitsmith.whole_body.reference import NONE


class Motion(NamedTuple):
    """Dynamics and cost of one tick's accelerations; sizes are padded, see :mod:`gaitsmith.compiled.lanes`.

    Attributes:
        factor: (nv, nv) of M.
        inverse: (nv, nv) M⁻¹.
        push: (6 n + 1, nv) generalised force per unit of each wrench variable of n soles; after the last one r, the
            generalised force with all variables zero.
        pull: (nv, 6 n) its transpose, without r.
        cost: (nv, nv + 1) W, and c in the last column.
        solved: (nv, nv + 1) M⁻¹ times that.
        curvature: (nv, nv) P.
        response: (6 n + 1, nv) ``push`` P; (P r - M⁻¹ c)ᵀ in the last row.
        inner: (6 n + 1, 6 n) the same times ``pull``.
        row: (nv,) one task's Jacobian.
        turn: (3,) a rotation's error, world axes, rad.
    """

    factor: Matrix
    inverse: Matrix
    push: Matrix
    pull: Matrix
    cost: Matrix
    solved: Matrix
    curvature: Matrix
    response: Matrix
    inner: Matrix
    row: Vector
    turn: Vector


def variable_count(n_joints: int, n_soles: int) -> int:
    """Largest number of variables of the QP."""
    return n_joints + WRENCH_SIZE * n_soles


def make_motion(nv: int, n_soles: int) -> Motion:
    """Storage for a robot with ``nv`` degrees of freedom and ``n_soles`` soles."""
    w = WRENCH_SIZE * n_soles + 1
    sizes = ((nv, nv), (nv, nv), (w, nv), (nv, w), (nv, nv + 1), (nv, nv + 1), (nv, nv), (w, nv), (w, w))
    return Motion(*[*(np.zeros((padded(m), padded(n))) for m, n in sizes), np.zeros(nv), np.zeros(3)])


@kernel
def _add_passive(legs: Legs, q: Vector, v: Vector, rest: Vector) -> None:
    """Add the torques of the joints' springs, damping and dry friction, whose sign is smooth: no joint chatters."""
    for j in range(legs.passive.shape[0]):
        speed = v[6 + j]
        torque = -legs.passive[j, 0] * (q[7 + j] - legs.passive[j, 1]) - legs.passive[j, 2] * speed
        torque -= legs.passive[j, 3] * speed / math.sqrt(speed * speed + legs.passive[j, 4] ** 2)
        rest[6 + j] += torque


@kernel
def begin_motion(body: Body, contacts: Contacts, motion: Motion) -> int:
    """Dynamics of this tick, no cost yet; returns the number of variables, or -1 if M is not positive definite."""
    legs, nv, n_joints = body.legs, motion.row.shape[0], body.legs.torque_limit.shape[0]
    n = 0
    for leg in range(contacts.kind.shape[0]):
        contacts.first[leg] = n_joints + n
        if contacts.kind[leg] == NONE:
            continue
        axes, jacobian = contacts.axes[leg], contacts.jacobian[leg]
        for axis in range(WRENCH_SIZE):
            if not transmits(contacts.kind[leg], legs.half_width[leg], axis):
                continue
            first = 3 * (axis // 3)
            x, y, z = axes[0, axis - first], axes[1, axis - first], axes[2, axis - first]
            for k in range(nv):
                push = x * jacobian[first, k] + y * jacobian[first + 1, k] + z * jacobian[first + 2, k]
                motion.push[n, k] = push
                motion.pull[k, n] = push
            n += 1
    for k in range(nv):
        motion.push[n, k] = -body.state.bias[k]
        for j in range(nv + 1):
            motion.cost[k, j] = 0.0
        for j in range(nv):
            motion.inverse[k, j] = 0.0
        motion.inverse[k, k] = 1.0
    _add_passive(legs, body.q, body.v, motion.push[n])
    if not factor_tree(body.state.mass_matrix, body.tree.dof_parent, motion.factor):
        return -1
    solve_tree(motion.factor, body.tree.dof_parent, motion.inverse, nv)
    return int(n_joints + n)


@kernel
def add_row(motion: Motion, target: float, weight: float) -> None:
    """Add ``½ weight (motion.row q̈ - target)²`` to the cost."""
    nv = motion.row.shape[0]
    for i in range(nv):
        if motion.row[i] != 0.0:
            scaled = weight * motion.row[i]
            for j in range(nv):
                motion.cost[i, j] += scaled * motion.row[j]
            motion.cost[i, nv] += scaled * target


@kernel
def add_joint(motion: Motion, dof: int, target: float, weight: float) -> None:
    """The same for the acceleration of one degree of freedom."""
    motion.cost[dof, dof] += weight
    motion.cost[dof, motion.row.shape[0]] += weight * target


@kernel
def _multiply(factor: Matrix, other: Matrix, out: Matrix, rows: int, inner: int, columns: int) -> None:
    """``out = factor other``, two rows at once."""
    for half in range((rows + 1) // 2):
        i = 2 * half
        for c in range(0, columns, LANES):
            one, two = none(), none()
            for k in range(inner):
                line = take(other, k, c)
                one, two = plus(one, factor[i, k], line), plus(two, factor[i + 1, k], line)
            put(out, i, c, one)
            put(out, i + 1, c, two)


@kernel
def express_cost(motion: Motion, qp: QuadraticProgram, n_joints: int, n: int) -> None:
    """Make the cost that of the QP's n variables: gradient and lower triangle of the Hessian."""
    response, inner, nv, rest = motion.response, motion.inner, motion.row.shape[0], n - n_joints
    _multiply(motion.inverse, motion.cost, motion.solved, nv, nv, nv + 1)
    _multiply(motion.solved, motion.inverse, motion.curvature, nv, nv, nv)
    _multiply(motion.push, motion.curvature, response, rest + 1, nv, nv)
    for k in range(nv):
        response[rest, k] -= motion.solved[k, nv]
    _multiply(response, motion.pull, inner, rest + 1, nv, rest)
    for i in range(n_joints):
        qp.gradient[i] = response[rest, 6 + i]
        for j in range(i + 1):
            qp.hessian[i, j] = motion.curvature[6 + i, 6 + j]
    for i in range(rest):
        variable = n_joints + i
        qp.gradient[variable] = inner[rest, i]
        for j in range(n_joints):
            qp.hessian[variable, j] = response[i, 6 + j]
        for j in range(i + 1):
            qp.hessian[variable, n_joints + j] = inner[i, j]


@kernel
def accelerations(motion: Motion, x: Vector, n_joints: int, n: int, out: Vector) -> None:
    """q̈ of the variables x, into ``out`` (nv,)."""
    force, nv = motion.row, motion.row.shape[0]
    for k in range(nv):
        force[k], out[k] = motion.push[n - n_joints, k], 0.0
    for j in range(n_joints):
        force[6 + j] += x[j]
    for j in range(n - n_joints):
        share = x[n_joints + j]
        for k in range(nv):
            force[k] += share * motion.push[j, k]
    for k in range(nv):
        share = force[k]
        for i in range(nv):
            out[i] += share * motion.inverse[k, i]


@kernel
def joint_row(motion: Motion, dof: int, n_joints: int, n: int, row: Vector) -> float:
    """A degree of freedom's acceleration per unit of each variable, into ``row``; returns it with all of them zero."""
    found = 0.0
    for j in range(n_joints):
        row[j] = motion.inverse[dof, 6 + j]
    for j in range(n - n_joints + 1):
        found = 0.0
        for k in range(motion.row.shape[0]):
            found += motion.inverse[dof, k] * motion.push[j, k]
        if j < n - n_joints:
            row[n_joints + j] = found
    return found
