"""A robot as the planner sees it: the joints that move, soles, and the mirror image that swaps its legs."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.robots import Leg, Robot
from gaitsmith.robots.sole import Sole
from gaitsmith.synthesis.motions.motion import Contact, Phase, Side
from gaitsmith.synthesis.motions.standing import standing_joints

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]
REST = 1.0 / 13.0  # share of the hips' height with straight legs by which they are lower at rest
_LINE_JOINTS = (4, 5, 6)  # of a leg whose sole is a line
_SYMMETRY = 1e-7  # relative; left and right halves written with a few digits agree better
_MIRROR = np.array([1.0, -1.0, 1.0])
_PHYSICS = (
    "body_parentid",
    "body_pos",
    "body_quat",
    "body_ipos",
    "body_iquat",
    "body_mass",
    "body_inertia",
    "jnt_type",
    "jnt_bodyid",
    "jnt_pos",
    "jnt_axis",
    "jnt_stiffness",
    "qpos0",
    "qpos_spring",
    "dof_armature",
    "dof_damping",
    "site_pos",
    "site_quat",
)


@dataclass(frozen=True, eq=False)
class Biped:
    """A robot with two legs of six joints and soles with an area, or with line soles; some joints may be held.

    A line sole may roll about its line, which no joint drives: its *lean* is a coordinate beside the joints' angles.

    Attributes:
        robot: the robot as loaded.
        index: (n,) the joints that move, among the robot's.
        home: (N,) angles of all its joints, of which those that do not move keep theirs; zero if all move.
        partner: (n,), joint that takes a joint's place in the mirror image.
        sign: (n,), by which its angle is multiplied there.
        asymmetry: by how much the robot differs from its mirror image: forces relative to the largest, lengths to the
            height, angles in rad; the largest of them.
        height: hip midpoint above the soles with all joints at zero, m.
        width: lateral distance between the soles in a gait, m.
        ankle_height: origin of the body that carries the sole above the sole, m.
        weight: total weight, N.
        flies: whether the support sole may leave the ground: its pose is then six coordinates more.
        tips: whether the support foot may turn about its toe's edge: its pitch is then a coordinate more.
        slopes: whether the ground may be inclined: the direction of gravity is then a parameter of a point.
        placed: whether the places of the centre of mass and the torso are among what is computed of a point.
    """

    robot: Robot
    index: Indices
    home: Array
    partner: Indices
    sign: Array
    asymmetry: float
    height: float
    width: float
    ankle_height: float
    weight: float
    flies: bool = False
    placed: bool = False
    slopes: bool = False
    tips: bool = False

    @property
    def kind(self) -> tuple[bool, bool, bool, bool]:
        """Of motions that its points are computed for: flies, placed, slopes, tips."""
        return self.flies, self.placed, self.slopes, self.tips

    def of_kind(self, flies: bool, placed: bool, slopes: bool, tips: bool) -> Biped:
        """The same for another kind of motions."""
        return replace(self, flies=flies, placed=placed, slopes=slopes, tips=tips)

    @property
    def joints(self) -> int:
        """Number of joints n that move."""
        return len(self.index)

    @property
    def lines(self) -> bool:
        """Whether the soles are lines."""
        return self.robot.legs[0].sole.kind == "line"

    @property
    def leans(self) -> int:
        """Coordinates beside the joints: of line soles the right one's lean and the left one's, positive about +x."""
        return 2 if self.lines else 0

    @property
    def channels(self) -> int:
        """Joints and leans."""
        return self.joints + self.leans

    @cached_property
    def image(self) -> tuple[Indices, Array]:
        """(c,) of every coordinate the one that takes its place in the mirror image, and its sign there."""
        if not self.leans:
            return self.partner, self.sign
        swapped = np.array([self.joints + 1, self.joints])
        return np.concatenate([self.partner, swapped]), np.concatenate([self.sign, (-1.0, -1.0)])

    @property
    def model(self) -> Any:
        """The MuJoCo model of the robot alone."""
        return self.robot.model

    @cached_property
    def held(self) -> Indices:
        """The joints that do not move, among the robot's."""
        return np.setdiff1d(np.arange(len(self.home)), self.index)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Of the joints that move."""
        return tuple(self.robot.joint_names[joint] for joint in self.index)

    @cached_property
    def whole(self) -> Biped:
        """The same robot with all joints moving: what gaits and their proofs are about."""
        return biped_from(self.robot) if len(self.held) else self

    @property
    def effort(self) -> float:
        """The robot's unit of torque: its weight on a lever as long as its legs, N·m."""
        return self.weight * self.height

    @property
    def fall_time(self) -> float:
        """The robot's unit of time: square root of leg over gravity, s."""
        return float(np.sqrt(self.height * self.robot.mass / self.weight))

    @property
    def usual_period(self) -> float | None:
        """Of a step, s: the card's where soles are lines, on which a robot falls over while it steps; else None."""
        return self.robot.card.gait.period if self.lines else None

    @property
    def symmetric(self) -> bool:
        """Whether a step may be mirrored."""
        return self.asymmetry <= _SYMMETRY

    @cached_property
    def dynamics_hash(self) -> str:
        """Hash of all numbers that the dynamics depend on."""
        digest = hashlib.sha256()
        for name in _PHYSICS:
            digest.update(np.ascontiguousarray(getattr(self.model, name)).tobytes())
        digest.update(bytes([self.flies, self.placed, self.slopes, self.tips]))
        for values in (self.model.opt.gravity, self.index, self.partner, self.sign, self.home[self.held]):
            digest.update(np.array(values).tobytes())
        digest.update(",".join(leg.sole_site for leg in self.robot.legs).encode() + bytes([self.symmetric, self.lines]))
        return digest.hexdigest()

    def leg(self, name: str) -> Leg:
        """The leg called left or right."""
        return self.robot.legs[0 if name == "left" else 1]

    def leg_joints(self, name: str) -> Indices:
        """(6,) a leg's joints among those that move."""
        return np.searchsorted(self.index, self.leg(name).joint_indices)

    def sole(self, name: str) -> Sole:
        """Shape of a leg's sole."""
        return self.leg(name).sole

    @property
    def narrowest(self) -> float:
        """Half of a sole's least width, or of the length of a line, m."""
        soles = [leg.sole for leg in self.robot.legs]
        lengths = [(sole.heel + sole.toe) / 2.0 for sole in soles]
        return min(lengths if self.lines else [*lengths, *(sole.half_width for sole in soles)])

    def corners(self, contact: Contact, foot: Side) -> Array:
        """(N, 2) corners of a sole that touch the ground in a contact, sole frame, m."""
        sole = self.sole(foot)
        if contact in ("heel", "toe"):
            x, right, left = sole.ends[0 if contact == "heel" else 1]
            return np.array([(x, right), (x, left)])
        return sole.corners if contact == "flat" else np.zeros((0, 2))

    def pivot(self, phase: Phase) -> Array:
        """(3,) point of the other sole, in its frame, about which u is taken and which closure holds in place."""
        corners = self.corners(phase.contact, phase.other_foot)
        turns = phase.contact in ("heel", "toe")
        return np.array([*corners.mean(axis=0), 0.0]) if turns else np.zeros(3)

    def mirrored(self, values: Array) -> Array:
        """Joint angles, velocities, accelerations or torques (..., n) of the mirror image; with leans too."""
        partner, sign = self.image if values.shape[-1] == self.channels else (self.partner, self.sign)
        return np.asarray(values[..., partner] * sign)


def _mirror(robot: Robot) -> tuple[Indices, Array]:
    """Partner and sign of every joint under y -> -y: legs in order from the hip, others where they lie."""
    data = mujoco.MjData(robot.model)
    mujoco.mj_kinematics(robot.model, data)
    anchors, axes = data.xanchor[1:], data.xaxis[1:]
    reflected = axes * -_MIRROR
    away = np.linalg.norm(anchors[:, None] - anchors[None] * _MIRROR, axis=2)
    apart = away / max(float(np.ptp(anchors)), 1e-9) + 1.0 - np.abs(axes @ reflected.T)
    best = np.argmin(apart, axis=1)
    partner = np.where(best[best] == np.arange(len(best)), best, np.arange(len(best)))
    left, right = robot.legs
    partner[np.isin(partner, [*left.joint_indices, *right.joint_indices])] = -1
    partner = np.where(partner < 0, np.arange(len(best)), partner)
    partner[left.joint_indices], partner[right.joint_indices] = right.joint_indices, left.joint_indices
    return partner, np.where(np.sum(axes[partner] * reflected, axis=1) < 0.0, -1.0, 1.0)


def _asymmetry(biped: Biped) -> float:
    """How far the forces of mirrored motions are from mirrored forces, and soles and posture from their images."""
    model, whole = biped.model, biped.whole
    data, rng, n = mujoco.MjData(model), np.random.default_rng(0), biped.joints
    motions = [rng.uniform(-0.3, 0.3, n), rng.normal(size=n), rng.normal(size=n)]
    forces, soles = [], []
    flags = int(model.opt.disableflags)
    dofs = 6 + biped.index
    for image in (False, True):
        q, v, a = (biped.mirrored(values) if image else values for values in motions)
        data.qpos[:7], data.qpos[7:] = (0, 0, 1, 1, 0, 0, 0), biped.home
        data.qvel[:], data.qacc[:] = 0.0, 0.0
        data.qpos[1 + dofs], data.qvel[dofs], data.qacc[dofs] = q, v, a
        model.opt.disableflags = flags | int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
        try:
            mujoco.mj_inverse(model, data)
        finally:
            model.opt.disableflags = flags
        found = data.qfrc_inverse.copy()
        forces.append(np.concatenate([found[:6], found[dofs]]))
        sites = [data.site(leg.sole_site) for leg in biped.robot.legs]
        soles.append([(site.xpos.copy(), site.xmat.reshape(3, 3).copy()) for site in sites])
    plain, image_forces = forces
    expected = np.concatenate([plain[:3] * _MIRROR, plain[3:6] * -_MIRROR, biped.mirrored(plain[6:])])
    errors = [float(np.abs(image_forces - expected).max() / np.abs(plain).max())]
    for (place, turn), (other, back) in zip(soles[0], soles[1][::-1], strict=True):
        errors.append(float(np.abs(other - place * _MIRROR).max()) / biped.height)
        errors.append(float(np.abs(back - np.outer(_MIRROR, _MIRROR) * turn).max()))
    errors.append(float(np.abs(whole.mirrored(biped.home) - biped.home)[biped.held].max(initial=0.0)))
    shapes = [
        {(round(x, 9), round(s * y, 9)) for x, y in biped.sole(n).corners} for n, s in (("left", 1), ("right", -1))
    ]
    return max(errors) if shapes[0] == shapes[1] else max(*errors, 2.0 * _SYMMETRY)


def biped_from(robot: Robot, free: Sequence[str] | None = None) -> Biped:
    """The planner's view of a robot.

    Args:
        robot: the robot.
        free: joints outside the legs that move; all of them if None. The others stay where the controller holds them.

    Raises:
        BadInput: legs or soles that cannot be planned for, or joints that are not there or in a leg.
    """
    lines = [leg.sole.kind == "line" for leg in robot.legs]
    for leg in robot.legs:
        if len(leg.joints) not in (_LINE_JOINTS if all(lines) else (6,)) or any(lines) != all(lines):
            given = f"{len(leg.joints)} joints, {leg.sole.kind} sole"
            valid = "legs with six joints and soles with an area, or with four to six and soles that are lines"
            raise BadInput("robot", given, valid, "gaitsmith walk takes others")
    legs = np.concatenate([leg.joint_indices for leg in robot.legs])
    others = [name for k, name in enumerate(robot.joint_names) if k not in legs]
    for name in free or ():
        if name not in others:
            raise BadInput("free", name, f"a joint outside the legs: {', '.join(others) or 'there is none'}")
    moving = [k for k, name in enumerate(robot.joint_names) if free is None or k in legs or name in free]
    data = mujoco.MjData(robot.model)
    mujoco.mj_kinematics(robot.model, data)
    soles = [data.site(leg.sole_site).xpos for leg in robot.legs]
    torso = robot.torso_body
    hip = data.xpos[torso] + data.xmat[torso].reshape(3, 3) @ robot.hip_midpoint
    partner, sign = _mirror(robot)
    index = np.array(moving, dtype=np.int64)
    inside = np.isin(partner, index)  # a partner that is held is none
    own = np.where(inside, partner, np.arange(len(partner)))[index]
    biped = Biped(
        robot=robot,
        index=index,
        home=np.zeros(len(robot.joint_names)),
        partner=np.searchsorted(index, own),
        sign=np.where(inside, sign, 1.0)[index],
        asymmetry=0.0,
        height=float(hip[2] - soles[0][2]),
        width=2.0 * robot.card.gait.width,
        ankle_height=float(data.xpos[robot.legs[0].sole_body][2] - soles[0][2]),
        weight=float(robot.mass * np.linalg.norm(robot.model.opt.gravity)),
    )
    if free is None:
        return biped
    biped = replace(biped, home=_standing(biped))
    return replace(biped, asymmetry=_asymmetry(biped))


def _standing(biped: Biped, height: float | None = None, slope: float = 0.0) -> Array:
    """(N,) standing posture of all joints."""
    height = biped.height * (1.0 - REST) if height is None else height
    sole = biped.robot.legs[0].sole
    return standing_joints(biped.robot, height, biped.width / 2.0, (sole.toe - sole.heel) / 2.0, slope)


def standing(biped: Biped, height: float | None = None, slope: float = 0.0) -> Array:
    """q0 (n,) of eqs. (21) and (24): soles side by side, torso upright, centre of mass over the soles' middle.

    Args:
        biped: the robot.
        height: hip midpoint above the soles, m; a thirteenth less than with straight legs if None.
        slope: by which the ground rises ahead, rad.

    Raises:
        BadInput: the legs do not reach.
    """
    return _standing(biped, height, slope)[biped.index]


def standing_leans(biped: Biped, joints: Array) -> Array:
    """(leans,) of the soles, right and left, with the torso upright, rad."""
    if not biped.lines:
        return np.zeros(0)
    data = mujoco.MjData(biped.model)
    data.qpos[7:] = biped.home
    data.qpos[7 + biped.index] = joints
    mujoco.mj_kinematics(biped.model, data)
    rotations = [data.site(biped.leg(name).sole_site).xmat.reshape(3, 3) for name in ("right", "left")]
    return np.array([np.arctan2(rotation[2, 1], rotation[2, 2]) for rotation in rotations])
