"""What the controller is told once a tick: one set of preallocated arrays, filled by a plant or a robot."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import Vector

FARTHEST = 1e5  # m from the origin; farther is no usable reading
FASTEST = 1e3  # m/s and rad/s; joints count as turning at most ten times as fast
STRONGEST = 1e6  # m/s² and N


class Measurement(NamedTuple):
    """Sensor readings of one tick, views of one array. With the estimated state the starred fields are never read.

    Attributes:
        base_position: (3,)* torso origin, world, m.
        base_quaternion: (4,) torso to world, w x y z.
        base_velocity: (6,)* linear (world axes, m/s), angular (torso axes, rad/s).
        joint_position: (nj,) rad, in the order of ``v[6:]``.
        joint_velocity: (nj,)* rad/s.
        accelerometer: (3,) specific force at the IMU, in its axes, m/s².
        gyro: (3,) angular velocity, axes of the IMU, rad/s.
        sole_force: (n,) normal force on every sole, N.
    """

    base_position: Vector
    base_quaternion: Vector
    base_velocity: Vector
    joint_position: Vector
    joint_velocity: Vector
    accelerometer: Vector
    gyro: Vector
    sole_force: Vector


(
    BASE_POSITION,
    BASE_QUATERNION,
    BASE_VELOCITY,
    JOINT_POSITION,
    JOINT_VELOCITY,
    ACCELEROMETER,
    GYRO,
    SOLE_FORCE,
) = range(len(Measurement._fields))


def make_measurement(n_joints: int, n_soles: int = 2) -> Measurement:
    """Measurement of a robot at the origin with all joints at zero."""
    sizes = (3, 4, 6, n_joints, n_joints, 3, 3, n_soles)
    measurement = Measurement(*np.split(np.zeros(sum(sizes)), np.cumsum(sizes)[:-1]))
    measurement.base_quaternion[0] = 1.0
    return measurement


def all_of(measurement: Measurement) -> Vector:
    """(N,) the array that all fields of a measurement from :func:`make_measurement` are views of."""
    array = measurement.base_position.base
    if array is None or len(array) != sum(map(len, measurement)):
        raise TypeError("a measurement that make_measurement has made")
    return array
