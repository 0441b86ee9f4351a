"""A plan replayed by joints alone: PD, planned torque, and ankles that correct the torso's attitude.

The clock alone moves the plan (:data:`BY_CLOCK_ALONE`). It shows what the whole-body controller is worth.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from gaitsmith.compiled import Vector, kernel
from gaitsmith.planned.law import FollowParameters
from gaitsmith.whole_body.frames import Body
from gaitsmith.whole_body.reference import FLAT, Reference

BY_CLOCK_ALONE = FollowParameters(earliest=2.0)


@dataclass(frozen=True)
class ReplayParameters:
    """Dimensionless gains; torques in m g z, times in 1/ω.

    Attributes:
        stiffness: of every joint.
        damping: of every joint.
        attitude: angle of an ankle per angle of the torso's deviation from the plan.
    """

    stiffness: float = 4.8
    damping: float = 0.5
    attitude: float = 0.5


class ReplayGains(NamedTuple):
    """:class:`ReplayParameters` of one robot: N·m/rad, N·m·s/rad, and a ratio."""

    stiffness: float
    damping: float
    attitude: float


@kernel
def replay_torque(gains: ReplayGains, body: Body, reference: Reference, torque: Vector) -> None:
    """Joint torques that replay a reference's joints, torque, torso and contacts, into ``torque`` (nj,), N·m."""
    legs, q, v, torso = body.legs, body.q, body.v, body.state.body_rotation[body.legs.torso[0]]
    for j in range(torque.shape[0]):
        torque[j] = reference.torque[j] + gains.stiffness * (reference.joint[0, j] - q[7 + j])
        torque[j] += gains.damping * (reference.joint[1, j] - v[6 + j])
    wanted = reference.torso_rotation
    roll = pitch = 0.0
    for i in range(3):
        roll += 0.5 * (wanted[i, 2] * torso[i, 1] - wanted[i, 1] * torso[i, 2])
        pitch += 0.5 * (wanted[i, 0] * torso[i, 2] - wanted[i, 2] * torso[i, 0])
    lean = gains.stiffness * gains.attitude
    for leg in range(legs.ankle_pitch.shape[0]):
        if reference.contact[leg] == FLAT:
            torque[legs.ankle_pitch[leg]] += lean * pitch
            if legs.ankle_roll[leg] >= 0:
                torque[legs.ankle_roll[leg]] += lean * roll
