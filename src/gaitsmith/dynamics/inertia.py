"""What it takes to move the bodies: mass matrix, bias force, centre of mass.

Composite rigid bodies and recursive Newton-Euler in one pass, all about the reference point in world axes.
"""

from __future__ import annotations

from gaitsmith.compiled import Vector, kernel
from gaitsmith.dynamics.tree import Tree, TreeState


@kernel
def body_inertia_and_force(tree: Tree, state: TreeState) -> None:
    """Fill ``composite`` and ``force`` with every body's own inertia and force (no subtree yet)."""
    g0, g1, g2 = tree.gravity[0], tree.gravity[1], tree.gravity[2]
    for body in range(1, len(tree.body_parent)):
        r, k, c = state.body_rotation[body], tree.inertia[body], tree.mass_centre[body]
        m = tree.mass[body]
        x = state.body_position[body, 0] - state.reference[0] + r[0, 0] * c[0] + r[0, 1] * c[1] + r[0, 2] * c[2]
        y = state.body_position[body, 1] - state.reference[1] + r[1, 0] * c[0] + r[1, 1] * c[1] + r[1, 2] * c[2]
        z = state.body_position[body, 2] - state.reference[2] + r[2, 0] * c[0] + r[2, 1] * c[1] + r[2, 2] * c[2]
        hx, hy, hz = m * x, m * y, m * z
        t00 = r[0, 0] * k[0, 0] + r[0, 1] * k[0, 1] + r[0, 2] * k[0, 2]
        t01 = r[0, 0] * k[0, 1] + r[0, 1] * k[1, 1] + r[0, 2] * k[1, 2]
        t02 = r[0, 0] * k[0, 2] + r[0, 1] * k[1, 2] + r[0, 2] * k[2, 2]
        t10 = r[1, 0] * k[0, 0] + r[1, 1] * k[0, 1] + r[1, 2] * k[0, 2]
        t11 = r[1, 0] * k[0, 1] + r[1, 1] * k[1, 1] + r[1, 2] * k[1, 2]
        t12 = r[1, 0] * k[0, 2] + r[1, 1] * k[1, 2] + r[1, 2] * k[2, 2]
        t20 = r[2, 0] * k[0, 0] + r[2, 1] * k[0, 1] + r[2, 2] * k[0, 2]
        t21 = r[2, 0] * k[0, 1] + r[2, 1] * k[1, 1] + r[2, 2] * k[1, 2]
        t22 = r[2, 0] * k[0, 2] + r[2, 1] * k[1, 2] + r[2, 2] * k[2, 2]
        xx = t00 * r[0, 0] + t01 * r[0, 1] + t02 * r[0, 2] + hy * y + hz * z
        yy = t10 * r[1, 0] + t11 * r[1, 1] + t12 * r[1, 2] + hx * x + hz * z
        zz = t20 * r[2, 0] + t21 * r[2, 1] + t22 * r[2, 2] + hx * x + hy * y
        xy = t00 * r[1, 0] + t01 * r[1, 1] + t02 * r[1, 2] - hx * y
        xz = t00 * r[2, 0] + t01 * r[2, 1] + t02 * r[2, 2] - hx * z
        yz = t10 * r[2, 0] + t11 * r[2, 1] + t12 * r[2, 2] - hy * z
        inertia = state.composite[body]
        inertia[0], inertia[1], inertia[2], inertia[3] = m, hx, hy, hz
        inertia[4], inertia[5], inertia[6], inertia[7], inertia[8], inertia[9] = xx, yy, zz, xy, xz, yz

        w0, w1, w2 = state.velocity[body, 0], state.velocity[body, 1], state.velocity[body, 2]
        u0, u1, u2 = state.velocity[body, 3], state.velocity[body, 4], state.velocity[body, 5]
        a0, a1, a2 = state.acceleration[body, 0], state.acceleration[body, 1], state.acceleration[body, 2]
        b0 = state.acceleration[body, 3] - g0
        b1 = state.acceleration[body, 4] - g1
        b2 = state.acceleration[body, 5] - g2
        p0 = m * u0 + w1 * hz - w2 * hy
        p1 = m * u1 + w2 * hx - w0 * hz
        p2 = m * u2 + w0 * hy - w1 * hx
        l0 = xx * w0 + xy * w1 + xz * w2 + hy * u2 - hz * u1
        l1 = xy * w0 + yy * w1 + yz * w2 + hz * u0 - hx * u2
        l2 = xz * w0 + yz * w1 + zz * w2 + hx * u1 - hy * u0
        force = state.force[body]
        force[0] = xx * a0 + xy * a1 + xz * a2 + hy * b2 - hz * b1 + w1 * l2 - w2 * l1 + u1 * p2 - u2 * p1
        force[1] = xy * a0 + yy * a1 + yz * a2 + hz * b0 - hx * b2 + w2 * l0 - w0 * l2 + u2 * p0 - u0 * p2
        force[2] = xz * a0 + yz * a1 + zz * a2 + hx * b1 - hy * b0 + w0 * l1 - w1 * l0 + u0 * p1 - u1 * p0
        force[3] = m * b0 + a1 * hz - a2 * hy + w1 * p2 - w2 * p1
        force[4] = m * b1 + a2 * hx - a0 * hz + w2 * p0 - w0 * p2
        force[5] = m * b2 + a0 * hy - a1 * hx + w0 * p1 - w1 * p0


@kernel
def accumulate_subtrees(tree: Tree, state: TreeState) -> None:
    """Add every body's inertia and force to its parent's, so that both hold whole subtrees; body 0 gets the total."""
    composite, force = state.composite, state.force
    for k in range(10):
        composite[0, k] = 0.0
    for k in range(6):
        force[0, k] = 0.0
    for body in range(len(tree.body_parent) - 1, 0, -1):
        up = tree.body_parent[body]
        for k in range(10):
            composite[up, k] += composite[body, k]
        for k in range(6):
            force[up, k] += force[body, k]


@kernel
def mass_matrix_and_bias(tree: Tree, state: TreeState, v: Vector) -> None:
    """Fill ``mass_matrix``, ``bias`` and everything about the centre of mass from the gathered subtrees."""
    s, mass_matrix, jacobian = state.motion, state.mass_matrix, state.com_jacobian
    total = tree.total_mass
    per_mass = 1.0 / total if total > 0.0 else 0.0
    for k in range(3):
        state.com[k] = state.reference[k] + state.composite[0, 1 + k] * per_mass
        state.com_bias[k] = state.force[0, 3 + k] * per_mass + tree.gravity[k]
        state.com_velocity[k] = 0.0
    for dof in range(len(tree.dof_body)):
        body = tree.dof_body[dof]
        inertia, force = state.composite[body], state.force[body]
        w0, w1, w2, u0, u1, u2 = s[dof, 0], s[dof, 1], s[dof, 2], s[dof, 3], s[dof, 4], s[dof, 5]
        m, hx, hy, hz = inertia[0], inertia[1], inertia[2], inertia[3]
        xx, yy, zz, xy, xz, yz = inertia[4], inertia[5], inertia[6], inertia[7], inertia[8], inertia[9]
        p0 = m * u0 + w1 * hz - w2 * hy
        p1 = m * u1 + w2 * hx - w0 * hz
        p2 = m * u2 + w0 * hy - w1 * hx
        l0 = xx * w0 + xy * w1 + xz * w2 + hy * u2 - hz * u1
        l1 = xy * w0 + yy * w1 + yz * w2 + hz * u0 - hx * u2
        l2 = xz * w0 + yz * w1 + zz * w2 + hx * u1 - hy * u0
        state.bias[dof] = w0 * force[0] + w1 * force[1] + w2 * force[2] + u0 * force[3] + u1 * force[4] + u2 * force[5]
        jacobian[0, dof], jacobian[1, dof], jacobian[2, dof] = p0 * per_mass, p1 * per_mass, p2 * per_mass
        for k in range(3):
            state.com_velocity[k] += jacobian[k, dof] * v[dof]
        other = dof
        while other >= 0:
            entry = s[other, 0] * l0 + s[other, 1] * l1 + s[other, 2] * l2
            entry += s[other, 3] * p0 + s[other, 4] * p1 + s[other, 5] * p2
            mass_matrix[dof, other] = entry
            mass_matrix[other, dof] = entry
            other = tree.dof_parent[other]
        mass_matrix[dof, dof] += tree.armature[dof]
