"""State estimation from noisy sensors: attitude, base velocity and position, accelerometer bias, joint velocities.

Han 2023, section 4.3: a Kalman filter fuses the accelerometer with the legs, and a first-order one smooths
differentiated joint angles. The filter's point is the IMU, so that no angular acceleration is ever needed; every
world axis has its own filter with the state (position, velocity, accelerometer bias).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import IntVector, Matrix, Vector, kernel
from gaitsmith.control.frames import Legs
from gaitsmith.control.measurement import Measurement
from gaitsmith.dynamics.contact import sole_pose
from gaitsmith.dynamics.kinematics import move, place
from gaitsmith.dynamics.points import point_velocity
from gaitsmith.dynamics.tree import Tree, TreeState
from gaitsmith.robots.parameters import EstimatorParameters

_GYRO = 0.02  # rad/s, noise of one sample
_ATTITUDE = 0.005  # rad, noise of one sample of the measured attitude
_GYRO_TIME = 0.002  # s, time constant of the angular velocity's low-pass filter
_SETTLING = 0.02  # s, a sole that has just landed is not yet at rest
_FULL_LOAD = 0.3  # share of the weight at which a sole counts fully


class EstimatorGains(NamedTuple):
    """:class:`EstimatorParameters` as a kernel reads them, and what the robot adds.

    Attributes:
        imu_position: (3,) torso frame, m.
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
    parameters: EstimatorParameters, imu_position: Vector, contact_force: float, weight: float
) -> EstimatorGains:
    """Kernel form of ``parameters``.

    Args:
        parameters: standard deviations.
        imu_position: (3,) torso frame, m.
        contact_force: sole force that counts as contact, N.
        weight: of the whole robot, N.
    """
    return EstimatorGains(
        imu_position=np.array(imu_position, dtype=np.float64),
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
def _is_usable(measurement: Measurement) -> bool:
    """Whether all sensors that are read gave finite numbers and the attitude is a rotation."""
    poison = norm = 0.0
    for i in range(3):
        poison += 0.0 * measurement.accelerometer[i] + 0.0 * measurement.gyro[i]
    for i in range(4):
        norm += measurement.base_quaternion[i] ** 2
    for j in range(measurement.joint_position.shape[0]):
        poison += 0.0 * measurement.joint_position[j]
    for leg in range(measurement.sole_force.shape[0]):
        poison += 0.0 * measurement.sole_force[leg]
    return poison == 0.0 and norm > 0.25 and norm < 4.0


@kernel
def _start(gains: EstimatorGains, state: EstimatorState, measurement: Measurement) -> None:
    """Trust the first sample as it is and assume rest."""
    for j in range(state.joint_velocity.shape[0]):
        state.joint_previous[j] = measurement.joint_position[j]
        state.joint_velocity[j] = 0.0
    for i in range(4):
        state.quaternion[i] = measurement.base_quaternion[i]
    state.joint_variance[0] = 0.0
    state.attitude_variance[0] = gains.attitude**2
    for axis in range(3):
        state.angular_velocity[axis] = measurement.gyro[axis]
        for k in range(3):
            state.motion[axis, k] = 0.0
        for k in range(6):
            state.covariance[axis, k] = 0.0
        state.covariance[axis, 0] = gains.foot_height**2
        state.covariance[axis, 3] = gains.leg_odometry**2
        state.covariance[axis, 5] = gains.accelerometer**2
    for leg in range(state.ground.shape[0]):
        state.ground[leg] = 0.0
        state.contact_time[leg] = gains.settling


@kernel
def _filter_joints(gains: EstimatorGains, state: EstimatorState, angles: Vector, dt: float) -> None:
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
def _turn(quaternion: Vector, x: float, y: float, z: float) -> None:
    """Multiply a quaternion from the right by the rotation vector (x, y, z), body axes, and normalise it."""
    angle = math.sqrt(x * x + y * y + z * z)
    half = 0.5 * math.sin(0.5 * angle) / (0.5 * angle) if angle > 1e-8 else 0.5
    c, x, y, z = math.cos(0.5 * angle), half * x, half * y, half * z
    q0, q1, q2, q3 = quaternion[0], quaternion[1], quaternion[2], quaternion[3]
    w = q0 * c - q1 * x - q2 * y - q3 * z
    a = q0 * x + q1 * c + q2 * z - q3 * y
    b = q0 * y - q1 * z + q2 * c + q3 * x
    d = q0 * z + q1 * y - q2 * x + q3 * c
    over = 1.0 / math.sqrt(w * w + a * a + b * b + d * d)
    quaternion[0], quaternion[1], quaternion[2], quaternion[3] = w * over, a * over, b * over, d * over


@kernel
def _filter_attitude(gains: EstimatorGains, state: EstimatorState, measurement: Measurement, dt: float) -> None:
    """Turn with the gyro, then a Kalman share of the way to the measured attitude."""
    rate, q, m = state.angular_velocity, state.quaternion, measurement.base_quaternion
    _turn(q, measurement.gyro[0] * dt, measurement.gyro[1] * dt, measurement.gyro[2] * dt)
    predicted = state.attitude_variance[0] + (gains.gyro * dt) ** 2
    gain = predicted / (predicted + gains.attitude**2)
    state.attitude_variance[0] = (1.0 - gain) * predicted
    w = q[0] * m[0] + q[1] * m[1] + q[2] * m[2] + q[3] * m[3]
    share = 2.0 * gain / (w if abs(w) > 0.1 else math.copysign(0.1, w))
    _turn(
        q,
        share * (q[0] * m[1] - q[1] * m[0] - q[2] * m[3] + q[3] * m[2]),
        share * (q[0] * m[2] + q[1] * m[3] - q[2] * m[0] - q[3] * m[1]),
        share * (q[0] * m[3] - q[1] * m[2] + q[2] * m[1] - q[3] * m[0]),
    )
    follow = dt / (gains.gyro_time + dt)
    for i in range(3):
        rate[i] += follow * (measurement.gyro[i] - rate[i])


@kernel
def _predict(gains: EstimatorGains, state: EstimatorState, axis: int, acceleration: float, dt: float) -> None:
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
def _correct(state: EstimatorState, axis: int, of_velocity: bool, measured: float, variance: float) -> None:
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


@kernel
def _trust(gains: EstimatorGains, state: EstimatorState, leg: int, force: float, planned: int, dt: float) -> float:
    """How far a sole may be taken to be at rest, 0 to 1: it must be planned, loaded, and have settled."""
    if force < gains.contact_force:
        state.contact_time[leg] = 0.0
        return 0.0
    state.contact_time[leg] += dt
    if planned == 0 or state.contact_time[leg] < gains.settling:
        return 0.0
    return min(force / gains.full_force, 1.0)


@kernel
def estimate(
    tree: Tree,
    tree_state: TreeState,
    legs: Legs,
    gains: EstimatorGains,
    state: EstimatorState,
    measurement: Measurement,
    dt: float,
    in_contact: IntVector,
    q_out: Vector,
    v_out: Vector,
) -> bool:
    """One tick of all filters.

    Afterwards ``tree_state`` holds poses, motion subspaces, velocities for the estimated attitude and joints with
    the base at the origin and without linear velocity; the caller updates it with ``q_out`` and ``v_out``.

    Args:
        tree: the robot; its first joint is free and the rest are the actuated hinges and slides.
        tree_state: overwritten.
        legs: sole frames.
        gains: from :func:`make_estimator_gains`.
        state: from :func:`make_estimator_state`.
        measurement: only attitude, joint angles, accelerometer, gyro, and sole forces are read.
        dt: s.
        in_contact: (n_legs,) 1 for a sole that is planned to stand; it counts if its force says so too.
        q_out: (7 + nj,) receives the configuration; x, y, z are integrated from 0 and the first ground's height 0.
        v_out: (6 + nj,) receives the velocity.

    Returns:
        False if a sensor gave no usable number; then nothing was changed.
    """
    if not _is_usable(measurement):
        return False
    starting = state.started[0] == 0
    if starting:
        _start(gains, state, measurement)
    else:
        _filter_joints(gains, state, measurement.joint_position, dt)
        _filter_attitude(gains, state, measurement, dt)
    for i in range(3):
        q_out[i] = v_out[i] = 0.0
        v_out[3 + i] = state.angular_velocity[i]
    for i in range(4):
        q_out[3 + i] = state.quaternion[i]
    for j in range(state.joint_velocity.shape[0]):
        q_out[7 + j] = measurement.joint_position[j]
        v_out[6 + j] = state.joint_velocity[j]
    place(tree, tree_state, q_out)
    move(tree, tree_state, v_out)

    axes, spin, f = (
        tree_state.body_rotation[legs.torso[0]],
        tree_state.velocity[legs.torso[0]],
        measurement.accelerometer,
    )
    local = gains.imu_position
    x = axes[0, 0] * local[0] + axes[0, 1] * local[1] + axes[0, 2] * local[2]
    y = axes[1, 0] * local[0] + axes[1, 1] * local[1] + axes[1, 2] * local[2]
    z = axes[2, 0] * local[0] + axes[2, 1] * local[1] + axes[2, 2] * local[2]
    imu = (x, y, z)
    lever = (spin[1] * z - spin[2] * y, spin[2] * x - spin[0] * z, spin[0] * y - spin[1] * x)
    if not starting:
        for axis in range(3):
            force = axes[axis, 0] * f[0] + axes[axis, 1] * f[1] + axes[axis, 2] * f[2]
            _predict(gains, state, axis, force + tree.gravity[axis], dt)
    lowest = 0.0
    for leg in range(state.ground.shape[0]):
        body = legs.sole_body[leg]
        sole_pose(tree, tree_state, body, legs.sole_position[leg], legs.sole_rotation[leg], state.sole, state.sole_axes)
        point_velocity(tree, tree_state, body, state.sole, v_out, state.twist)
        lowest = min(lowest, state.sole[2])
        if starting:
            continue
        height = state.sole[2] - imu[2]
        trust = _trust(gains, state, leg, measurement.sole_force[leg], in_contact[leg], dt)
        if state.contact_time[leg] < gains.settling:
            state.ground[leg] = state.motion[2, 0] + height
        if trust > 0.0:
            variance = (gains.leg_odometry / trust) ** 2
            for axis in range(3):
                _correct(state, axis, True, lever[axis] - state.twist[axis], variance)
            _correct(state, 2, False, state.ground[leg] - height, (gains.foot_height / trust) ** 2)
    if starting:
        state.motion[0, 0], state.motion[1, 0], state.motion[2, 0] = imu[0], imu[1], imu[2] - lowest
        state.started[0] = 1
    for axis in range(3):
        q_out[axis] = state.motion[axis, 0] - imu[axis]
        v_out[axis] = state.motion[axis, 1] - lever[axis]
    return True
