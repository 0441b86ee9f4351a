"""What the controller is told once a tick: one set of preallocated arrays, filled by a plant or a robot."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import IntVector, Vector, kernel

_FARTHEST = 1e5  # m from the origin
_FASTEST = 1e3  # m/s and rad/s; joints count as turning at most ten times as fast
_STRONGEST = 1e6  # m/s² and N


class Measurement(NamedTuple):
    """Sensor readings of one tick. With the estimated state the starred fields are never read.

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
    measurement = Measurement(
        *(np.zeros(size) for size in (3, 4, 6, n_joints, n_joints, 3, 3, n_soles)),
    )
    measurement.base_quaternion[0] = 1.0
    return measurement


@kernel
def _within(values: Vector, bound: float) -> bool:
    """Whether all values are numbers of at most ``bound`` in magnitude."""
    good = True
    for i in range(values.shape[0]):
        good = good and abs(values[i]) <= bound
    return good


@kernel
def _counted(good: bool, refused: IntVector, sensor: int) -> bool:
    """Count a sensor whose reading is not good; the same value again."""
    if not good:
        refused[sensor] += 1
    return good


@kernel
def is_usable(measurement: Measurement, estimated: bool, refused: IntVector) -> bool:
    """Whether everything that the tick reads is a number that a robot can produce, and the attitude a rotation.

    Args:
        measurement: of this tick.
        estimated: whether the state is estimated, so that the base and the joint velocities are not read.
        refused: (8,) counts one for each sensor whose reading is not usable, in the order of the fields.
    """
    norm = 0.0
    for i in range(4):
        norm += measurement.base_quaternion[i] ** 2
    good = _counted(0.25 < norm < 4.0, refused, BASE_QUATERNION)
    good = _counted(_within(measurement.joint_position, _FASTEST), refused, JOINT_POSITION) and good
    good = _counted(_within(measurement.sole_force, _STRONGEST), refused, SOLE_FORCE) and good
    if estimated:
        good = _counted(_within(measurement.accelerometer, _STRONGEST), refused, ACCELEROMETER) and good
        return _counted(_within(measurement.gyro, _FASTEST), refused, GYRO) and good
    good = _counted(_within(measurement.base_position, _FARTHEST), refused, BASE_POSITION) and good
    good = _counted(_within(measurement.joint_velocity, 10.0 * _FASTEST), refused, JOINT_VELOCITY) and good
    return _counted(_within(measurement.base_velocity, _FASTEST), refused, BASE_VELOCITY) and good
