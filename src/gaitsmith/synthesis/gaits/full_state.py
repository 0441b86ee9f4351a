"""A gait's full state by MuJoCo's kinematics alone: base pose, velocity and acceleration from the foot that stands."""

from __future__ import annotations

import copy
from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from gaitsmith.robots import Robot
from gaitsmith.synthesis.motions.motion import about_vertical

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FullState:
    """The robot at one instant; MuJoCo's order and axes.

    Attributes:
        position: (nq,) base position, quaternion w x y z, joint angles.
        velocity: (nv,) base linear (world), angular (body), joints.
        acceleration: (nv,) the same.
    """

    position: Array
    velocity: Array
    acceleration: Array


class StateFinder:
    """Finds the base's motion from the joints' and from the support foot that does not move.

    Args:
        robot: the robot.
        slope: by which the ground rises along x, rad.
        level: whether the world's z is up; else it is the ground's normal, and gravity is inclined.
    """

    def __init__(self, robot: Robot, slope: float = 0.0, level: bool = False) -> None:
        self.robot, self.model, self.ground = robot, robot.model, np.eye(3)
        sine, cosine = np.sin(slope), np.cos(slope)
        tilt = np.array([[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]])  # of the ground
        if slope and level:
            self.ground = tilt
        elif slope:
            self.model = copy.copy(robot.model)
            self.model.opt.gravity[:] = tilt.T @ robot.model.opt.gravity
        self.data = mujoco.MjData(self.model)
        self._sites = {leg.name: robot.model.site(leg.sole_site).id for leg in robot.legs}
        self._jacobian = np.zeros((6, robot.model.nv))
        self._rate = np.zeros((6, robot.model.nv))

    def find(
        self,
        support: str,
        foothold: tuple[float, ...],
        q: Array,
        v: Array,
        a: Array,
        root: Array | None = None,
        heading: float = 0.0,
    ) -> FullState:
        """Full state with the support sole at ``foothold``, flat, standing still, or moving from there.

        Args:
            support: left or right.
            foothold: (x, y) of the sole frame, m, and its height if it is not 0.
            q, v, a: (n,) joint angles, velocities and accelerations.
            root: (3, 6) pose of the sole from there, in its axes: x, y, z, m, yaw, pitch and roll, turned in this
                order, rad; and two derivatives. None, or nothing but zeros: it stands still.
            heading: of the sole in the world, rad; its axes are the world's at 0.
        """
        model, data, site = self.model, self.data, self._sites[support]
        data.qpos[:7] = (0, 0, 0, 1, 0, 0, 0)
        data.qpos[7:] = q
        mujoco.mj_kinematics(model, data)
        turn = data.site_xmat[site].reshape(3, 3).T.copy()
        place, spin, bend = np.array([*foothold, 0.0][:3]), np.zeros(6), np.zeros(6)
        ahead, place = self.ground @ about_vertical(heading), self.ground @ place
        if root is not None and root.any():
            rotation, spin[3:], bend[3:] = turned(*root[:, 3:])
            turn, spin[:3], bend[:3] = rotation @ turn, root[1, :3], root[2, :3]
            place = place + ahead @ root[0, :3]
            spin, bend = ((ahead @ values.reshape(2, 3).T).T.ravel() for values in (spin, bend))
        turn = ahead @ turn
        data.qpos[:3] = place - turn @ data.site_xpos[site]
        mujoco.mju_mat2Quat(data.qpos[3:7], turn.ravel())
        data.qvel[:6] = 0.0
        data.qvel[6:] = v
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        J, moved = self._jacobian, self._rate
        mujoco.mj_jacSite(model, data, J[:3], J[3:], site)
        qvel, arm, axes = data.qvel, J[:3, 3:6], J[3:, 3:6]
        qvel[:6] = _base(arm, axes, spin - J[:, 6:] @ v)
        mujoco.mj_comVel(model, data)
        body = int(model.site_bodyid[site])
        mujoco.mj_jacDot(model, data, moved[:3], moved[3:], data.site_xpos[site], body)
        data.qacc[6:] = a
        data.qacc[:6] = _base(arm, axes, bend - J[:, 6:] @ a - moved @ qvel)
        return FullState(data.qpos.copy(), data.qvel.copy(), data.qacc.copy())

    def foot(self, side: str, point: Array) -> tuple[Array, Array, Array, Array, Array, Array]:
        """Motion of a foot in the state that :meth:`find` left; world axes.

        Returns the point, its velocity and its acceleration (3 each), then the sole's rotation (3, 3), angular velocity
        and angular acceleration (3 each).

        Args:
            side: left or right.
            point: (3,) in the sole's frame, m.
        """
        model, data, site = self.model, self.data, self._sites[side]
        body = int(model.site_bodyid[site])
        rotation = data.site_xmat[site].reshape(3, 3).copy()
        place = data.site_xpos[site] + rotation @ point
        J, rate = self._jacobian, self._rate
        mujoco.mj_jac(model, data, J[:3], J[3:], place, body)
        mujoco.mj_jacDot(model, data, rate[:3], rate[3:], place, body)
        speed = J @ data.qvel
        pull = J @ data.qacc + rate @ data.qvel
        return place, speed[:3], pull[:3], rotation, speed[3:], pull[3:]

    def body(self, number: int) -> tuple[Array, Array]:
        """A body's place (3,), m, and rotation (3, 3), world, in the state that :meth:`find` left."""
        return self.data.xpos[number].copy(), self.data.xmat[number].reshape(3, 3).copy()

    def residual(self, torque: Array, wrench: Array) -> Array:
        """(nv,) inverse dynamics minus joint torques and contact wrenches, in the state that :meth:`find` left.

        Args:
            torque: (n,) N·m.
            wrench: (12,) left force, left moment, right force, right moment, about the sole frames' origins.
        """
        model, data = self.model, self.data
        kept = data.qacc.copy()
        flags = int(model.opt.disableflags)
        model.opt.disableflags = flags | int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
        try:
            mujoco.mj_inverse(model, data)
        finally:
            model.opt.disableflags = flags
        data.qacc[:] = kept
        found = np.array(data.qfrc_inverse)
        found[6:] -= torque
        for first, side in ((0, "left"), (6, "right")):
            mujoco.mj_jacSite(model, data, self._jacobian[:3], self._jacobian[3:], self._sites[side])
            found -= self._jacobian.T @ wrench[first : first + 6]
        return found

    def centre_of_mass(self) -> Array:
        """(3,) world, m, in the state that :meth:`find` left."""
        return np.array(self.data.subtree_com[0])

    def centre_velocity(self) -> Array:
        """(3,) of the centre of mass, world, m/s, in the state that :meth:`find` left."""
        mujoco.mj_subtreeVel(self.model, self.data)
        return np.array(self.data.subtree_linvel[0])


def _base(arm: Array, axes: Array, wanted: Array) -> Array:
    """(6,) the base's motion that moves a point of the robot as ``wanted``, translation first, its joints at rest.

    Args:
        arm: (3, 3) of the point's Jacobian, its translation by the base's rotation about its own axes.
        axes: (3, 3) these axes.
        wanted: (6,) world axes.
    """
    spin = axes.T @ wanted[3:]
    return np.concatenate([wanted[:3] - arm @ spin, spin])


def turned(angle: Array, rate: Array, pull: Array) -> tuple[Array, Array, Array]:
    """Rotation (3, 3), angular velocity and acceleration (3,), world axes, of yaw, pitch and roll in this order."""
    (cy, cp, cr), (sy, sp, sr) = np.cos(angle), np.sin(angle)
    rotation = np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )
    up, side, ahead = np.array([0.0, 0.0, 1.0]), np.array([-sy, cy, 0.0]), rotation[:, 0]
    spin = up * rate[0]
    bend = up * pull[0] + side * pull[1] + ahead * pull[2] + _cross(spin, side) * rate[1]
    spin = spin + side * rate[1]
    bend = bend + _cross(spin, ahead) * rate[2]
    return rotation, spin + ahead * rate[2], bend


def _cross(one: Array, two: Array) -> Array:
    """(3,) product of vectors; NumPy's own takes ten times as long."""
    (a, b, c), (d, e, f) = one.tolist(), two.tolist()
    return np.array([b * f - c * e, c * d - a * f, a * e - b * d])
