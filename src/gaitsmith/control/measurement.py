"""What the controller is told once a tick: one set of preallocated arrays, filled by a plant or a robot."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import Vector


class Measurement(NamedTuple):
    """Sensor readings of one tick. With the estimated state the starred fields are never read.

    Attributes:
        base_position: (3,)* torso origin, world, m.
        base_quaternion: (4,) torso to world, w x y z.
        base_velocity: (6,)* linear (world axes, m/s), angular (torso axes, rad/s).
        joint_position: (nj,) rad, in the order of ``v[6:]``.
        joint_velocity: (nj,)* rad/s.
        accelerometer: (3,) specific force at the IMU, torso axes, m/s².
        gyro: (3,) angular velocity, torso axes, rad/s.
        sole_force: (2,) normal force on the left and the right sole, N.
    """

    base_position: Vector
    base_quaternion: Vector
    base_velocity: Vector
    joint_position: Vector
    joint_velocity: Vector
    accelerometer: Vector
    gyro: Vector
    sole_force: Vector


def make_measurement(n_joints: int) -> Measurement:
    """Measurement of a robot at the origin with all joints at zero."""
    measurement = Measurement(
        *(np.zeros(size) for size in (3, 4, 6, n_joints, n_joints, 3, 3, 2)),
    )
    measurement.base_quaternion[0] = 1.0
    return measurement
