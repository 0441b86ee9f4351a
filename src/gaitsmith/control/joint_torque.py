"""Joint torque (Han 2023, eq. 27): feedforward plus joint PD, inside the limits, never NaN."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gaitsmith.compiled import Matrix, kernel

if TYPE_CHECKING:
    from gaitsmith.robots.parameters import JointGains


class JointFeedback(NamedTuple):
    """Joint PD gains; rows: swing leg, stance leg; columns: hip to ankle."""

    stiffness: Matrix
    damping: Matrix


def make_joint_feedback(gains: JointGains) -> JointFeedback:
    """Kernel form of ``gains``."""
    return JointFeedback(
        stiffness=np.array([gains.swing_stiffness, gains.stance_stiffness]),
        damping=np.array([gains.swing_damping, gains.stance_damping]),
    )


@kernel
def bounded_torque(feedforward: float, feedback: float, limit: float) -> float:
    """Sum of both clipped to ``±limit``; 0 if it is not a number."""
    torque = feedforward + feedback
    if math.isnan(torque):
        return 0.0
    return min(max(torque, -limit), limit)
