"""What the whole body is asked to do at one tick: the only input of whole-body control beside the state.

Template, standing and planned gaits are producers: each fills a :class:`Reference` and knows nothing of torques. A new
motion is a new producer.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import Cube, IntVector, Matrix, Vector, kernel

NONE = 0
"""A sole in the air: its motion is tracked, it bears nothing."""
FLAT = 1
"""The whole sole bears; for a line sole that is its line."""
HEEL = 2
"""The sole turns about its heel's edge."""
TOE = 3
"""The sole turns about its toe's edge."""

WORLD = 0
"""A sole's motion is given in the world."""
HIPS = 1
"""A sole's motion is given relative to the hip midpoint, heading axes (Han 2023, eq. 19)."""


class Reference(NamedTuple):
    """Desired motion and contacts of one tick; n soles, nj joints. World frame where not said; SI units.

    A weight of 0 switches the row off; weights multiply those of the task table.

    Attributes:
        contact: (n,) NONE, FLAT, HEEL or TOE.
        sole_frame: (n,) WORLD or HIPS: what position, velocity and acceleration of the sole are relative to.
        sole_position: (n, 3) of the sole frame's origin, m.
        sole_velocity: (n, 3) m/s.
        sole_acceleration: (n, 3) m/s².
        sole_rotation: (n, 3, 3) sole to world.
        sole_spin: (n, 3) angular velocity, world axes, rad/s.
        sole_angular_acceleration: (n, 3) world axes, rad/s².
        cop: (n, 2) desired centre of pressure of a bearing sole, sole axes, from the sole frame's origin, m.
        cop_weight: (n,) share of the table's weight.
        load: (n,) desired normal force of a bearing sole, N.
        load_weight: (n,) share of the table's weight.
        torso_rotation: (3, 3) torso to world.
        torso_spin: (3,) angular velocity, world axes, rad/s.
        torso_angular_acceleration: (3,) world axes, rad/s².
        torso_weight: (3,) shares of roll, pitch, yaw about the heading axes.
        com: (3, 3) position (m), velocity, acceleration of the centre of mass by rows.
        com_weight: (3,) shares forward, lateral, vertical, heading axes.
        hip_height: (3,) height of the hip midpoint (world z, m), its rate and acceleration.
        hip_height_weight: (1,).
        joint: (3, nj) angle, rate, acceleration by rows, rad.
        joint_weight: (nj,) shares.
        torque: (nj,) planned torque, read by joint tracking, N·m.
    """

    contact: IntVector
    sole_frame: IntVector
    sole_position: Matrix
    sole_velocity: Matrix
    sole_acceleration: Matrix
    sole_rotation: Cube
    sole_spin: Matrix
    sole_angular_acceleration: Matrix
    cop: Matrix
    cop_weight: Vector
    load: Vector
    load_weight: Vector
    torso_rotation: Matrix
    torso_spin: Vector
    torso_angular_acceleration: Vector
    torso_weight: Vector
    com: Matrix
    com_weight: Vector
    hip_height: Vector
    hip_height_weight: Vector
    joint: Matrix
    joint_weight: Vector
    torque: Vector


def make_reference(n_soles: int, n_joints: int) -> Reference:
    """Reference of a robot that stands still, before any producer has written."""
    return Reference(
        contact=np.ones(n_soles, dtype=np.int64),
        sole_frame=np.zeros(n_soles, dtype=np.int64),
        sole_position=np.zeros((n_soles, 3)),
        sole_velocity=np.zeros((n_soles, 3)),
        sole_acceleration=np.zeros((n_soles, 3)),
        sole_rotation=np.tile(np.eye(3), (n_soles, 1, 1)),
        sole_spin=np.zeros((n_soles, 3)),
        sole_angular_acceleration=np.zeros((n_soles, 3)),
        cop=np.zeros((n_soles, 2)),
        cop_weight=np.zeros(n_soles),
        load=np.zeros(n_soles),
        load_weight=np.zeros(n_soles),
        torso_rotation=np.eye(3),
        torso_spin=np.zeros(3),
        torso_angular_acceleration=np.zeros(3),
        torso_weight=np.ones(3),
        com=np.zeros((3, 3)),
        com_weight=np.zeros(3),
        hip_height=np.zeros(3),
        hip_height_weight=np.zeros(1),
        joint=np.zeros((3, n_joints)),
        joint_weight=np.zeros(n_joints),
        torque=np.zeros(n_joints),
    )


@kernel
def level_rotation(cos_yaw: float, sin_yaw: float, pitch_cos: float, pitch_sin: float, out: Matrix) -> None:
    """Rotation of a frame with heading and pitch but no roll, to the world."""
    out[0, 0], out[0, 1], out[0, 2] = cos_yaw * pitch_cos, -sin_yaw, cos_yaw * pitch_sin
    out[1, 0], out[1, 1], out[1, 2] = sin_yaw * pitch_cos, cos_yaw, sin_yaw * pitch_sin
    out[2, 0], out[2, 1], out[2, 2] = -pitch_sin, 0.0, pitch_cos
