"""Memory of the controller between ticks, and the gains of a preset as its kernels read them."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gaitsmith.compiled import IntVector, Matrix, Vector

if TYPE_CHECKING:
    from gaitsmith.robots import Robot
    from gaitsmith.robots.parameters import ControlParameters


class ControlState(NamedTuple):
    """What one tick leaves for the next.

    Attributes:
        time: (1,) since the reset, s.
        q: (7 + nj,) true or estimated configuration.
        v: (6 + nj,) true or estimated velocity.
        torque: (nj,) last torque sent, N·m.
        leg_reference: (2, n_leg) joint angles of the inverse kinematics, hip to ankle, rad.
        leg_rate: (2, n_leg) their rates, rad/s.
        joint_reference: (nj,) the same in joint order, 0 outside the legs, rad.
        joint_rate: (nj,) their rates, rad/s.
        foot_desired: (6, 3) rows 0-2 left, 3-5 right: desired position, velocity, acceleration of the sole; hip
            midpoint, heading frame.
        support_curve: (3,) desired z, its rate and acceleration of the support sole, m.
        foothold: (2,) target of the swing sole, m.
        standing_height: (1,) hip height held while standing, m; moves slowly towards the commanded one.
        counts: (3,) bad measurements, inverse-kinematics fallbacks, forced touchdowns.
        estimated: (1,) 1 if the state is estimated from sensors.
        arm: (3,) CoM relative to the stance sole, heading frame, m.
        expected: (4,) velocity that the foothold answers to and its reference, heading frame, m/s.
        drift: (2,) CoM relative to the station, heading frame, m.
        com_offset: (2,) CoM relative to the hip midpoint, heading frame, m.
        com_acceleration: (2,) predicted by the last whole-body solution, heading frame, m/s².
        target: (2, 3) scratch: position and velocity of a sole, torso frame.
        target_rotation: (3, 3) scratch: sole to torso.
    """

    time: Vector
    q: Vector
    v: Vector
    torque: Vector
    leg_reference: Matrix
    leg_rate: Matrix
    joint_reference: Vector
    joint_rate: Vector
    foot_desired: Matrix
    support_curve: Vector
    foothold: Vector
    standing_height: Vector
    counts: IntVector
    estimated: IntVector
    arm: Vector
    expected: Vector
    drift: Vector
    com_offset: Vector
    com_acceleration: Vector
    target: Matrix
    target_rotation: Matrix


class TickGains(NamedTuple):
    """Scalars of a preset that belong to no single task."""

    dt: float
    joint_stiffness: float
    joint_damping: float
    foot_stiffness: float
    foot_damping: float
    knee: float
    swing_joint: float
    swing_ankle: float
    other_joint: float
    other_stiffness: float
    other_damping: float
    ankle_speed_gain: float
    ankle_torque_limit: float
    standing_stiffness: float
    standing_damping: float
    entry_speed: float
    inverse_gain: float
    inverse_step_weight: float
    inverse_change_weight: float
    inverse_pitch_weight: float


def make_control_state(robot: Robot, estimated: bool) -> ControlState:
    """Memory of a controller that has not ticked yet."""
    n_joints = len(robot.joint_names)
    n_leg = len(robot.legs[0].joints)
    return ControlState(
        time=np.zeros(1),
        q=np.zeros(7 + n_joints),
        v=np.zeros(6 + n_joints),
        torque=np.zeros(n_joints),
        leg_reference=np.zeros((2, n_leg)),
        leg_rate=np.zeros((2, n_leg)),
        joint_reference=np.zeros(n_joints),
        joint_rate=np.zeros(n_joints),
        foot_desired=np.zeros((6, 3)),
        support_curve=np.zeros(3),
        foothold=np.zeros(2),
        standing_height=np.zeros(1),
        counts=np.zeros(3, dtype=np.int64),
        estimated=np.array([int(estimated)]),
        arm=np.zeros(3),
        expected=np.zeros(4),
        drift=np.zeros(2),
        com_offset=np.zeros(2),
        com_acceleration=np.zeros(2),
        target=np.zeros((2, 3)),
        target_rotation=np.zeros((3, 3)),
    )


def make_tick_gains(parameters: ControlParameters, dt: float) -> TickGains:
    """Kernel form of a preset's remaining scalars."""
    tracking, weights = parameters.tracking, parameters.weights
    inverse = parameters.inverse_kinematics
    return TickGains(
        dt=dt,
        joint_stiffness=tracking.joint_stiffness,
        joint_damping=tracking.joint_damping,
        foot_stiffness=tracking.foot_stiffness,
        foot_damping=tracking.foot_damping,
        knee=weights.knee,
        swing_joint=weights.swing_joint,
        swing_ankle=weights.swing_ankle,
        other_joint=weights.other_joint,
        other_stiffness=parameters.other_joints.stiffness,
        other_damping=parameters.other_joints.damping,
        ankle_speed_gain=parameters.ankle.speed_gain,
        ankle_torque_limit=parameters.ankle.torque_limit,
        standing_stiffness=parameters.standing.com_stiffness,
        standing_damping=parameters.standing.com_damping,
        entry_speed=parameters.standing.entry_speed,
        inverse_gain=inverse.gain,
        inverse_step_weight=inverse.step_weight,
        inverse_change_weight=inverse.change_weight,
        inverse_pitch_weight=inverse.pitch_weight,
    )
