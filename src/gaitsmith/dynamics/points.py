"""What is fixed to a body: pose of a sole; Jacobian, velocity-product acceleration and velocity of a point.

``state`` is filled by :func:`gaitsmith.dynamics.update_dynamics`; ``body`` is a body's number, and ``point`` (3,) is
where a point of it is now, world axes, m. Spatial results have the linear part first, in world axes.
"""

from __future__ import annotations

from gaitsmith.compiled import Matrix, Vector, kernel
from gaitsmith.dynamics.tree import Tree, TreeState


@kernel
def point_jacobian(tree: Tree, state: TreeState, body: int, point: Vector, out: Matrix) -> None:
    """Spatial Jacobian of a point, into ``out`` (6, nv): rows 0-2 linear, rows 3-5 angular velocity per unit of v."""
    x, y, z = point[0] - state.reference[0], point[1] - state.reference[1], point[2] - state.reference[2]
    s = state.motion
    for row in range(6):
        for dof in range(out.shape[1]):
            out[row, dof] = 0.0
    dof = tree.body_dof[body]
    while dof >= 0:
        w0, w1, w2 = s[dof, 0], s[dof, 1], s[dof, 2]
        out[0, dof] = s[dof, 3] + w1 * z - w2 * y
        out[1, dof] = s[dof, 4] + w2 * x - w0 * z
        out[2, dof] = s[dof, 5] + w0 * y - w1 * x
        out[3, dof], out[4, dof], out[5, dof] = w0, w1, w2
        dof = tree.dof_parent[dof]


@kernel
def point_bias(tree: Tree, state: TreeState, body: int, point: Vector, out: Vector) -> None:
    """J̇ v of a point, into ``out`` (6,), m/s² and rad/s², without gravity.

    That is its acceleration and the body's angular acceleration while v is constant.
    """
    x, y, z = point[0] - state.reference[0], point[1] - state.reference[1], point[2] - state.reference[2]
    w0, w1, w2 = state.velocity[body, 0], state.velocity[body, 1], state.velocity[body, 2]
    a0, a1, a2 = state.acceleration[body, 0], state.acceleration[body, 1], state.acceleration[body, 2]
    u0 = state.velocity[body, 3] + w1 * z - w2 * y
    u1 = state.velocity[body, 4] + w2 * x - w0 * z
    u2 = state.velocity[body, 5] + w0 * y - w1 * x
    out[0] = state.acceleration[body, 3] + a1 * z - a2 * y + w1 * u2 - w2 * u1
    out[1] = state.acceleration[body, 4] + a2 * x - a0 * z + w2 * u0 - w0 * u2
    out[2] = state.acceleration[body, 5] + a0 * y - a1 * x + w0 * u1 - w1 * u0
    out[3], out[4], out[5] = a0, a1, a2


@kernel
def point_velocity(tree: Tree, state: TreeState, body: int, point: Vector, v: Vector, out: Vector) -> None:
    """J v of a point, into ``out`` (6,), m/s and rad/s, for any v (nv,): the state's own or another."""
    x, y, z = point[0] - state.reference[0], point[1] - state.reference[1], point[2] - state.reference[2]
    s = state.motion
    w0 = w1 = w2 = u0 = u1 = u2 = 0.0
    dof = tree.body_dof[body]
    while dof >= 0:
        w0, w1, w2 = w0 + s[dof, 0] * v[dof], w1 + s[dof, 1] * v[dof], w2 + s[dof, 2] * v[dof]
        u0, u1, u2 = u0 + s[dof, 3] * v[dof], u1 + s[dof, 4] * v[dof], u2 + s[dof, 5] * v[dof]
        dof = tree.dof_parent[dof]
    out[0], out[1], out[2] = u0 + w1 * z - w2 * y, u1 + w2 * x - w0 * z, u2 + w0 * y - w1 * x
    out[3], out[4], out[5] = w0, w1, w2


@kernel
def sole_pose(
    tree: Tree,
    state: TreeState,
    body: int,
    position: Vector,
    rotation: Matrix,
    position_out: Vector,
    rotation_out: Matrix,
) -> None:
    """Pose of a sole frame in the world; any frame fixed to a body works.

    Args:
        position, rotation: (3,) origin in body axes, m, and (3, 3) sole axes to body axes.
        position_out, rotation_out: receive the origin in the world, m, and sole axes to world.
    """
    r = state.body_rotation
    for i in range(3):
        a, b, c = r[body, i, 0], r[body, i, 1], r[body, i, 2]
        position_out[i] = state.body_position[body, i] + a * position[0] + b * position[1] + c * position[2]
        for j in range(3):
            rotation_out[i, j] = a * rotation[0, j] + b * rotation[1, j] + c * rotation[2, j]
