"""Kinematics and the equations of motion (15) as Taylor models, body by body from the support sole that stands still.

With R, p the pose of a body, V = [ω]R and H = ([α] + [ω]²)R, a point x of the body is at p + Rx, moves with v + Vx and
accelerates with a + Hx. With its second moments J about its centre of mass, its rate of angular momentum is the axial
vector of H J Rᵀ. Masses, inertias and axes are the model's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.robots import Robot
from gaitsmith.synthesis.proof.taylor import Taylor, cross, matmul, sine_cosine, stacked

Array = npt.NDArray[np.float64]
_HINGE = int(mujoco.mjtJoint.mjJNT_HINGE)


@dataclass(frozen=True, eq=False)
class BodyMotion:
    """One body's pose, velocity and acceleration over all stretches.

    Attributes:
        rotation: R (3, 3).
        place, speed, pull: p, v and a of its origin (3,).
        turning, bending: V and H (3, 3).
        omega, alpha: ω and α (3,).
    """

    rotation: Taylor
    place: Taylor
    speed: Taylor
    pull: Taylor
    omega: Taylor
    alpha: Taylor

    @cached_property
    def turning(self) -> Taylor:
        """V."""
        return _turned(self.omega, self.rotation)

    @cached_property
    def bending(self) -> Taylor:
        """H."""
        return _turned(self.alpha, self.rotation) + _turned(self.omega, self.turning)

    def point(self, x: Array) -> tuple[Taylor, Taylor, Taylor]:
        """Place, velocity and acceleration of a point of the body."""
        return self.place + self.rotation.by(x), self.speed + self.turning.by(x), self.pull + self.bending.by(x)


def _turned(omega: Taylor, matrix: Taylor) -> Taylor:
    """[ω] times a matrix."""
    return cross(omega[:, None], matrix)


def _matrix(quaternion: Array) -> Array:
    found = np.zeros(9)
    mujoco.mju_quat2Mat(found, quaternion)
    return found.reshape(3, 3)


def _skew(axis: Array) -> Array:
    x, y, z = axis
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


class EnclosedRobot:
    """A robot's equations over stretches of time.

    Args:
        robot: the robot.
        slope: by which the ground rises along x, rad; z is its normal.

    Raises:
        BadInput: joints that slide, several joints on one body, or forces that the equations do not know.
    """

    def __init__(self, robot: Robot, slope: float = 0.0) -> None:
        self.robot, self.model = robot, robot.model
        model = self.model
        x, y, z = model.opt.gravity
        s, c = np.sin(slope), np.cos(slope)
        self.gravity = np.array([c * x + s * z, y, c * z - s * x])
        self.joint_of = {int(model.jnt_bodyid[k]): k for k in range(1, model.njnt)}  # joint 0 is the torso's free one
        hinges = all(int(kind) == _HINGE for kind in model.jnt_type[1:]) and len(self.joint_of) == model.njnt - 1
        calm = not (model.opt.density or model.opt.viscosity or model.body_gravcomp.any() or model.opt.wind.any())
        springs = np.array_equal(np.diff(model.jnt_dofadr[1:]), np.ones(model.njnt - 2))
        if not (hinges and calm and springs):
            raise BadInput(
                "--rigorous", robot.card.name, "a robot of hinges, one a body, in still air without buoyancy"
            )
        self.parent = {b: int(model.body_parentid[b]) for b in range(2, model.nbody)}
        self.sites = {leg.name: model.site(leg.sole_site).id for leg in robot.legs}
        # The model's rotations are rounded: a last-place error of a fixed rotation is part of the robot, not of time.
        self.offset = {b: _matrix(model.body_quat[b]) for b in range(model.nbody)}

    def motions(
        self,
        support: str,
        foothold: tuple[float, ...],
        q: Taylor,
        v: Taylor,
        a: Taylor,
        pose: Sequence[Taylor] | None = None,
    ) -> dict[int, BodyMotion]:
        """Motion of every body with a sole at ``foothold``, flat, its axes along the world's, standing still.

        Args:
            support: left or right.
            foothold: (x, y) of the sole frame, m, and its height if it is not 0.
            q, v, a: (n, N) joint angles, velocities and accelerations.
            pose: (6, N) each: the sole's x, y, z, yaw, pitch and roll from there, and two derivatives; None: still.
        """
        model, count = self.model, q.shape[-1]
        sine, cosine = sine_cosine(q)
        site = self.sites[support]
        root = int(model.site_bodyid[site])
        turn = _matrix(model.site_quat[site]).T
        place = np.array([*foothold, 0.0][:3]) - turn @ model.site_pos[site]
        still = Taylor.constant(np.zeros(3), count)
        found = {
            root: BodyMotion(Taylor.constant(turn, count), Taylor.constant(place, count), still, still, still, still)
        }
        if pose is not None:
            found[root] = _moving(turn, np.array([*foothold, 0.0][:3]), np.array(model.site_pos[site]), pose)
        todo = [root]
        while todo:
            body = todo.pop()
            for other in self._neighbours(body):
                if other not in found:
                    down = self.parent.get(other) == body
                    found[other] = self._next(found[body], other if down else body, down, sine, cosine, v, a)
                    todo.append(other)
        return found

    def _neighbours(self, body: int) -> list[int]:
        above = self.parent.get(body)
        return [b for b, p in self.parent.items() if p == body] + ([] if above is None else [above])

    def _next(
        self, known: BodyMotion, child: int, down: bool, sine: Taylor, cosine: Taylor, v: Taylor, a: Taylor
    ) -> BodyMotion:
        """Across the joint above ``child``: down to it, or from it up to its parent."""
        model = self.model
        joint = self.joint_of.get(child)
        offset, anchor = self.offset[child], np.zeros(3)
        omega, alpha = known.omega, known.alpha
        if joint is None:
            bent = known.rotation.by(offset if down else offset.T)
        else:
            index, axis = joint - 1, np.array(model.jnt_axis[joint])
            anchor = np.array(model.jnt_pos[joint])
            s, c, sign = sine[index], cosine[index], 1.0 if down else -1.0
            spin, outer = _skew(axis), np.outer(axis, axis)
            turn = stacked(
                [
                    stacked(
                        [c * float((np.eye(3) - outer)[i, j]) + s * (sign * spin[i, j]) + outer[i, j] for j in range(3)]
                    )
                    for i in range(3)
                ]
            )
            bent = matmul(known.rotation.by(offset), turn) if down else matmul(known.rotation, turn).by(offset.T)
            world_axis = known.rotation.by(offset @ axis if down else axis)
            rate = world_axis * v[index]
            extra = world_axis * a[index] + cross(omega, rate)
            omega, alpha = omega + rate * sign, alpha + extra * sign
        above = np.array(model.body_pos[child]) + offset @ anchor  # the anchor in the parent's frame
        here, there = (above, anchor) if down else (anchor, above)
        place, speed, pull = known.point(here)
        found = BodyMotion(bent, place, speed, pull, omega, alpha)
        moved = found.point(-there)
        return BodyMotion(bent, *moved, omega, alpha)

    def inertial(self, motions: dict[int, BodyMotion]) -> tuple[Taylor, Taylor]:
        """Force (3,) and moment about the world's origin (3,) that each body's motion takes, gravity included.

        Arrays (bodies, 3) in the model's order, the world left out.
        """
        forces, moments = [], []
        for body in range(1, self.model.nbody):
            item, mass = motions[body], float(self.model.body_mass[body])
            place, _, pull = item.point(np.array(self.model.body_ipos[body]))
            force = (pull - self.gravity[:, None]) * mass
            inertia = _matrix(self.model.body_iquat[body])
            inertia = inertia @ np.diag(self.model.body_inertia[body]) @ inertia.T
            second = 0.5 * np.trace(inertia) * np.eye(3) - inertia
            spread = matmul(item.bending.by(second), item.rotation.transposed())
            spun = stacked([spread[k, j] - spread[j, k] for j, k in ((1, 2), (2, 0), (0, 1))])
            forces.append(force)
            moments.append(spun + cross(place, force))
        return stacked(forces), stacked(moments)

    def centre(self, motions: dict[int, BodyMotion]) -> tuple[Taylor, Taylor]:
        """Centre of mass (3,) and its velocity (3,)."""
        shares = self.model.body_mass / self.model.body_mass.sum()
        found = {b: motions[b].point(np.array(self.model.body_ipos[b])) for b in range(1, self.model.nbody)}
        (place, speed, _), *others = ([item * float(shares[b]) for item in point] for b, point in found.items())
        for there, moves, _ in others:
            place, speed = place + there, speed + moves
        return place, speed

    def residual(
        self,
        motions: dict[int, BodyMotion],
        loads: tuple[Taylor, Taylor],
        wrenches: dict[str, tuple[Taylor, Taylor]],
        states: tuple[Taylor, Taylor, Taylor],
        torque: Taylor,
    ) -> Taylor:
        """(6 + n, N) what is left of (15): force and moment about the torso's origin, then every joint's torque.

        Args:
            motions: of every body.
            loads: as :meth:`inertial` gives them.
            wrenches: of every foot, force (3,) and moment about its sole frame's origin (3,).
            states: q, v, a.
            torque: (n, N) of the joints.
        """
        model, count = self.model, torque.shape[-1]
        force = {b: loads[0][b - 1] for b in range(1, model.nbody)}
        moment = {b: loads[1][b - 1] for b in range(1, model.nbody)}
        for name, (push, turn) in wrenches.items():
            body = int(model.site_bodyid[self.sites[name]])
            place, _, _ = motions[body].point(np.array(model.site_pos[self.sites[name]]))
            force[body] = force[body] - push
            moment[body] = moment[body] - turn - cross(place, push)
        for body in range(model.nbody - 1, 1, -1):  # a child's number is above its parent's
            above = self.parent[body]
            force[above], moment[above] = force[above] + force[body], moment[above] + moment[body]
        torso = motions[1].place
        rows = [*_rows(force[1]), *_rows(moment[1] - cross(torso, force[1]))]
        q, v, a = states
        found: dict[int, Taylor] = {}
        for body, joint in self.joint_of.items():
            item, dof = motions[body], int(model.jnt_dofadr[joint])
            anchor, _, _ = item.point(np.array(model.jnt_pos[joint]))
            axis = item.rotation.by(np.array(model.jnt_axis[joint]))
            turned = (axis * (moment[body] - cross(anchor, force[body]))).sum(0)
            k = joint - 1
            own = a[k] * float(model.dof_armature[dof]) + v[k] * float(model.dof_damping[dof])
            spring = (q[k] - float(model.qpos_spring[model.jnt_qposadr[joint]])) * float(model.jnt_stiffness[joint])
            found[k] = turned + own + spring - torque[k]
        assert count == torso.shape[-1]
        return stacked(rows + [found[k] for k in range(len(found))])


def _moving(turn: Array, place: Array, origin: Array, pose: Sequence[Taylor]) -> BodyMotion:
    """Motion of a root whose point ``origin`` moves from ``place``; at its pose zero its axes are ``turn``."""
    where, rate, pull = pose
    (sy, sp, sr), (cy, cp, cr) = (tuple(x[k] for k in range(3)) for x in sine_cosine(where[3:]))
    zero, one = (Taylor.constant(np.array(value), where.shape[-1]) for value in (0.0, 1.0))
    up, side = stacked([zero, zero, one]), stacked([sy * -1.0, cy, zero])
    ahead, across = stacked([cy * cp, sy * cp, sp * -1.0]), stacked([cy * sp, sy * sp, cp])
    second, third = side * cr + across * sr, across * cr - side * sr
    rotation = stacked([stacked([column[k] for column in (ahead, second, third)]) for k in range(3)]).by(turn)
    spin = up * rate[3]
    bend = up * pull[3] + side * pull[4] + ahead * pull[5] + cross(spin, side) * rate[4]
    spin = spin + side * rate[4]
    bend = bend + cross(spin, ahead) * rate[5]
    spin = spin + ahead * rate[5]
    known = BodyMotion(rotation, where[:3] + place[:, None], rate[:3], pull[:3], spin, bend)
    return BodyMotion(rotation, *known.point(-origin), spin, bend)


def _rows(vector: Taylor) -> list[Taylor]:
    return [vector[k] for k in range(3)]
