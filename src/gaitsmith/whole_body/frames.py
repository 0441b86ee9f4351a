"""Soles, hip midpoint and heading at one instant: what all tasks of the tick are written in."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import Cube, Matrix, Vector, kernel
from gaitsmith.dynamics.points import point_bias, point_jacobian
from gaitsmith.dynamics.rotation import heading_to_world, world_to_heading
from gaitsmith.dynamics.tree import Tree, TreeState, make_tree_state
from gaitsmith.whole_body.legs import Legs


class Frames(NamedTuple):
    """Kinematics of one tick; n soles. *Heading* is the world turned by the torso's yaw.

    Attributes:
        yaw: (1,) of the torso, rad.
        cos_yaw: (1,).
        sin_yaw: (1,).
        yaw_rate: (1,) rad/s.
        tilt: (2,) torso roll and pitch, rad.
        tilt_rate: (2,) about the heading axes, rad/s.
        torso_spin: (3,) angular velocity of the torso, world axes, rad/s.
        hip_position: (3,) world, m.
        hip_velocity: (3,) world, m/s.
        hip_jacobian: (6, nv) spatial.
        hip_bias: (6,).
        sole_position: (n, 3) world, m.
        sole_rotation: (n, 3, 3) sole to world.
        sole_twist: (n, 6) velocity and angular velocity, world axes.
        sole_jacobian: (n, 6, nv) spatial.
        sole_bias: (n, 6).
        sole_pitch: (n,) against the horizontal, heading frame, toe down positive, rad.
        sole_yaw: (n,) against the heading, rad.
        relative_position: (n, 3) sole relative to the hip midpoint, heading frame, m.
        relative_velocity: (n, 3) m/s.
        com_velocity: (3,) heading frame, m/s.
        com_offset: (2,) CoM relative to the hip midpoint, heading frame, m.
    """

    yaw: Vector
    cos_yaw: Vector
    sin_yaw: Vector
    yaw_rate: Vector
    tilt: Vector
    tilt_rate: Vector
    torso_spin: Vector
    hip_position: Vector
    hip_velocity: Vector
    hip_jacobian: Matrix
    hip_bias: Vector
    sole_position: Matrix
    sole_rotation: Cube
    sole_twist: Matrix
    sole_jacobian: Cube
    sole_bias: Matrix
    sole_pitch: Vector
    sole_yaw: Vector
    relative_position: Matrix
    relative_velocity: Matrix
    com_velocity: Vector
    com_offset: Vector


def make_frames(nv: int, n_soles: int) -> Frames:
    """Storage for a robot with ``nv`` degrees of freedom and ``n_soles`` soles."""
    n = n_soles
    shapes: dict[str, tuple[int, ...]] = {
        **dict.fromkeys(Frames._fields, (n, 3)),
        **dict.fromkeys(("yaw", "cos_yaw", "sin_yaw", "yaw_rate"), (1,)),
        **dict.fromkeys(("tilt", "tilt_rate", "com_offset"), (2,)),
        **dict.fromkeys(("torso_spin", "hip_position", "hip_velocity", "com_velocity"), (3,)),
        **dict.fromkeys(("sole_pitch", "sole_yaw"), (n,)),
        "hip_jacobian": (6, nv),
        "hip_bias": (6,),
        "sole_rotation": (n, 3, 3),
        "sole_twist": (n, 6),
        "sole_jacobian": (n, 6, nv),
        "sole_bias": (n, 6),
    }
    return Frames(**{name: np.zeros(shape) for name, shape in shapes.items()})


class Body(NamedTuple):
    """The robot as one tick sees it; groups of kernels share it.

    Attributes:
        tree: constants of the robot.
        state: of the tree.
        legs: rows of the robot's legs.
        frames: of this tick.
        q: (7 + nj,) true or estimated configuration.
        v: (6 + nj,) true or estimated velocity.
    """

    tree: Tree
    state: TreeState
    legs: Legs
    frames: Frames
    q: Vector
    v: Vector


def make_body(tree: Tree, legs: Legs) -> Body:
    """A robot of which nothing has been seen yet."""
    nv = len(tree.dof_body)
    return Body(tree, make_tree_state(tree), legs, make_frames(nv, len(legs.side)), np.zeros(nv + 1), np.zeros(nv))


@kernel
def to_heading(frames: Frames, x: float, y: float, out: Vector) -> None:
    """A horizontal world vector in the heading frame, into the first two entries of ``out``."""
    out[0], out[1] = world_to_heading(frames.cos_yaw[0], frames.sin_yaw[0], x, y)


@kernel
def to_world(frames: Frames, x: float, y: float, out: Vector) -> None:
    """A horizontal vector of the heading frame in the world, into the first two entries of ``out``."""
    out[0], out[1] = heading_to_world(frames.cos_yaw[0], frames.sin_yaw[0], x, y)


@kernel
def _attach(rotation: Matrix, position: Vector, local: Vector, out: Vector) -> None:
    """World position of a point given in a body's frame."""
    for i in range(3):
        out[i] = position[i] + rotation[i, 0] * local[0] + rotation[i, 1] * local[1] + rotation[i, 2] * local[2]


@kernel
def _observe_torso(body: Body) -> None:
    """Heading, tilt and hip midpoint."""
    tree, state, legs, v, frames = body.tree, body.state, body.legs, body.v, body.frames
    torso = state.body_rotation[legs.torso[0]]
    yaw = math.atan2(torso[1, 0], torso[0, 0])
    frames.yaw[0], frames.cos_yaw[0], frames.sin_yaw[0] = yaw, math.cos(yaw), math.sin(yaw)
    frames.tilt[0] = math.atan2(torso[2, 1], torso[2, 2])
    frames.tilt[1] = math.atan2(-torso[2, 0], math.sqrt(torso[2, 1] ** 2 + torso[2, 2] ** 2))
    _attach(torso, state.body_position[legs.torso[0]], legs.hip_midpoint, frames.hip_position)
    point_jacobian(tree, state, legs.torso[0], frames.hip_position, frames.hip_jacobian)
    point_bias(tree, state, legs.torso[0], frames.hip_position, frames.hip_bias)
    for i in range(3):
        speed = spin = 0.0
        for k in range(v.shape[0]):
            speed += frames.hip_jacobian[i, k] * v[k]
            spin += frames.hip_jacobian[3 + i, k] * v[k]
        frames.hip_velocity[i], frames.torso_spin[i] = speed, spin
    to_heading(frames, frames.torso_spin[0], frames.torso_spin[1], frames.tilt_rate)
    frames.yaw_rate[0] = frames.torso_spin[2]


@kernel
def _observe_sole(g: Body, leg: int) -> None:
    """Pose, motion and Jacobian of one sole."""
    tree, state, legs, v, frames = g.tree, g.state, g.legs, g.v, g.frames
    body = legs.sole_body[leg]
    rotation, place = frames.sole_rotation[leg], frames.sole_position[leg]
    for i in range(3):
        for j in range(3):
            rotation[i, j] = 0.0
            for k in range(3):
                rotation[i, j] += state.body_rotation[body, i, k] * legs.sole_rotation[leg, k, j]
    _attach(state.body_rotation[body], state.body_position[body], legs.sole_position[leg], place)
    jacobian, twist = frames.sole_jacobian[leg], frames.sole_twist[leg]
    point_jacobian(tree, state, body, place, jacobian)
    point_bias(tree, state, body, place, frames.sole_bias[leg])
    for i in range(6):
        twist[i] = 0.0
        for k in range(v.shape[0]):
            twist[i] += jacobian[i, k] * v[k]
    ahead, aside = world_to_heading(frames.cos_yaw[0], frames.sin_yaw[0], rotation[0, 0], rotation[1, 0])
    frames.sole_pitch[leg] = math.atan2(-rotation[2, 0], ahead)
    frames.sole_yaw[leg] = math.atan2(aside, ahead)
    hip, speed = frames.hip_position, frames.hip_velocity
    position, velocity = frames.relative_position[leg], frames.relative_velocity[leg]
    to_heading(frames, place[0] - hip[0], place[1] - hip[1], position)
    to_heading(frames, twist[0] - speed[0], twist[1] - speed[1], velocity)
    position[2], velocity[2] = place[2] - hip[2], twist[2] - speed[2]


@kernel
def observe_frames(body: Body) -> None:
    """Fill the frames from an updated tree state and the velocity."""
    state, frames = body.state, body.frames
    _observe_torso(body)
    for leg in range(body.legs.sole_body.shape[0]):
        _observe_sole(body, leg)
    to_heading(frames, state.com_velocity[0], state.com_velocity[1], frames.com_velocity)
    frames.com_velocity[2] = state.com_velocity[2]
    hip = frames.hip_position
    to_heading(frames, state.com[0] - hip[0], state.com[1] - hip[1], frames.com_offset)
