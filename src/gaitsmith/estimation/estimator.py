"""State estimation from noisy sensors: attitude, base velocity and position, accelerometer bias, joint velocities.

Han 2023, section 4.3: a Kalman filter fuses the accelerometer with the legs, and a first-order one smooths
differentiated joint angles. The filter's point is the IMU, so that no angular acceleration is ever needed; every
world axis has its own filter with the state (position, velocity, accelerometer bias).
"""

from __future__ import annotations

from typing import NamedTuple

from gaitsmith.compiled import IntVector, kernel
from gaitsmith.dynamics.kinematics import forward_kinematics, forward_velocities
from gaitsmith.dynamics.points import point_velocity, sole_pose
from gaitsmith.estimation.filters import EstimatorGains as EstimatorGains
from gaitsmith.estimation.filters import EstimatorState as EstimatorState
from gaitsmith.estimation.filters import correct_axis, filter_attitude, filter_joints, predict_axis, turn_to_torso
from gaitsmith.estimation.filters import make_estimator_gains as make_estimator_gains
from gaitsmith.estimation.filters import make_estimator_state as make_estimator_state
from gaitsmith.estimation.measurement import Measurement
from gaitsmith.whole_body.frames import Body
from gaitsmith.whole_body.reference import FLAT


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
        state.angular_velocity[axis] = state.gyro[axis]
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
def _trust(gains: EstimatorGains, state: EstimatorState, leg: int, force: float, planned: int, dt: float) -> float:
    """How far a sole may be taken to be at rest, 0 to 1: it must be planned, loaded, and have settled."""
    if force < gains.contact_force:
        state.contact_time[leg] = 0.0
        return 0.0
    state.contact_time[leg] += dt
    if planned != FLAT or state.contact_time[leg] < gains.settling:
        return 0.0
    return min(force / gains.full_force, 1.0)


class Estimation(NamedTuple):
    """What the estimator reads and writes; of the measurement only what the sensors say."""

    body: Body
    measurement: Measurement
    gains: EstimatorGains
    state: EstimatorState


@kernel
def estimate(g: Estimation, dt: float, in_contact: IntVector) -> None:
    """One tick of all filters on checked readings: the body's q and v; x, y start at 0, z = 0 is below the lowest sole.

    Afterwards the body's tree state holds poses, motion subspaces, velocities for the estimated attitude and joints
    with the base at the origin and without linear velocity; the caller updates it.

    Args:
        g: the robot's first joint is free and the rest are the actuated hinges and slides.
        dt: s since the last tick.
        in_contact: (n_legs,) 1 for a sole that is planned to stand; it counts if its force says so too.
    """
    tree, tree_state, legs, q_out, v_out = g.body.tree, g.body.state, g.body.legs, g.body.q, g.body.v
    gains, state, measurement = g.gains, g.state, g.measurement
    turn_to_torso(gains, state, measurement)
    starting = state.started[0] == 0
    if starting:
        _start(gains, state, measurement)
    else:
        filter_joints(gains, state, measurement.joint_position, dt)
        filter_attitude(gains, state, measurement, dt)
    for i in range(3):
        q_out[i] = v_out[i] = 0.0
        v_out[3 + i] = state.angular_velocity[i]
    for i in range(4):
        q_out[3 + i] = state.quaternion[i]
    for j in range(state.joint_velocity.shape[0]):
        q_out[7 + j] = measurement.joint_position[j]
        v_out[6 + j] = state.joint_velocity[j]
    forward_kinematics(tree, tree_state, q_out)
    forward_velocities(tree, tree_state, v_out)

    axes, spin, f = tree_state.body_rotation[legs.torso[0]], tree_state.velocity[legs.torso[0]], state.force
    local = gains.imu_position
    x = axes[0, 0] * local[0] + axes[0, 1] * local[1] + axes[0, 2] * local[2]
    y = axes[1, 0] * local[0] + axes[1, 1] * local[1] + axes[1, 2] * local[2]
    z = axes[2, 0] * local[0] + axes[2, 1] * local[1] + axes[2, 2] * local[2]
    imu = (x, y, z)
    lever = (spin[1] * z - spin[2] * y, spin[2] * x - spin[0] * z, spin[0] * y - spin[1] * x)
    if not starting:
        for axis in range(3):
            force = axes[axis, 0] * f[0] + axes[axis, 1] * f[1] + axes[axis, 2] * f[2]
            predict_axis(gains, state, axis, force + tree.gravity[axis], dt)
    lowest = 0.0
    for leg in range(state.ground.shape[0]):
        body = legs.sole_body[leg]
        sole_pose(tree, tree_state, body, legs.sole_position[leg], legs.sole_rotation[leg], state.sole, state.sole_axes)
        point_velocity(tree, tree_state, body, state.sole, v_out, state.twist)
        if starting:
            lowest = min(lowest, state.sole[2])
            state.ground[leg] = state.sole[2]
            continue
        height = state.sole[2] - imu[2]
        trust = _trust(gains, state, leg, measurement.sole_force[leg], in_contact[leg], dt)
        if state.contact_time[leg] < gains.settling:
            state.ground[leg] = state.motion[2, 0] + height
        if trust > 0.0:
            variance = (gains.leg_odometry / trust) ** 2
            for axis in range(3):
                correct_axis(state, axis, True, lever[axis] - state.twist[axis], variance)
            correct_axis(state, 2, False, state.ground[leg] - height, (gains.foot_height / trust) ** 2)
    if starting:
        state.motion[0, 0], state.motion[1, 0], state.motion[2, 0] = imu[0], imu[1], imu[2] - lowest
        for leg in range(state.ground.shape[0]):
            state.ground[leg] -= lowest
        state.started[0] = 1
    for axis in range(3):
        q_out[axis] = state.motion[axis, 0] - imu[axis]
        v_out[axis] = state.motion[axis, 1] - lever[axis]
