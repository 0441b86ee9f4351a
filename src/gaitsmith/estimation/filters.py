"""The estimator's filters, each on its own: joint rates, attitude, and the motion along one world axis."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gaitsmith.compiled import IntVector, Matrix, Vector, kernel
from gaitsmith.dynamics.rotation import turn_quaternion
from gaitsmith.estimation.measurement import Measurement

if TYPE_CHECKING:
    from gaitsmith.robots.presets import EstimatorParameters

_GYRO = 0.02  # rad/s, noise of one sample
_ATTITUDE = 0.005  # rad, noise of one sample of the measured attitude
_GYRO_TIME = 0.002  # s, time constant of the angular velocity's low-pass filter
_SETTLING = 0.02  # s, a sole that has just landed is not yet at rest
_FULL_LOAD = 0.3  # share of the weight at which a sole counts fully


class EstimatorGains(NamedTuple):
    """:class:`EstimatorParameters` as a kernel reads them, and what the robot adds.

    Attributes:
        imu_position: (3,) torso frame, m.
        imu_rotation: (3, 3) IMU frame to torso frame.
        accelerometer: m/s², standard deviation of a sample.
        accelerometer_drift: m/s² per √s.
        leg_odometry: m/s.
        foot_height: m.
        joint_acceleration: rad/s².
        encoder: rad.
        gyro: rad/s, standard deviation of a sample.
        attitude: rad, standard deviation of a sample.
        gyro_time: s, low-pass filter of the angular velocity.
        settling: s, how long a landed sole is not trusted.
        contact_force: N, below which a sole does not count.
        full_force: N, above which it counts fully.
    """

    imu_position: Vector
    imu_rotation: Matrix
    accelerometer: float
    accelerometer_drift: float
    leg_odometry: float
    foot_height: float
    joint_acceleration: float
    encoder: float
    gyro: float
    attitude: float
    gyro_time: float
    settling: float
    contact_force: float
    full_force: float


class EstimatorState(NamedTuple):
    """What the filters know; the IMU's motion is in world axes.

    Attributes:
        started: (1,) 0 until the first measurement.
        joint_previous: (nj,) joint angles one tick ago, rad.
        joint_velocity: (nj,) rad/s.
        joint_variance: (1,) of a joint velocity, rad²/s².
        quaternion: (4,) torso to world, w x y z.
        attitude_variance: (1,) per axis, rad².
        gyro: (3,) reading of this tick, torso axes, rad/s.
        force: (3,) specific force of this tick, torso axes, m/s².
        angular_velocity: (3,) torso axes, rad/s.
        motion: (3, 3) one row a world axis: position (m), velocity (m/s), accelerometer bias (m/s²).
        covariance: (3, 6) one row a world axis: pp pv pb vv vb bb.
        ground: (n_legs,) height of the ground below a sole since its touchdown, m.
        contact_time: (n_legs,) since touchdown, s.
        sole: (3,) scratch.
        sole_axes: (3, 3) scratch.
        twist: (6,) scratch.
    """

    started: IntVector
    joint_previous: Vector
    joint_velocity: Vector
    joint_variance: Vector
    quaternion: Vector
    attitude_variance: Vector
    gyro: Vector
    force: Vector
    angular_velocity: Vector
    motion: Matrix
    covariance: Matrix
    ground: Vector
    contact_time: Vector
    sole: Vector
    sole_axes: Matrix
    twist: Vector


def make_estimator_state(n_joints: int, n_legs: int = 2) -> EstimatorState:
    """Filters that have seen nothing; the first measurement starts them."""
    return EstimatorState(
        started=np.zeros(1, dtype=np.int64),
        joint_previous=np.zeros(n_joints),
        joint_velocity=np.zeros(n_joints),
        joint_variance=np.zeros(1),
        quaternion=np.array([1.0, 0.0, 0.0, 0.0]),
        attitude_variance=np.zeros(1),
        gyro=np.zeros(3),
        force=np.zeros(3),
        angular_velocity=np.zeros(3),
        motion=np.zeros((3, 3)),
        covariance=np.zeros((3, 6)),
        ground=np.zeros(n_legs),
        contact_time=np.zeros(n_legs),
        sole=np.zeros(3),
        sole_axes=np.zeros((3, 3)),
        twist=np.zeros(6),
    )


def make_estimator_gains(
    parameters: EstimatorParameters,
    imu_position: Vector,
    contact_force: float,
    weight: float,
    imu_rotation: Matrix | None = None,
) -> EstimatorGains:
    """Kernel form of ``parameters``.

    Args:
        parameters: standard deviations.
        imu_position: (3,) torso frame, m.
        contact_force: sole force that counts as contact, N.
        weight: of the whole robot, N.
        imu_rotation: (3, 3) IMU frame to torso frame; as the torso's if None.
    """
    return EstimatorGains(
        imu_position=np.array(imu_position, dtype=np.float64),
        imu_rotation=np.eye(3) if imu_rotation is None else np.array(imu_rotation, dtype=np.float64),
        accelerometer=parameters.accelerometer,
        accelerometer_drift=parameters.accelerometer_drift,
        leg_odometry=parameters.leg_odometry,
        foot_height=parameters.foot_height,
        joint_acceleration=parameters.joint_acceleration,
        encoder=parameters.encoder,
        gyro=_GYRO,
        attitude=_ATTITUDE,
        gyro_time=_GYRO_TIME,
        settling=_SETTLING,
        contact_force=contact_force,
        full_force=max(_FULL_LOAD * weight, 2.0 * contact_force),
    )


@kernel
def filter_joints(gains: EstimatorGains, state: EstimatorState, angles: Vector, dt: float) -> None:
    """Differentiate the joint angles and pass each rate through a scalar Kalman filter."""
    noise = 2.0 * (gains.encoder / dt) ** 2
    predicted = state.joint_variance[0] + (gains.joint_acceleration * dt) ** 2
    gain = predicted / (predicted + noise)
    state.joint_variance[0] = (1.0 - gain) * predicted
    for j in range(angles.shape[0]):
        rate = (angles[j] - state.joint_previous[j]) / dt
        state.joint_previous[j] = angles[j]
        state.joint_velocity[j] += gain * (rate - state.joint_velocity[j])


@kernel
def turn_to_torso(gains: EstimatorGains, state: EstimatorState, measurement: Measurement) -> None:
    """The IMU's readings in torso axes, whichever way it is mounted."""
    for i in range(3):
        state.gyro[i] = state.force[i] = 0.0
        for k in range(3):
            state.gyro[i] += gains.imu_rotation[i, k] * measurement.gyro[k]
            state.force[i] += gains.imu_rotation[i, k] * measurement.accelerometer[k]


@kernel
def filter_attitude(gains: EstimatorGains, state: EstimatorState, measurement: Measurement, dt: float) -> None:
    """Turn with the gyro, then a Kalman share of the way to the measured attitude."""
    rate, q, m = state.angular_velocity, state.quaternion, measurement.base_quaternion
    turn_quaternion(q, state.gyro[0] * dt, state.gyro[1] * dt, state.gyro[2] * dt)
    predicted = state.attitude_variance[0] + (gains.gyro * dt) ** 2
    gain = predicted / (predicted + gains.attitude**2)
    state.attitude_variance[0] = (1.0 - gain) * predicted
    w = q[0] * m[0] + q[1] * m[1] + q[2] * m[2] + q[3] * m[3]
    share = 2.0 * gain / (w if abs(w) > 0.1 else math.copysign(0.1, w))
    turn_quaternion(
        q,
        share * (q[0] * m[1] - q[1] * m[0] - q[2] * m[3] + q[3] * m[2]),
        share * (q[0] * m[2] + q[1] * m[3] - q[2] * m[0] - q[3] * m[1]),
        share * (q[0] * m[3] - q[1] * m[2] + q[2] * m[1] - q[3] * m[0]),
    )
    follow = dt / (gains.gyro_time + dt)
    for i in range(3):
        rate[i] += follow * (state.gyro[i] - rate[i])


@kernel
def predict_axis(gains: EstimatorGains, state: EstimatorState, axis: int, acceleration: float, dt: float) -> None:
    """Advance one axis by dt under a measured acceleration, gravity removed."""
    x, p, h = state.motion[axis], state.covariance[axis], 0.5 * dt * dt
    acceleration -= x[2]
    x[0] += dt * x[1] + h * acceleration
    x[1] += dt * acceleration
    noise = gains.accelerometer**2
    by_p = p[0] + dt * p[1] - h * p[2]
    by_v = p[1] + dt * p[3] - h * p[4]
    by_b = p[2] + dt * p[4] - h * p[5]
    p[3] += dt * (dt * p[5] - 2.0 * p[4]) + noise * dt * dt
    p[4] -= dt * p[5]
    p[0] = by_p + dt * by_v - h * by_b + noise * h * h
    p[1] = by_v - dt * by_b + noise * h * dt
    p[2] = by_b
    p[5] += gains.accelerometer_drift**2 * dt


@kernel
def correct_axis(state: EstimatorState, axis: int, of_velocity: bool, measured: float, variance: float) -> None:
    """Kalman update of one axis with a measured position or velocity."""
    x, p = state.motion[axis], state.covariance[axis]
    pp, pv, pb, vv, vb, bb = p[0], p[1], p[2], p[3], p[4], p[5]
    a, b, c = (pv, vv, vb) if of_velocity else (pp, pv, pb)
    seen = vv if of_velocity else pp
    over = 1.0 / (seen + variance)
    step = (measured - (x[1] if of_velocity else x[0])) * over
    x[0] += a * step
    x[1] += b * step
    x[2] += c * step
    p[0], p[1], p[2] = pp - a * a * over, pv - a * b * over, pb - a * c * over
    p[3], p[4], p[5] = vv - b * b * over, vb - b * c * over, bb - c * c * over
