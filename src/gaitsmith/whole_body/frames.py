"""Soles, hip midpoint and heading at one instant: what all tasks of the tick are written in."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gaitsmith.compiled import Cube, IntMatrix, IntVector, Matrix, Vector, kernel
from gaitsmith.dynamics.algorithms import update_dynamics
from gaitsmith.dynamics.points import point_bias, point_jacobian
from gaitsmith.dynamics.tree import Tree, TreeState, make_tree_state

if TYPE_CHECKING:
    from gaitsmith.robots import Robot


class Legs(NamedTuple):
    """Constants of both legs (row 0 left, row 1 right) and of the torso.

    Attributes:
        torso: (1,) body id.
        hip_midpoint: (3,) torso frame, m.
        sole_body: (2,) body ids.
        sole_position: (2, 3) sole frame's origin in its body, m.
        sole_rotation: (2, 3, 3) sole frame to body.
        joints: (2, n_leg) joint indices, hip to ankle.
        knee: (2,) joint indices.
        ankle_pitch: (2,) joint indices.
        ankle_sign: (2,) +1 if a positive ankle torque presses the toe down.
        heel: (2,) m, behind the sole frame's origin.
        toe: (2,) m, ahead of it.
        half_width: (2,) m; 0 for a line sole.
        leg_of_joint: (nj,) 0 left, 1 right, -1 neither.
    """

    torso: IntVector
    hip_midpoint: Vector
    sole_body: IntVector
    sole_position: Matrix
    sole_rotation: Cube
    joints: IntMatrix
    knee: IntVector
    ankle_pitch: IntVector
    ankle_sign: Vector
    heel: Vector
    toe: Vector
    half_width: Vector
    leg_of_joint: IntVector


class Frames(NamedTuple):
    """Kinematics of one tick.

    Attributes:
        heading: (4,) yaw (rad), cos yaw, sin yaw, yaw rate (rad/s).
        tilt: (4,) torso roll, pitch (rad), roll rate, pitch rate (rad/s), about the heading axes.
        hip_position: (3,) world.
        hip_jacobian: (6, nv), spatial.
        hip_bias: (6,).
        sole_position: (2, 3) world.
        sole_rotation: (2, 3, 3) sole to world.
        sole_jacobian: (2, 6, nv), spatial.
        sole_bias: (2, 6).
        relative: (2, 2, 3) per leg position and velocity of the sole, hip midpoint, heading frame.
        sole_pitch: (2,) pitch of the sole against the horizontal, heading frame, toe down positive, rad.
        contact_rotation: (2, 3, 3) contact frame to world: x along the sole; a line sole does not fix the roll.
        com_velocity: (3,) heading frame, m/s.
        point: (3,) scratch.
    """

    heading: Vector
    tilt: Vector
    hip_position: Vector
    hip_jacobian: Matrix
    hip_bias: Vector
    sole_position: Matrix
    sole_rotation: Cube
    sole_jacobian: Cube
    sole_bias: Matrix
    relative: Cube
    sole_pitch: Vector
    contact_rotation: Cube
    com_velocity: Vector
    point: Vector


def make_legs(robot: Robot, tree: Tree) -> Legs:
    """Kernel form of a robot's legs."""
    legs = robot.legs
    state = make_tree_state(tree)
    jacobian = np.zeros((6, robot.model.nv))
    update_dynamics(tree, state, np.array(robot.model.qpos0), np.zeros(robot.model.nv))
    leg_of_joint = np.full(len(robot.joint_names), -1, dtype=np.int64)
    signs = []
    for row, leg in enumerate(legs):
        leg_of_joint[leg.joint_indices] = row
        point_jacobian(tree, state, leg.sole_body, np.zeros(3), jacobian)
        signs.append(math.copysign(1.0, jacobian[4, 6 + leg.ankle_pitch]))
    return Legs(
        torso=np.array([robot.torso_body]),
        hip_midpoint=np.asarray(robot.hip_midpoint),
        sole_body=np.array([leg.sole_body for leg in legs]),
        sole_position=np.array([leg.sole_position for leg in legs]),
        sole_rotation=np.array([leg.sole_rotation for leg in legs]),
        joints=np.array([leg.joint_indices for leg in legs]),
        knee=np.array([leg.knee for leg in legs]),
        ankle_pitch=np.array([leg.ankle_pitch for leg in legs]),
        ankle_sign=np.array(signs),
        heel=np.array([leg.sole.heel for leg in legs]),
        toe=np.array([leg.sole.toe for leg in legs]),
        half_width=np.array([leg.sole.half_width for leg in legs]),
        leg_of_joint=leg_of_joint,
    )


def make_frames(nv: int) -> Frames:
    """Storage for a robot with ``nv`` degrees of freedom."""
    return Frames(
        heading=np.zeros(4),
        tilt=np.zeros(4),
        hip_position=np.zeros(3),
        hip_jacobian=np.zeros((6, nv)),
        hip_bias=np.zeros(6),
        sole_position=np.zeros((2, 3)),
        sole_rotation=np.zeros((2, 3, 3)),
        sole_jacobian=np.zeros((2, 6, nv)),
        sole_bias=np.zeros((2, 6)),
        relative=np.zeros((2, 2, 3)),
        sole_pitch=np.zeros(2),
        contact_rotation=np.zeros((2, 3, 3)),
        com_velocity=np.zeros(3),
        point=np.zeros(3),
    )


@kernel
def _attach(rotation: Matrix, position: Vector, local: Vector, out: Vector) -> None:
    """World position of a point given in a body's frame."""
    for i in range(3):
        out[i] = position[i] + rotation[i, 0] * local[0] + rotation[i, 1] * local[1] + rotation[i, 2] * local[2]


@kernel
def _contact_frame(sole: Matrix, half_width: float, out: Matrix) -> None:
    """Axes that the contact constraints are written in; a line sole is levelled about its own axis."""
    for i in range(3):
        for j in range(3):
            out[i, j] = sole[i, j]
    if half_width > 0.0:
        return
    length = math.sqrt(sole[0, 0] ** 2 + sole[1, 0] ** 2)
    if length < 1e-6:
        return
    out[0, 1] = -sole[1, 0] / length
    out[1, 1] = sole[0, 0] / length
    out[2, 1] = 0.0
    out[0, 2] = out[1, 0] * out[2, 1] - out[2, 0] * out[1, 1]
    out[1, 2] = out[2, 0] * out[0, 1] - out[0, 0] * out[2, 1]
    out[2, 2] = out[0, 0] * out[1, 1] - out[1, 0] * out[0, 1]


@kernel
def observe_frames(tree: Tree, state: TreeState, legs: Legs, v: Vector, frames: Frames) -> None:
    """Fill ``frames`` from an updated tree state and the generalised velocity ``v``."""
    nv = v.shape[0]
    torso = state.body_rotation[legs.torso[0]]
    yaw = math.atan2(torso[1, 0], torso[0, 0])
    cos_yaw, sin_yaw = math.cos(yaw), math.sin(yaw)
    frames.heading[0], frames.heading[1], frames.heading[2] = yaw, cos_yaw, sin_yaw
    frames.tilt[0] = math.atan2(torso[2, 1], torso[2, 2])
    frames.tilt[1] = math.atan2(-torso[2, 0], math.sqrt(torso[2, 1] ** 2 + torso[2, 2] ** 2))

    _attach(torso, state.body_position[legs.torso[0]], legs.hip_midpoint, frames.hip_position)
    point_jacobian(tree, state, legs.torso[0], frames.hip_position, frames.hip_jacobian)
    point_bias(tree, state, legs.torso[0], frames.hip_position, frames.hip_bias)
    rate_x = rate_y = rate_z = 0.0
    for k in range(nv):
        rate_x += frames.hip_jacobian[3, k] * v[k]
        rate_y += frames.hip_jacobian[4, k] * v[k]
        rate_z += frames.hip_jacobian[5, k] * v[k]
    frames.tilt[2] = cos_yaw * rate_x + sin_yaw * rate_y
    frames.tilt[3] = cos_yaw * rate_y - sin_yaw * rate_x
    frames.heading[3] = rate_z

    for leg in range(2):
        body = legs.sole_body[leg]
        rotation = frames.sole_rotation[leg]
        for i in range(3):
            for j in range(3):
                rotation[i, j] = 0.0
                for k in range(3):
                    rotation[i, j] += state.body_rotation[body, i, k] * legs.sole_rotation[leg, k, j]
        place = frames.sole_position[leg]
        _attach(state.body_rotation[body], state.body_position[body], legs.sole_position[leg], place)
        jacobian = frames.sole_jacobian[leg]
        point_jacobian(tree, state, body, place, jacobian)
        point_bias(tree, state, body, place, frames.sole_bias[leg])
        _contact_frame(rotation, legs.half_width[leg], frames.contact_rotation[leg])
        forward = cos_yaw * rotation[0, 0] + sin_yaw * rotation[1, 0]
        frames.sole_pitch[leg] = math.atan2(-rotation[2, 0], forward)
        for i in range(3):
            frames.point[i] = 0.0
            for k in range(nv):
                frames.point[i] += (jacobian[i, k] - frames.hip_jacobian[i, k]) * v[k]
        relative = frames.relative[leg]
        dx, dy = place[0] - frames.hip_position[0], place[1] - frames.hip_position[1]
        relative[0, 0] = cos_yaw * dx + sin_yaw * dy
        relative[0, 1] = cos_yaw * dy - sin_yaw * dx
        relative[0, 2] = place[2] - frames.hip_position[2]
        relative[1, 0] = cos_yaw * frames.point[0] + sin_yaw * frames.point[1]
        relative[1, 1] = cos_yaw * frames.point[1] - sin_yaw * frames.point[0]
        relative[1, 2] = frames.point[2]
    frames.com_velocity[0] = cos_yaw * state.com_velocity[0] + sin_yaw * state.com_velocity[1]
    frames.com_velocity[1] = cos_yaw * state.com_velocity[1] - sin_yaw * state.com_velocity[0]
    frames.com_velocity[2] = state.com_velocity[2]
