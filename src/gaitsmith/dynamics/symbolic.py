"""Rigid-body dynamics as CasADi expressions, for any tree in a MuJoCo model, rooted at any of its bodies.

One recursive Newton-Euler pass in body frames (about 1,600 instructions for 12 joints). The root may be the
floating base, the world, or a foot that stands still: joints between the root and the base are then traversed
backwards. Joints may be held at an angle; what hangs on them is one body with what carries them. Reflected inertia,
joint damping and springs are those of the model, as in ``mj_inverse``.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt

from gaitsmith.dynamics.rotation import rotation_matrix
from gaitsmith.errors import BadInput

_FREE, _BALL, _SLIDE, _HINGE = 0, 1, 2, 3  # mjtJoint

_TRIFLE = 1e-13  # entries of a rotation that are rounding: as zeros they cost nothing

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class _Shift:
    """Fixed transform to the next frame: its origin and axes in this one."""

    position: Array
    rotation: Array

    def then(self, after: _Shift) -> _Shift:
        """Both in a row."""
        rotation = self.rotation @ after.rotation
        clean = np.where(np.abs(rotation) < _TRIFLE, 0.0, rotation)
        return _Shift(self.position + self.rotation @ after.position, clean)


@dataclass(frozen=True)
class _Joint:
    """One degree of freedom along or about ``axis``; ``sign`` is -1 when it is traversed towards the base."""

    axis: Array
    dof: int
    qpos: int
    reference: float
    hinge: bool
    sign: float


@dataclass(frozen=True)
class _Link:
    """A body as seen from the root: the steps that lead to it and its inertia about its centre of mass."""

    body: int
    parent: int
    steps: tuple[_Shift | _Joint, ...]


def _joint_steps(model: Any, body: int, held: Mapping[int, float]) -> list[_Shift | _Joint]:
    """Steps from a body's parent to the body; fixed ones in a row are one."""
    steps: list[_Shift | _Joint] = []

    def shift(position: Array, rotation: Array) -> None:
        last = steps.pop() if steps and isinstance(steps[-1], _Shift) else _Shift(np.zeros(3), np.eye(3))
        assert isinstance(last, _Shift)
        steps.append(last.then(_Shift(position, rotation)))

    shift(model.body_pos[body].copy(), rotation_matrix(model.body_quat[body]))
    first = model.body_jntadr[body]
    for joint in range(first, first + model.body_jntnum[body]):
        kind = int(model.jnt_type[joint])
        name = f"joint {joint} of body {body}"
        if kind not in (_SLIDE, _HINGE):
            raise BadInput(name, kind, "a hinge or a slide, and at most one free joint, at the root of the tree")
        anchor = model.jnt_pos[joint].copy() if kind == _HINGE else np.zeros(3)
        qpos, dof = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
        axis, reference = np.where(np.abs(model.jnt_axis[joint]) < 1e-15, 0.0, model.jnt_axis[joint]), model.qpos0[qpos]
        shift(anchor, np.eye(3))
        if dof not in held:
            steps.append(_Joint(axis, dof, qpos, float(reference), kind == _HINGE, 1.0))
        elif kind == _HINGE:
            shift(np.zeros(3), np.array(ca.DM(turn_about(axis, ca.DM(held[dof] - reference)))))
        else:
            shift(axis * (held[dof] - reference), np.eye(3))
        shift(-anchor, np.eye(3))
    return steps


def _reversed(steps: list[_Shift | _Joint]) -> tuple[_Shift | _Joint, ...]:
    """The same path walked from the body to its parent."""
    found: list[_Shift | _Joint] = []
    for step in reversed(steps):
        if isinstance(step, _Shift):
            found.append(_Shift(-step.rotation.T @ step.position, step.rotation.T))
        else:
            found.append(_Joint(step.axis, step.dof, step.qpos, step.reference, step.hinge, -step.sign))
    return tuple(found)


def _links(model: Any, root: int, held: Mapping[int, float]) -> list[_Link]:
    """All bodies in the order in which a walk from ``root`` meets them."""
    neighbours: dict[int, list[tuple[int, tuple[_Shift | _Joint, ...]]]] = {b: [] for b in range(model.nbody)}
    for body in range(1, model.nbody):
        parent = int(model.body_parentid[body])
        first = model.body_jntadr[body]
        if model.body_jntnum[body] and model.jnt_type[first] == _FREE:
            continue
        steps = _joint_steps(model, body, held)
        if parent == 0 and root != 0:
            continue
        neighbours[parent].append((body, tuple(steps)))
        neighbours[body].append((parent, _reversed(steps)))
    found = [_Link(root, -1, ())]
    seen = {root}
    pending = deque([root])
    while pending:
        body = pending.popleft()
        for other, path in neighbours[body]:
            if other not in seen:
                seen.add(other)
                pending.append(other)
                found.append(_Link(other, body, path))
    return found


def turn_about(axis: Array, angle: Any) -> Any:
    """Rotation matrix about a unit axis."""
    outer = np.outer(axis, axis)
    return ca.DM(outer) + ca.cos(angle) * ca.DM(np.eye(3) - outer) + ca.sin(angle) * ca.DM(np.array(ca.skew(axis)))


@dataclass
class BodyMotion:
    """Motion of one body: pose in the root's inertial frame; velocities and accelerations in body axes.

    Attributes:
        rotation: body to inertial frame (3, 3).
        position: body origin, inertial frame, m.
        omega: angular velocity, rad/s.
        velocity: of the body's origin, m/s.
        alpha: angular acceleration, rad/s².
        acceleration: of the body's origin minus gravity, m/s².
    """

    rotation: Any
    position: Any
    omega: Any
    velocity: Any
    alpha: Any
    acceleration: Any


@dataclass(frozen=True)
class ExternalWrench:
    """Force and moment on a body, inertial axes, at ``point`` in body coordinates."""

    body: int
    point: Any
    force: Any
    moment: Any


@dataclass
class InverseDynamics:
    """Result of the recursion.

    Attributes:
        motion: motion of every body by its index.
        generalized: joint forces by index of velocity (missing where the root takes the place of a free joint).
        root_force: force that the root needs from outside, root axes, N.
        root_moment: moment about the root body's origin, root axes, N·m.
    """

    motion: dict[int, BodyMotion]
    generalized: dict[int, Any] = field(default_factory=dict)
    root_force: Any = None
    root_moment: Any = None


def _advance(motion: BodyMotion, step: _Shift | _Joint, q: Any, v: Any, a: Any) -> BodyMotion:
    """Motion of the next frame along a path."""
    m = motion
    if isinstance(step, _Shift):
        p, R = ca.DM(step.position), ca.DM(step.rotation)
        spin = ca.cross(m.omega, p)
        return BodyMotion(
            ca.mtimes(m.rotation, R),
            m.position + ca.mtimes(m.rotation, p),
            ca.mtimes(R.T, m.omega),
            ca.mtimes(R.T, m.velocity + spin),
            ca.mtimes(R.T, m.alpha),
            ca.mtimes(R.T, m.acceleration + ca.cross(m.alpha, p) + ca.cross(m.omega, spin)),
        )
    axis = ca.DM(step.axis)
    s, sd, sdd = step.sign * (q[step.qpos] - step.reference), step.sign * v[step.dof], step.sign * a[step.dof]
    if step.hinge:
        R = turn_about(step.axis, s)
        omega = ca.mtimes(R.T, m.omega)
        return BodyMotion(
            ca.mtimes(m.rotation, R),
            m.position,
            omega + axis * sd,
            ca.mtimes(R.T, m.velocity),
            ca.mtimes(R.T, m.alpha) + axis * sdd + ca.cross(omega, axis * sd),
            ca.mtimes(R.T, m.acceleration),
        )
    p = axis * s
    spin = ca.cross(m.omega, p)
    acceleration = m.acceleration + ca.cross(m.alpha, p) + ca.cross(m.omega, spin + 2 * axis * sd) + axis * sdd
    return BodyMotion(
        m.rotation, m.position + ca.mtimes(m.rotation, p), m.omega, m.velocity + spin + axis * sd, m.alpha, acceleration
    )


@dataclass
class _Rigid:
    """Bodies that move as one, in the frame of the first of them: mass, first moment, inertia about its origin."""

    mass: float
    moment: Array
    inertia: Array


def _own(model: Any, body: int, at: _Shift) -> _Rigid:
    """A body's inertia in the frame of the body that carries it."""
    mass = float(model.body_mass[body])
    com = at.position + at.rotation @ model.body_ipos[body]
    axes = at.rotation @ rotation_matrix(model.body_iquat[body])
    about = axes @ np.diag(model.body_inertia[body]) @ axes.T + mass * (com @ com * np.eye(3) - np.outer(com, com))
    return _Rigid(mass, mass * com, about)


def newton_euler(
    model: Any,
    root: int,
    start: BodyMotion,
    q: Any,
    v: Any,
    a: Any,
    wrenches: tuple[ExternalWrench, ...] = (),
    held: Mapping[int, float] | None = None,
) -> InverseDynamics:
    """Recursive Newton-Euler from ``root``.

    Args:
        model: the ``MjModel``.
        root: index of the body whose motion is given.
        start: its motion; ``acceleration`` must hold the gravity term (minus gravity).
        q, v, a: positions, velocities and accelerations in MuJoCo's order (nq, nv, nv); only joint entries are read.
        wrenches: forces from outside on other bodies.
        held: angles of the joints that do not move, by their index in `v`; their forces are not in the result.

    Raises:
        BadInput: a joint is neither hinge nor slide.
    """
    links = _links(model, root, held or {})
    motion = {root: start}
    carrier = {root: (root, _Shift(np.zeros(3), np.eye(3)))}  # of every body: the one that it moves with, and where
    rigid = {root: _own(model, root, carrier[root][1])}
    rotations: dict[tuple[int, int], Any] = {}
    for link in links[1:]:
        current = motion[link.parent]
        for index, step in enumerate(link.steps):
            if isinstance(step, _Joint) and step.hinge:
                rotations[link.body, index] = turn_about(step.axis, step.sign * (q[step.qpos] - step.reference))
            current = _advance(current, step, q, v, a)
        motion[link.body] = current
        first, at = carrier[link.parent]
        if len(link.steps) == 1 and isinstance(link.steps[0], _Shift):
            at = at.then(link.steps[0])
        else:
            first, at = link.body, _Shift(np.zeros(3), np.eye(3))
            rigid[first] = _Rigid(0.0, np.zeros(3), np.zeros((3, 3)))
        carrier[link.body] = first, at
        own = _own(model, link.body, at)
        for name, value in vars(own).items():
            setattr(rigid[first], name, getattr(rigid[first], name) + value)
    result = InverseDynamics(motion)
    force: dict[int, Any] = {}
    moment: dict[int, Any] = {}
    for body, composite in rigid.items():
        m = motion[body]
        mass, first_moment = composite.mass, composite.moment
        com = first_moment / mass if mass else first_moment
        central = composite.inertia - mass * (com @ com * np.eye(3) - np.outer(com, com))
        inertia = ca.DM(np.where(np.abs(central) < _TRIFLE * np.abs(central).max(), 0.0, central))
        spin = ca.cross(m.omega, com)
        f = mass * (m.acceleration + ca.cross(m.alpha, com) + ca.cross(m.omega, spin))
        n = ca.mtimes(inertia, m.alpha) + ca.cross(m.omega, ca.mtimes(inertia, m.omega)) + ca.cross(com, f)
        force[body], moment[body] = f, n
    for wrench in wrenches:
        body, at = carrier[wrench.body]
        R, point = motion[body].rotation.T, ca.DM(at.position) + ca.mtimes(ca.DM(at.rotation), wrench.point)
        local = ca.mtimes(R, wrench.force)
        force[body] -= local
        moment[body] -= ca.mtimes(R, wrench.moment) + ca.cross(point, local)
    for link in reversed(links[1:]):
        if link.body not in force:
            continue
        f, n = force[link.body], moment[link.body]
        for index in range(len(link.steps) - 1, -1, -1):
            step = link.steps[index]
            if isinstance(step, _Shift):
                R = ca.DM(step.rotation)
                f, n = ca.mtimes(R, f), ca.mtimes(R, n)
                n += ca.cross(ca.DM(step.position), f)
                continue
            dof, joint = step.dof, int(model.dof_jntid[step.dof])
            load = ca.dot(ca.DM(step.axis), n if step.hinge else f) * step.sign
            spring = float(model.jnt_stiffness[joint].flat[0])
            load += float(model.dof_armature[dof]) * a[dof] + float(model.dof_damping[dof].flat[0]) * v[dof]
            load += spring * (q[step.qpos] - float(model.qpos_spring[step.qpos]))
            result.generalized[dof] = load
            if step.hinge:
                f, n = ca.mtimes(rotations[link.body, index], f), ca.mtimes(rotations[link.body, index], n)
            else:
                n += ca.cross(ca.DM(step.axis) * step.sign * (q[step.qpos] - step.reference), f)
        first, at = carrier[link.parent]
        f, n = ca.mtimes(ca.DM(at.rotation), f), ca.mtimes(ca.DM(at.rotation), n)
        force[first] += f
        moment[first] += n + ca.cross(ca.DM(at.position), f)
    result.root_force, result.root_moment = force[root], moment[root]
    return result


def at_rest(model: Any, rotation: Any = None, position: Any = None, gravity: Any = None) -> BodyMotion:
    """Motion of a root that does not move, gravity included: the model's unless given, as its pose is the identity."""
    R = ca.DM.eye(3) if rotation is None else ca.DM(rotation)
    p = ca.DM.zeros(3) if position is None else ca.DM(position)
    zero, pull = ca.DM.zeros(3), ca.DM(model.opt.gravity) if gravity is None else gravity
    return BodyMotion(R, p, zero, zero, zero, -ca.mtimes(R.T, pull))
