"""One channel of readings: what is wrong with it by itself and by the model; kept, or replaced."""

from __future__ import annotations

import math

from gaitsmith.compiled import kernel
from gaitsmith.estimation.readings import ATTITUDE, CONTRADICTION, GOOD, JUMP, MISSING, STUCK, Checking, Readings

_STILL = 3  # ticks without change after which a reading may be stuck
_SURE = 0.2  # of the slack: deviation that is enough for one that has long been still
_AGAIN = 5  # ticks for which a reading has to look good again
_WIDER = 10.0  # gate of a reading that comes back after it was missing or stuck, in gates


@kernel
def judge(r: Readings, c: int, dt: float) -> int:
    """What is wrong with one channel by itself and, while torques drive it, by the model; keeps its raw reading."""
    usable, same, off = True, True, 0.0
    for i in range(r.first[c], r.first[c + 1]):
        y = r.values[i]
        usable = usable and abs(y) <= r.bound[c]
        same = same and y == r.before[i]
        off = max(off, abs(y - r.wanted[i]))
        r.before[i] = y
    r.still[c] = r.still[c] + 1 if same else 0
    if not usable:
        return MISSING
    if r.trusted[0] == 1:
        return GOOD
    gate, was = r.gate[c], r.what[c]
    if was == CONTRADICTION and gate < math.inf:
        gate = r.slack[c]
    elif was in (MISSING, STUCK):
        gate *= _WIDER
    elif was == JUMP:
        gate *= 1.0 + dt * r.lost[c]
    if (
        r.moving[0] == 1
        and r.still[c] >= _STILL
        and (off > r.slack[c] * max(_STILL / r.still[c], _SURE) or was != GOOD)
    ):
        return STUCK
    if was == JUMP and 4 * r.blind[c] > r.patience[c] and r.still[c] == 0 and off < _WIDER * r.gate[c]:
        return GOOD  # it moves, and nothing else says where the joint is: better than braking
    return JUMP if off > gate else GOOD


@kernel
def passes(r: Readings, c: int) -> bool:
    """Whether a channel was good and moves as the model says; then it is kept, as by :func:`judge` and :func:`settle`.

    That is what happens in nearly every tick, and takes a fraction of their time.
    """
    if r.what[c] != GOOD or r.lost[c] > 0 or r.again[c] > 0:
        return False
    fine, moves, bound, gate = True, False, r.bound[c], r.gate[c]
    for i in range(r.first[c], r.first[c + 1]):
        y = r.values[i]
        fine = fine and abs(y) <= bound and abs(y - r.wanted[i]) <= gate
        moves = moves or y != r.before[i]
    if not (fine and moves):
        return False
    for i in range(r.first[c], r.first[c + 1]):
        r.before[i] = r.wanted[i] = r.values[i]
    r.still[c] = 0
    return True


@kernel
def settle(r: Readings, c: int, what: int, seen: bool) -> None:
    """Keep or replace a channel's reading; ``seen`` if more than the model stands in for it."""
    was = r.what[c]
    if what == GOOD and was != GOOD and was != MISSING:
        r.again[c] += 1
        if r.again[c] < _AGAIN:
            what = was
    elif what != GOOD:
        r.again[c] = 0
        what = was if was != GOOD else what
    if what != was:
        r.changes[0] += 1
        r.what[c] = what
    if what == GOOD:
        r.lost[c] = r.again[c] = r.blind[c] = 0
        if r.still[c] == 0 or r.trusted[0] == 1:
            for i in range(r.first[c], r.first[c + 1]):
                r.wanted[i] = r.values[i]
        if r.culprit[0] == c:
            r.culprit[0] = -1
        return
    r.lost[c] += 1
    r.blind[c] = 0 if seen else r.blind[c] + 1
    for i in range(r.first[c], r.first[c + 1]):
        r.values[i] = r.wanted[i]
    if r.blind[c] > r.patience[c] and r.culprit[0] < 0:
        r.culprit[0] = c
        r.changes[0] += 1


@kernel
def is_valid(r: Readings, c: int, was: int) -> int:
    """Whether the difference of a channel's last two readings is its velocity: 0, 1 if it stands still, 2 if it moves.

    ``was``: ticks for which it was lost before this one.
    """
    if was > 0 or r.lost[c] > 0 or r.trusted[0] == 1:
        return 0
    return 2 if r.still[c] == 0 else 1


@kernel
def judge_attitude(g: Checking, dt: float) -> int:
    """What is wrong with the attitude: as any channel, and it has to be a rotation; its sign is none."""
    q, p = g.measurement.base_quaternion, g.expected.base_quaternion
    norm = along = 0.0
    for i in range(4):
        norm += q[i] * q[i]
        along += q[i] * p[i]
    if along < 0.0:
        for i in range(4):
            p[i] = -p[i]
    what = judge(g.readings, ATTITUDE, dt)
    return what if 0.25 < norm < 4.0 else MISSING
