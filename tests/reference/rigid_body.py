"""Kinematics and dynamics of one instant, asked of MuJoCo: what the reference tick is written in."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from gaitsmith.robots import Leg, Robot

Array = npt.NDArray[np.float64]


@dataclass
class Point:
    """A frame fixed to a body: where it is (world), how the joints move it, and its acceleration at constant v."""

    position: Array  # (3,)
    rotation: Array  # (3, 3) frame to world
    jacobian: Array  # (6, nv) linear, angular
    bias: Array  # (6,) J̇ v


@dataclass
class Instant:
    """One configuration and velocity; ``heading`` turns heading-frame vectors into world vectors."""

    mass_matrix: Array
    bias: Array
    hip: Point
    soles: tuple[Point, Point]
    com: Point
    v: Array
    heading: Array

    def in_heading(self, vector: Array) -> Array:
        """A world vector's heading-frame components."""
        return self.heading.T @ vector

    @property
    def com_velocity(self) -> Array:
        """(3,) heading frame."""
        return self.in_heading(self.com.jacobian[:3] @ self.v)

    @property
    def tilt(self) -> tuple[float, float]:
        """Roll and pitch: torso = heading · Ry(pitch) · Rx(roll)."""
        torso = self.heading.T @ self.hip.rotation
        return float(np.arctan2(torso[2, 1], torso[2, 2])), float(np.arctan2(-torso[2, 0], torso[0, 0]))

    @property
    def turning(self) -> Array:
        """(3,) angular velocity of the torso, heading frame."""
        return self.in_heading(self.hip.jacobian[3:] @ self.v)

    def offset(self, leg: int) -> Array:
        """(2, 3) position and velocity of a sole relative to the hip midpoint, heading frame."""
        sole = self.soles[leg]
        rate = (sole.jacobian[:3] - self.hip.jacobian[:3]) @ self.v
        return np.array([self.in_heading(sole.position - self.hip.position), self.in_heading(rate)])

    def pitch(self, leg: int) -> float:
        """Pitch of a sole, toe down positive: the angle of its x axis below the horizontal, seen from the side."""
        x, _, z = self.in_heading(self.soles[leg].rotation[:, 0])
        return float(np.arctan2(-z, x))

    def contact_axes(self, leg: int, half_width: float) -> Array:
        """(3, 3) contact frame to world: the sole's own, levelled about its x axis if the sole is a line."""
        axes = self.soles[leg].rotation
        if half_width > 0.0:
            return axes
        across = np.cross([0.0, 0.0, 1.0], axes[:, 0])
        across /= np.linalg.norm(across)
        return np.column_stack([axes[:, 0], across, np.cross(axes[:, 0], across)])


class RigidBody:
    """MuJoCo's view of one robot, without ground."""

    def __init__(self, robot: Robot) -> None:
        self.robot, self.model, self.data = robot, robot.model, mujoco.MjData(robot.model)

    def _point(self, body: int, position: Array, rotation: Array) -> Point:
        model, data, nv = self.model, self.data, self.model.nv
        jacobian, rate = np.zeros((6, nv)), np.zeros((6, nv))
        mujoco.mj_jac(model, data, jacobian[:3], jacobian[3:], position, body)
        mujoco.mj_jacDot(model, data, rate[:3], rate[3:], position, body)
        return Point(position, rotation, jacobian, rate @ data.qvel)

    def _fixed(self, body: int, position: Array, rotation: Array) -> Point:
        """A frame given in its body's axes."""
        turn = self.data.xmat[body].reshape(3, 3)
        return self._point(body, self.data.xpos[body] + turn @ position, turn @ rotation)

    def _com(self) -> Point:
        """Mass-weighted mean of all bodies; the angular rows mean nothing."""
        parts = [(m, self._point(b, self.data.xipos[b], np.eye(3))) for b, m in enumerate(self.model.body_mass) if m]
        total = sum(m for m, _ in parts)
        return Point(
            sum(m * part.position for m, part in parts) / total,
            np.eye(3),
            sum(m * part.jacobian for m, part in parts) / total,
            sum(m * part.bias for m, part in parts) / total,
        )

    def at(self, q: Array, v: Array) -> Instant:
        """Everything at one configuration and velocity."""
        model, data, robot = self.model, self.data, self.robot
        data.qpos[:], data.qvel[:] = q, v
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        mass_matrix = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, mass_matrix)
        hip = self._fixed(robot.torso_body, robot.hip_midpoint, np.eye(3))
        yaw = np.arctan2(hip.rotation[1, 0], hip.rotation[0, 0])
        left, right = (self._fixed(leg.sole_body, leg.sole_position, leg.sole_rotation) for leg in robot.legs)
        return Instant(
            mass_matrix=mass_matrix,
            bias=data.qfrc_bias.copy(),
            hip=hip,
            soles=(left, right),
            com=self._com(),
            v=np.array(v),
            heading=np.array([[np.cos(yaw), -np.sin(yaw), 0.0], [np.sin(yaw), np.cos(yaw), 0.0], [0.0, 0.0, 1.0]]),
        )

    def leg_pose(self, leg: Leg, angles: Array) -> tuple[Array, Array, Array]:
        """Sole position, rotation and (6, n) Jacobian in the torso frame for the leg's joint angles."""
        data = self.data
        data.qpos[:], data.qvel[:] = self.model.qpos0, 0.0
        data.qpos[:7] = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
        data.qpos[7 + leg.joint_indices] = angles
        mujoco.mj_fwdPosition(self.model, data)
        sole = self._fixed(leg.sole_body, leg.sole_position, leg.sole_rotation)
        return sole.position, sole.rotation, sole.jacobian[:, 6 + leg.joint_indices]
