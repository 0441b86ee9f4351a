"""Accelerations as a linear function of joint torques and sole wrenches: ``q̈ = M⁻¹(Sᵀτ + Jᵀλ - h)``."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import Matrix, Vector, kernel
from gaitsmith.dynamics.linear_algebra import cholesky, cholesky_solve_matrix
from gaitsmith.dynamics.tree import TreeState
from gaitsmith.whole_body.contact_wrench import moment_axis, wrench_size
from gaitsmith.whole_body.frames import Frames, Legs
from gaitsmith.whole_body.targets import Targets

WRENCH_VARIABLES = 12  # of two rectangular soles


class MotionMap(NamedTuple):
    """The map of this tick and its scratch.

    Attributes:
        factor: (nv, nv) Cholesky factor of M.
        map: (nv, nj + 13) acceleration per unit of each variable; the column after the last variable is scratch.
        free: (nv,) acceleration with all variables zero.
        row: (nv,) one task's Jacobian.
        image: (nj + 12,) the same in terms of the variables.
    """

    factor: Matrix
    map: Matrix
    free: Vector
    row: Vector
    image: Vector


def make_motion_map(nv: int, n_joints: int) -> MotionMap:
    """Storage for a robot with ``nv`` degrees of freedom and ``n_joints`` joints."""
    n = n_joints + WRENCH_VARIABLES
    return MotionMap(np.zeros((nv, nv)), np.zeros((nv, n + 1)), np.zeros(nv), np.zeros(nv), np.zeros(n))


@kernel
def map_motion(state: TreeState, legs: Legs, targets: Targets, frames: Frames, motion: MotionMap, n_joints: int) -> int:
    """Fill ``map`` and ``free``; returns the number of variables, or -1 if M is not positive definite."""
    nv = motion.free.shape[0]
    n = n_joints
    for i in range(nv):
        for j in range(n_joints):
            motion.map[i, j] = 0.0
    for j in range(n_joints):
        motion.map[6 + j, j] = 1.0
    for leg in range(2):
        if targets.in_contact[leg] == 0:
            continue
        axes = frames.contact_rotation[leg]
        jacobian = frames.sole_jacobian[leg]
        for variable in range(wrench_size(legs.half_width[leg])):
            first, axis = 0, variable
            if variable >= 3:
                first, axis = 3, moment_axis(legs.half_width[leg], variable - 3)
            for k in range(nv):
                motion.map[k, n] = (
                    axes[0, axis] * jacobian[first, k]
                    + axes[1, axis] * jacobian[first + 1, k]
                    + axes[2, axis] * jacobian[first + 2, k]
                )
            n += 1
    for k in range(nv):
        motion.map[k, n] = -state.bias[k]
    if not cholesky(state.mass_matrix, motion.factor, nv):
        return -1
    cholesky_solve_matrix(motion.factor, motion.map, nv, n + 1)
    for k in range(nv):
        motion.free[k] = motion.map[k, n]
    return n
