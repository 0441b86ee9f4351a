"""A robot as the planner sees it: joints, soles, limits, and the mirror image that swaps its legs."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.kinematics.posture import standing_posture
from gaitsmith.robots import Leg, Robot
from gaitsmith.synthesis.motions.motion import Contact

Array = npt.NDArray[np.float64]
REST = 0.03  # m by which the hips are below their height with straight legs at rest
_SYMMETRY = 1e-7  # relative; left and right halves written with a few digits agree better
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
    """A robot with two legs of six joints and rectangular soles, symmetric about its sagittal plane.

    Attributes:
        robot: the robot as loaded.
        partner: (n,), joint that takes a joint's place in the mirror image.
        sign: (n,), by which its angle is multiplied there.
        height: hip midpoint above the soles with all joints at zero, m.
        width: lateral distance between the soles with all joints at zero, m.
        ankle_height: ankle above its sole, m.
        weight: total weight, N.
        dynamics_hash: hash of all numbers that the dynamics depend on.
    """

    robot: Robot
    partner: npt.NDArray[np.int64]
    sign: Array
    height: float
    width: float
    ankle_height: float
    weight: float
    dynamics_hash: str

    @property
    def joints(self) -> int:
        """Number of joints n."""
        return len(self.robot.joint_names)

    @property
    def model(self) -> Any:
        """The MuJoCo model of the robot alone."""
        return self.robot.model

    @property
    def dof(self) -> range:
        """Indices of the joints in `v`."""
        return range(6, 6 + self.joints)

    @property
    def qpos(self) -> range:
        """Indices of the joints in `q`."""
        return range(7, 7 + self.joints)

    def leg(self, name: str) -> Leg:
        """The leg called left or right."""
        return self.robot.legs[0 if name == "left" else 1]

    def corners(self, contact: Contact) -> Array:
        """(N, 2) corners of a sole that touch the ground in a contact, sole frame, m."""
        sole = self.robot.legs[0].sole
        ends = {"heel": (-sole.heel,), "toe": (sole.toe,), "flat": (-sole.heel, sole.toe), "air": ()}[contact]
        return np.array([(x, y) for x in ends for y in (-sole.half_width, sole.half_width)]).reshape(-1, 2)

    def mirrored(self, values: Array) -> Array:
        """Joint angles, velocities, accelerations or torques (..., n) of the mirror image."""
        return np.asarray(values[..., self.partner] * self.sign)


def _mirror(robot: Robot) -> tuple[npt.NDArray[np.int64], Array]:
    """Partner and sign of every joint under y -> -y."""
    names = robot.joint_names
    partner = np.arange(len(names))
    left, right = robot.legs
    for one, two in zip(left.joint_indices, right.joint_indices, strict=True):
        partner[one], partner[two] = two, one
    for index, name in enumerate(names):
        if partner[index] == index:
            for a, b in (("left", "right"), ("right", "left"), ("Left", "Right"), ("Right", "Left")):
                if a in name and name.replace(a, b, 1) in names:
                    partner[index] = names.index(name.replace(a, b, 1))
                    break
    data = mujoco.MjData(robot.model)
    mujoco.mj_kinematics(robot.model, data)
    axes = data.xaxis[1:]
    reflected = axes[partner] * np.array([-1.0, 1.0, -1.0])
    sign = np.sum(axes * reflected, axis=1)
    if np.abs(np.abs(sign) - 1.0).max() > 1e-6:
        worst = int(np.argmax(np.abs(np.abs(sign) - 1.0)))
        raise BadInput("robot", names[worst], "a robot whose left joints are the mirror image of its right ones")
    return partner, np.sign(sign)


def _check_symmetry(robot: Robot, partner: npt.NDArray[np.int64], sign: Array) -> None:
    """Inverse dynamics of mirrored motions must be mirrored forces."""
    model = robot.model
    data = mujoco.MjData(model)
    rng = np.random.default_rng(0)
    n = len(robot.joint_names)
    q, v, a = rng.uniform(-0.3, 0.3, n), rng.normal(size=n), rng.normal(size=n)
    forces = []
    flags = int(model.opt.disableflags)
    for image in (False, True):
        data.qpos[:7] = (0, 0, 1, 1, 0, 0, 0)
        data.qvel[:6], data.qacc[:6] = 0.0, 0.0
        data.qpos[7:] = q[partner] * sign if image else q
        data.qvel[6:] = v[partner] * sign if image else v
        data.qacc[6:] = a[partner] * sign if image else a
        model.opt.disableflags = flags | int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
        try:
            mujoco.mj_inverse(model, data)
        finally:
            model.opt.disableflags = flags
        forces.append(data.qfrc_inverse.copy())
    plain, image_forces = forces
    base = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    expected = np.concatenate([plain[:6] * base, plain[6:][partner] * sign])
    error = np.abs(image_forces - expected).max() / np.abs(plain).max()
    if error > _SYMMETRY:
        raise BadInput(
            "robot", robot.card.name, "a robot that is its own mirror image", f"forces differ by {error:.1e}"
        )


def biped_from(robot: Robot) -> Biped:
    """The planner's view of a robot.

    Raises:
        BadInput: legs of other than six joints, soles that are no rectangles, or a robot that is not symmetric.
    """
    for leg in robot.legs:
        if len(leg.joints) != 6 or leg.sole.kind != "rectangle":
            given = f"{len(leg.joints)} joints, {leg.sole.kind} sole"
            raise BadInput("robot", given, "legs with six joints and rectangular soles", "gaitsmith walk takes others")
    if robot.legs[0].sole != robot.legs[1].sole:
        raise BadInput("robot", "different soles", "two equal soles")
    partner, sign = _mirror(robot)
    _check_symmetry(robot, partner, sign)
    data = mujoco.MjData(robot.model)
    mujoco.mj_kinematics(robot.model, data)
    soles = [data.site(leg.sole_site).xpos for leg in robot.legs]
    torso = robot.torso_body
    hip = data.xpos[torso] + data.xmat[torso].reshape(3, 3) @ robot.hip_midpoint
    ankle = data.xanchor[robot.legs[0].ankle_pitch + 1]
    digest = hashlib.sha256()
    for name in _PHYSICS:
        digest.update(np.ascontiguousarray(getattr(robot.model, name)).tobytes())
    digest.update(np.array(robot.model.opt.gravity).tobytes())
    digest.update(",".join(leg.sole_site for leg in robot.legs).encode())
    return Biped(
        robot=robot,
        partner=partner,
        sign=sign,
        height=float(hip[2] - soles[0][2]),
        width=float(soles[0][1] - soles[1][1]),
        ankle_height=float(ankle[2] - soles[0][2]),
        weight=float(robot.mass * np.linalg.norm(robot.model.opt.gravity)),
        dynamics_hash=digest.hexdigest(),
    )


def standing(biped: Biped, height: float | None = None) -> Array:
    """q0 (n,) of eqs. (21) and (24): soles side by side, torso upright, centre of mass over the soles' middle.

    Args:
        biped: the robot.
        height: hip midpoint above the soles, m; 3 cm below straight legs if None.

    Raises:
        BadInput: the legs do not reach.
    """
    height = biped.height - REST if height is None else height
    sole = biped.robot.legs[0].sole
    return standing_posture(biped.robot, height, biped.width / 2.0, (sole.toe - sole.heel) / 2.0)[7:]
