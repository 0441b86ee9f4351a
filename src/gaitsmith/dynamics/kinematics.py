"""Where the bodies are and how they move: poses, motion subspaces, velocities, velocity-product accelerations."""

from __future__ import annotations

from gaitsmith.compiled import Matrix, Vector, kernel
from gaitsmith.dynamics.rotation import axis_angle_entries, entries, product_entries, rotation_entries, turned
from gaitsmith.dynamics.tree import BALL, FREE, HINGE, SLIDE, Tree, TreeState


@kernel
def _set_turning(motion: Matrix, dof: int, x: float, y: float, z: float, px: float, py: float, pz: float) -> None:
    """Motion subspace of a rotation about the axis (x, y, z) through p, which is relative to the reference."""
    motion[dof, 0] = x
    motion[dof, 1] = y
    motion[dof, 2] = z
    motion[dof, 3] = py * z - pz * y
    motion[dof, 4] = pz * x - px * z
    motion[dof, 5] = px * y - py * x


@kernel
def _set_sliding(motion: Matrix, dof: int, x: float, y: float, z: float) -> None:
    """Motion subspace of a translation along (x, y, z)."""
    motion[dof, 0] = motion[dof, 1] = motion[dof, 2] = 0.0
    motion[dof, 3] = x
    motion[dof, 4] = y
    motion[dof, 5] = z


@kernel
def forward_kinematics(tree: Tree, state: TreeState, q: Vector) -> None:
    """Fill ``body_rotation``, ``body_position``, ``reference`` and ``motion`` from the configuration q."""
    rotation, position, motion = state.body_rotation, state.body_position, state.motion
    first_is_free = tree.joint_kind[0] == FREE
    rx = q[0] if first_is_free else tree.body_offset[1, 0]
    ry = q[1] if first_is_free else tree.body_offset[1, 1]
    rz = q[2] if first_is_free else tree.body_offset[1, 2]
    state.reference[0], state.reference[1], state.reference[2] = rx, ry, rz
    for body in range(1, len(tree.body_parent)):
        up = tree.body_parent[body]
        p = rotation[up]
        o = tree.body_offset[body]
        t = tree.body_turn[body]
        r = entries(p)
        dx, dy, dz = turned(r, o[0], o[1], o[2])
        px, py, pz = position[up, 0] + dx, position[up, 1] + dy, position[up, 2] + dz
        r = product_entries(r, entries(t))
        first = tree.body_joint[body]
        for joint in range(first, first + tree.body_joint_count[body]):
            kind, i, dof = tree.joint_kind[joint], tree.joint_q[joint], tree.joint_v[joint]
            if kind == FREE:
                px, py, pz = q[i], q[i + 1], q[i + 2]
                r = rotation_entries(q[i + 3], q[i + 4], q[i + 5], q[i + 6])
                _set_sliding(motion, dof, 1.0, 0.0, 0.0)
                _set_sliding(motion, dof + 1, 0.0, 1.0, 0.0)
                _set_sliding(motion, dof + 2, 0.0, 0.0, 1.0)
                _set_turning(motion, dof + 3, r[0], r[3], r[6], px - rx, py - ry, pz - rz)
                _set_turning(motion, dof + 4, r[1], r[4], r[7], px - rx, py - ry, pz - rz)
                _set_turning(motion, dof + 5, r[2], r[5], r[8], px - rx, py - ry, pz - rz)
                continue
            x, y, z = tree.joint_axis[joint, 0], tree.joint_axis[joint, 1], tree.joint_axis[joint, 2]
            wx, wy, wz = turned(r, x, y, z)
            if kind == SLIDE:
                travel = q[i] - tree.joint_zero[joint]
                px, py, pz = px + wx * travel, py + wy * travel, pz + wz * travel
                _set_sliding(motion, dof, wx, wy, wz)
                continue
            ax, ay, az = tree.joint_anchor[joint, 0], tree.joint_anchor[joint, 1], tree.joint_anchor[joint, 2]
            dx, dy, dz = turned(r, ax, ay, az)
            cx, cy, cz = px + dx, py + dy, pz + dz
            if kind == HINGE:
                _set_turning(motion, dof, wx, wy, wz, cx - rx, cy - ry, cz - rz)
                r = product_entries(r, axis_angle_entries(x, y, z, q[i] - tree.joint_zero[joint]))
            else:
                r = product_entries(r, rotation_entries(q[i], q[i + 1], q[i + 2], q[i + 3]))
                _set_turning(motion, dof, r[0], r[3], r[6], cx - rx, cy - ry, cz - rz)
                _set_turning(motion, dof + 1, r[1], r[4], r[7], cx - rx, cy - ry, cz - rz)
                _set_turning(motion, dof + 2, r[2], r[5], r[8], cx - rx, cy - ry, cz - rz)
            dx, dy, dz = turned(r, ax, ay, az)
            px, py, pz = cx - dx, cy - dy, cz - dz
        b = rotation[body]
        b[0, 0], b[0, 1], b[0, 2] = r[0], r[1], r[2]
        b[1, 0], b[1, 1], b[1, 2] = r[3], r[4], r[5]
        b[2, 0], b[2, 1], b[2, 2] = r[6], r[7], r[8]
        position[body, 0], position[body, 1], position[body, 2] = px, py, pz


@kernel
def forward_velocities(tree: Tree, state: TreeState, v: Vector) -> None:
    """Fill ``velocity`` and ``acceleration`` (v constant) of all bodies; :func:`forward_kinematics` comes first."""
    velocity, acceleration, s = state.velocity, state.acceleration, state.motion
    for body in range(1, len(tree.body_parent)):
        up = tree.body_parent[body]
        w0, w1, w2 = velocity[up, 0], velocity[up, 1], velocity[up, 2]
        u0, u1, u2 = velocity[up, 3], velocity[up, 4], velocity[up, 5]
        a0, a1, a2 = acceleration[up, 0], acceleration[up, 1], acceleration[up, 2]
        b0, b1, b2 = acceleration[up, 3], acceleration[up, 4], acceleration[up, 5]
        first = tree.body_joint[body]
        for joint in range(first, first + tree.body_joint_count[body]):
            kind, dof = tree.joint_kind[joint], tree.joint_v[joint]
            last = dof + 1
            if kind == FREE:
                u0, u1, u2 = u0 + v[dof], u1 + v[dof + 1], u2 + v[dof + 2]
                dof += 3
            if kind in (FREE, BALL):
                last = dof + 3
            m0 = m1 = m2 = n0 = n1 = n2 = 0.0
            for i in range(dof, last):
                m0, m1, m2 = m0 + s[i, 0] * v[i], m1 + s[i, 1] * v[i], m2 + s[i, 2] * v[i]
                n0, n1, n2 = n0 + s[i, 3] * v[i], n1 + s[i, 4] * v[i], n2 + s[i, 5] * v[i]
            # A free joint's world translation is fixed; every other axis is carried along by what lies before it.
            a0 += w1 * m2 - w2 * m1
            a1 += w2 * m0 - w0 * m2
            a2 += w0 * m1 - w1 * m0
            b0 += w1 * n2 - w2 * n1 + u1 * m2 - u2 * m1
            b1 += w2 * n0 - w0 * n2 + u2 * m0 - u0 * m2
            b2 += w0 * n1 - w1 * n0 + u0 * m1 - u1 * m0
            w0, w1, w2 = w0 + m0, w1 + m1, w2 + m2
            u0, u1, u2 = u0 + n0, u1 + n1, u2 + n2
        velocity[body, 0], velocity[body, 1], velocity[body, 2] = w0, w1, w2
        velocity[body, 3], velocity[body, 4], velocity[body, 5] = u0, u1, u2
        acceleration[body, 0], acceleration[body, 1], acceleration[body, 2] = a0, a1, a2
        acceleration[body, 3], acceleration[body, 4], acceleration[body, 5] = b0, b1, b2
