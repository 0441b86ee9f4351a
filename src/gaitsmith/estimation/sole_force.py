"""The forces below the soles, against where the soles are and the step's clock."""

from __future__ import annotations

import math

from gaitsmith.compiled import kernel
from gaitsmith.estimation.channel import judge, settle
from gaitsmith.estimation.readings import GOOD, HIGH, STUCK, UNLOADED, Checking, Readings
from gaitsmith.whole_body.reference import NONE

_FORCE_STILL = 20  # ticks without change after which the force below a sole in the air is stuck
_SLOW = 0.08  # √(gz): speed below which a sole rests
_HIGH, _LOW = 0.04, 0.004  # z: above the standing sole: cannot have landed on the level; has landed
_HELD = 8  # ticks for which a force may be odd
_WAIT = 0.15  # 1/ω after the period for which a sole that has met no ground may hang before it follows its descent


@kernel
def check_force(g: Checking, leg: int, swing: int, time: float, period: float, earliest: float, least: float) -> None:
    """A sole's force; without it kinematics and the clock say whether the sole has landed.

    Args:
        g: everything.
        leg: of the sole.
        swing: the leg in the air; -1 on both feet.
        time: since the step began, s.
        period: of the step, s.
        earliest: before which no sole lands, s.
        least: force that counts as contact, N.
    """
    r, frames = g.readings, g.body.frames
    c = g.readings.what.shape[0] - frames.sole_position.shape[0] + leg
    stands, bearing = g.reference.contact[leg] != NONE, 0
    for k in range(frames.sole_position.shape[0]):
        bearing += 1 if g.reference.contact[k] != NONE else 0
    what, was, force, speed, height, landed = judge(r, c, 1.0), r.what[c], r.values[r.first[c]], 0.0, 0.0, False
    if what == STUCK:
        what = GOOD
    slow = _SLOW * r.rate_unit[0] * r.height_unit[0]
    if leg == swing:
        other = g.body.legs.other[leg]
        height = frames.sole_position[leg, 2] - frames.sole_position[other, 2]
        for i in range(3):
            speed += frames.sole_twist[leg, i] ** 2
        speed = math.sqrt(speed)
        bears = r.values[r.first[c - leg + other]] > least and r.lost[c - leg + other] == 0
        stopped = bears and time > period and abs(frames.sole_twist[leg, 2]) < 0.3 * slow
        landed = time > earliest and (height < _LOW * r.height_unit[0] or stopped)
        rests = stopped and time > period + _WAIT / r.rate_unit[0]
        if what == GOOD:
            what = _odd_force(r, leg, c, force > least, rests, height, speed, slow, time > earliest)
    else:
        r.odd[leg] = 0
        same = (was == STUCK and r.still[c] > 0) or was == HIGH or (was == UNLOADED and force <= least)
        what = was if what == GOOD and same else what
    share = r.weight[0] / max(bearing, 1)
    r.wanted[r.first[c]] = share if stands or landed else 0.0
    odd = what == GOOD and r.odd[leg] > 0 and force > least
    settle(r, c, what, True)
    if odd:
        r.values[r.first[c]] = 0.0


@kernel
def _odd_force(
    r: Readings,
    leg: int,
    c: int,
    loaded: bool,
    rests: bool,
    height: float,
    speed: float,
    slow: float,
    late: bool,
) -> int:
    """What is wrong with the force of a sole in its swing."""
    if loaded and r.still[c] >= _FORCE_STILL:
        return STUCK
    if not loaded:
        r.odd[leg] = r.odd[leg] + 1 if rests else 0
        return UNLOADED if r.odd[leg] > _HELD else GOOD
    if r.what[c] == HIGH:
        return HIGH
    if height < _HIGH * r.height_unit[0] or not late:
        r.odd[leg] = 0
        return GOOD
    if r.odd[leg] == 0:
        r.landing_speed[leg] = speed
    arrested = speed < max(0.5 * r.landing_speed[leg], slow) and r.still[c] == 0
    r.odd[leg] = 0 if arrested else r.odd[leg] + 1
    return HIGH if r.odd[leg] > _HELD else GOOD
