"""Joint torque (Han 2023, eq. 27): feedforward plus joint PD, inside the limits, never NaN; braking and holding."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gaitsmith.compiled import Matrix, Vector, kernel
from gaitsmith.whole_body.frames import Body
from gaitsmith.whole_body.reference import NONE, Reference

if TYPE_CHECKING:
    from gaitsmith.robots.presets import JointGains


class JointFeedback(NamedTuple):
    """Joint PD gains; rows: swing leg, stance leg; columns: hip to ankle."""

    stiffness: Matrix
    damping: Matrix


def make_joint_feedback(gains: JointGains, n_leg: int) -> JointFeedback:
    """Kernel form of ``gains`` for legs of ``n_leg`` joints; an empty list is none."""
    none = (0.0,) * n_leg
    return JointFeedback(
        stiffness=np.array([gains.swing_stiffness or none, gains.stance_stiffness or none]),
        damping=np.array([gains.swing_damping or none, gains.stance_damping or none]),
    )


@kernel
def bounded_torque(feedforward: float, feedback: float, limit: float) -> float:
    """Sum of both clipped to ``±limit``; 0 if it is not a number."""
    torque = feedforward + feedback
    if math.isnan(torque):
        return 0.0
    return min(max(torque, -limit), limit)


@kernel
def add_joint_feedback(feedback: JointFeedback, body: Body, reference: Reference, torque: Vector) -> None:
    """Add the PD of eq. 27 to ``torque`` (nj,), with the gains of a swing or a stance leg."""
    legs, q, v = body.legs, body.q, body.v
    for leg in range(legs.joints.shape[0]):
        row = 0 if reference.contact[leg] == NONE else 1
        for i in range(legs.joints.shape[1]):
            joint = legs.joints[leg, i]
            torque[joint] += feedback.stiffness[row, i] * (reference.joint[0, joint] - q[7 + joint])
            torque[joint] += feedback.damping[row, i] * (reference.joint[1, joint] - v[6 + joint])


@kernel
def braked_torque(limit: float, speed: float, brake: float) -> float:
    """Torque against a joint's speed; ``brake`` in units of the limit per rad/s."""
    return bounded_torque(-brake * limit * speed, 0.0, limit)


@kernel
def held_torque(limit: float, error: float, speed: float, hold: float, brake: float) -> float:
    """Torque that holds a joint where it is; ``hold`` is the error at which the limit is used, rad."""
    return bounded_torque(limit * error / hold, -brake * limit * speed, limit)
