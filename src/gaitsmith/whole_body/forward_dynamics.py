"""Accelerations as a linear function of joint torques and sole wrenches: ``q̈ = M⁻¹(Sᵀτ + Jᵀλ + τ_p - h)``."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import Matrix, Vector, kernel
from gaitsmith.dynamics.linear_algebra import factor_tree, solve_tree
from gaitsmith.whole_body.contact import WRENCH_SIZE, Contacts, transmits
from gaitsmith.whole_body.frames import Body
from gaitsmith.whole_body.legs import Legs
from gaitsmith.whole_body.reference import NONE


class MotionMap(NamedTuple):
    """The map of this tick and its scratch; n is the largest number of variables.

    Attributes:
        factor: (nv, nv) of M.
        map: (nv, n + 1) acceleration per unit of each variable; the column after the last variable is scratch.
        free: (nv,) acceleration with all variables zero.
        row: (nv,) one task's Jacobian.
        image: (n,) the same in terms of the variables.
        turn: (3,) a rotation's error, world axes, rad.
    """

    factor: Matrix
    map: Matrix
    free: Vector
    row: Vector
    image: Vector
    turn: Vector


def variable_count(n_joints: int, n_soles: int) -> int:
    """Largest number of variables of the QP."""
    return n_joints + WRENCH_SIZE * n_soles


def make_motion_map(nv: int, n_joints: int, n_soles: int) -> MotionMap:
    """Storage for a robot with ``nv`` degrees of freedom, ``n_joints`` joints and ``n_soles`` soles."""
    n = variable_count(n_joints, n_soles)
    sizes = ((nv, nv), (nv, n + 1), (nv,), (nv,), (n,), (3,))
    return MotionMap(*(np.zeros(size) for size in sizes))


@kernel
def _add_passive(legs: Legs, q: Vector, v: Vector, motion: MotionMap, column: int) -> None:
    """Add the torques of the joints' springs, damping and dry friction, whose sign is smooth: no joint chatters."""
    for j in range(legs.passive.shape[0]):
        speed = v[6 + j]
        torque = -legs.passive[j, 0] * (q[7 + j] - legs.passive[j, 1]) - legs.passive[j, 2] * speed
        torque -= legs.passive[j, 3] * speed / math.sqrt(speed * speed + legs.passive[j, 4] ** 2)
        motion.map[6 + j, column] += torque


@kernel
def forward_dynamics_map(body: Body, contacts: Contacts, motion: MotionMap) -> int:
    """Fill ``map`` and ``free``; returns the number of variables, or -1 if M is not positive definite."""
    state, legs, parent = body.state, body.legs, body.tree.dof_parent
    nv, n_joints = motion.free.shape[0], legs.torque_limit.shape[0]
    n: int = n_joints
    for i in range(nv):
        for j in range(n_joints):
            motion.map[i, j] = 0.0
    for j in range(n_joints):
        motion.map[6 + j, j] = 1.0
    for leg in range(contacts.kind.shape[0]):
        contacts.first[leg] = n
        if contacts.kind[leg] == NONE:
            continue
        axes, jacobian = contacts.axes[leg], contacts.jacobian[leg]
        for axis in range(WRENCH_SIZE):
            if not transmits(contacts.kind[leg], legs.half_width[leg], axis):
                continue
            first = 3 * (axis // 3)
            x, y, z = axes[0, axis - first], axes[1, axis - first], axes[2, axis - first]
            for k in range(nv):
                motion.map[k, n] = x * jacobian[first, k] + y * jacobian[first + 1, k] + z * jacobian[first + 2, k]
            n += 1
    for k in range(nv):
        motion.map[k, n] = -state.bias[k]
    _add_passive(legs, body.q, body.v, motion, n)
    if not factor_tree(state.mass_matrix, parent, motion.factor):
        return -1
    solve_tree(motion.factor, parent, motion.map, n + 1)
    for k in range(nv):
        motion.free[k] = motion.map[k, n]
    return n
