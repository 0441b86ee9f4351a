"""What a tick asks of the whole body, and how much each wish weighs."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gaitsmith.compiled import IntVector, Matrix, Vector

if TYPE_CHECKING:
    from gaitsmith.robots.parameters import ControlParameters


class TaskGains(NamedTuple):
    """Weights and bounds of a preset as a kernel reads them."""

    stance_linear: float
    stance_angular: float
    swing_foot: float
    attitude: float
    knee: float
    swing_joint: float
    swing_ankle: float
    other_joint: float
    ankle_torque: float
    torque_change: float
    regularisation: float
    standing: float
    friction: float
    normal_low: float
    normal_high: float
    zmp_margin: float
    yaw_friction: float
    roll_stiffness: float
    roll_damping: float
    pitch_stiffness: float
    pitch_damping: float


class Targets(NamedTuple):
    """What the tick asks of the whole body.

    Attributes:
        in_contact: (2,) 1 for a sole that bears the robot.
        swing_acceleration: (2, 3) of each sole relative to the hip midpoint, heading frame, m/s².
        joint_acceleration: (nj,) rad/s².
        joint_weight: (nj,) cost of each joint's acceleration error.
        body_acceleration: (3,) CoM forward and lateral and hip vertical, heading frame, used on both feet, m/s².
        ankle_torque: (2,) soft target of each ankle pitch torque, N·m.
        torque_limit: (nj,) N·m.
    """

    in_contact: IntVector
    swing_acceleration: Matrix
    joint_acceleration: Vector
    joint_weight: Vector
    body_acceleration: Vector
    ankle_torque: Vector
    torque_limit: Vector


def make_task_gains(parameters: ControlParameters) -> TaskGains:
    """Kernel form of a preset's weights, contact bounds and attitude gains."""
    weights, contact, attitude = parameters.weights, parameters.contact, parameters.attitude
    return TaskGains(
        weights.stance_linear,
        weights.stance_angular,
        weights.swing_foot,
        weights.attitude,
        weights.knee,
        weights.swing_joint,
        weights.swing_ankle,
        weights.other_joint,
        weights.ankle_torque,
        weights.torque_change,
        weights.regularisation,
        parameters.standing.weight,
        contact.friction,
        contact.normal_force[0],
        contact.normal_force[1],
        contact.zmp_margin,
        contact.yaw_friction,
        attitude.roll_stiffness,
        attitude.roll_damping,
        attitude.pitch_stiffness,
        attitude.pitch_damping,
    )


def make_targets(torque_limit: Vector) -> Targets:
    """Targets of a robot standing still."""
    n_joints = len(torque_limit)
    return Targets(
        in_contact=np.ones(2, dtype=np.int64),
        swing_acceleration=np.zeros((2, 3)),
        joint_acceleration=np.zeros(n_joints),
        joint_weight=np.zeros(n_joints),
        body_acceleration=np.zeros(3),
        ankle_torque=np.zeros(2),
        torque_limit=np.array(torque_limit, dtype=np.float64),
    )
