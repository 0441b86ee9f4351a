"""Points fixed to a body: Jacobian, velocity-product acceleration, velocity; linear part first, world axes."""

from __future__ import annotations

from gaitsmith.compiled import Matrix, Vector, kernel
from gaitsmith.dynamics.tree import Tree, TreeState


@kernel
def point_jacobian(tree: Tree, state: TreeState, body: int, point: Vector, out: Matrix) -> None:
    """Spatial Jacobian of a point of a body.

    Args:
        tree: the tree.
        state: filled by :func:`gaitsmith.dynamics.update_dynamics`.
        body: the body's number.
        point: (3,) where the point is now, world axes, m.
        out: (6, nv) receives linear velocity (rows 0-2) and angular velocity (rows 3-5) per unit of v.
    """
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
    """J̇ v of a point of a body: its acceleration and the body's angular acceleration while v is constant.

    Args:
        tree: the tree.
        state: filled by :func:`gaitsmith.dynamics.update_dynamics`.
        body: the body's number.
        point: (3,) where the point is now, world axes, m.
        out: (6,) receives m/s² and rad/s², without gravity.
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
    """J v of a point of a body, for any v (the state's own or another).

    Args:
        tree: the tree.
        state: filled by :func:`gaitsmith.dynamics.update_dynamics`.
        body: the body's number.
        point: (3,) where the point is now, world axes, m.
        v: (nv,) generalised velocity.
        out: (6,) receives m/s and rad/s.
    """
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
