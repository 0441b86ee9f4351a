"""How far the robot is from its plan, tick by tick: compiled, so that the controller finds its memory in the caches."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import IntVector, Matrix, Vector, bind, kernel
from gaitsmith.whole_body.reference import FLAT, NONE, TOE

REAL, PLANNED = 0, 1
STRIKE, OFF = 0, 1


class PlanErrors(NamedTuple):
    """What is compared, and what was found since the first tick; n soles.

    Attributes:
        real: (3, 3) rotation of the torso to the world.
        planned: (3, 3) the same of the plan.
        contact: (n,) kinds of the plan's contacts.
        sole_pitch: (n,) of the real soles, toe down positive, rad.
        seen: (1,) ticks.
        before: (n,) the contacts of the last tick.
        tilt: (2,) largest roll and pitch of the real torso in the planned one's axes, rad.
        yaw: (2,) of the real and the planned torso at the last tick, rad.
        turn: (2,) by which they have turned, rad.
        pitch: (2, 2) sum of the soles' pitch at heel strike and toe-off, toe up and toe down positive, rad; how many.
    """

    real: Matrix
    planned: Matrix
    contact: IntVector
    sole_pitch: Vector
    seen: IntVector
    before: IntVector
    tilt: Vector
    yaw: Vector
    turn: Vector
    pitch: Matrix


def make_plan_errors(real: Matrix, planned: Matrix, contact: IntVector, sole_pitch: Vector) -> PlanErrors:
    """Nothing found yet; the arguments are shared."""
    seen, (tilt, yaw, turn) = np.zeros(1, dtype=np.int64), np.zeros((3, 2))
    return PlanErrors(real, planned, contact, sole_pitch, seen, contact.copy(), tilt, yaw, turn, np.zeros((2, 2)))


@kernel
def _turn(errors: PlanErrors, which: int, rotation: Matrix) -> None:
    """Add the turn about the vertical since the last tick, the short way round."""
    yaw = math.atan2(rotation[1, 0], rotation[0, 0])
    if errors.seen[0] > 0:
        errors.turn[which] += (yaw - errors.yaw[which] + math.pi) % (2.0 * math.pi) - math.pi
    errors.yaw[which] = yaw


@kernel
def _note(errors: PlanErrors, event: int, pitch: float) -> None:
    """Count a heel strike or a toe-off."""
    errors.pitch[event, 0] += pitch
    errors.pitch[event, 1] += 1.0


@kernel
def compare_with_plan(address: int) -> None:
    """Take note of a tick; ``address`` is that of an arena of :class:`PlanErrors`."""
    errors = bind(PlanErrors, address)
    real, planned = errors.real, errors.planned
    for axis in range(2):
        away = 0.0
        for i in range(3):
            away += planned[i, 2] * real[i, 1 - axis]
        if abs(away) > errors.tilt[axis] or math.isnan(away):
            errors.tilt[axis] = abs(away)
    _turn(errors, REAL, real)
    _turn(errors, PLANNED, planned)
    for sole in range(errors.contact.shape[0]):
        before, now = errors.before[sole], errors.contact[sole]
        if errors.seen[0] > 0 and before == NONE and now != NONE and now != FLAT:
            _note(errors, STRIKE, -errors.sole_pitch[sole])
        if errors.seen[0] > 0 and before == TOE and now == NONE:
            _note(errors, OFF, errors.sole_pitch[sole])
        errors.before[sole] = now
    errors.seen[0] += 1
