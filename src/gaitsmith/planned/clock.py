"""The plan's clock: it jumps to touchdown when a sole lands early, and waits when it lands late.

What it gains or loses that way it gives back while all soles are on the ground, by running slower or faster.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import IntVector, Vector, kernel
from gaitsmith.planned.table import ENDLESS, PlanTable
from gaitsmith.whole_body.reference import NONE

ON_TIME, EARLY, LATE, FORCED = 0, 1, 2, 3
"""How a swing ended: not yet, by contact before or after its time, or because waiting took too long."""
_SLOWEST, _FASTEST = 0.7, 1.3


class PlanClock(NamedTuple):
    """Where a plan is.

    Attributes:
        visit: (1,) index into the plan's sequence.
        pass_number: (1,) of the loop, from 0.
        time: (1,) since the section's beginning, s.
        waited: (1,) time since the end of a swing whose sole has not landed, s.
        rate: (1,) of the plan's time against time.
        lead: (1,) by which the plan is ahead of the time that has passed, s.
        ended: (1,) 1 after the last section.
        touchdowns: (4,) how many swings ended EARLY, LATE and FORCED.
        steps: (1,) their sum.
        since_touchdown: (1,) s.
    """

    visit: IntVector
    pass_number: IntVector
    time: Vector
    waited: Vector
    rate: Vector
    lead: Vector
    ended: IntVector
    touchdowns: IntVector
    steps: IntVector
    since_touchdown: Vector


def make_plan_clock() -> PlanClock:
    """A clock at the plan's beginning."""

    def count(size: int) -> IntVector:
        return np.zeros(size, dtype=np.int64)

    return PlanClock(
        count(1), count(1), np.zeros(1), np.zeros(1), np.ones(1), np.zeros(1), count(1), count(4), count(1), np.zeros(1)
    )


@kernel
def is_swing(plan: PlanTable, section: int) -> bool:
    """Whether a sole is in the air in a section."""
    in_air = 0
    for row in range(plan.contact.shape[1]):
        in_air += 1 if plan.contact[section, row] == NONE else 0
    return in_air > 0


@kernel
def flies(plan: PlanTable, section: int) -> bool:
    """Whether all soles are in the air in a section."""
    return bool(plan.contact[section, plan.support[section]] == NONE)


@kernel
def _following(plan: PlanTable, clock: PlanClock, visit: int) -> int:
    """The visit after another one, -1 after the last. Passes are counted from the clock's present one."""
    if visit + 1 == plan.loop_end and (plan.passes == ENDLESS or clock.pass_number[0] + 1 < plan.passes):
        return plan.loop_first
    return visit + 1 if visit + 1 < plan.sequence.shape[0] else -1


@kernel
def next_stretch(plan: PlanTable, clock: PlanClock) -> int:
    """First visit after the present one with other soles on the ground, -1 if there is none."""
    section, visit = plan.sequence[clock.visit[0]], clock.visit[0]
    for _ in range(plan.sequence.shape[0]):
        visit = _following(plan, clock, visit)
        if visit < 0:
            return -1
        for row in range(plan.contact.shape[1]):
            if (plan.contact[section, row] == NONE) != (plan.contact[plan.sequence[visit], row] == NONE):
                return visit
    return -1


@kernel
def _enter(clock: PlanClock, visit: int, time: float) -> None:
    """Go on with a visit."""
    if visit <= clock.visit[0]:
        clock.pass_number[0] += 1
    clock.visit[0], clock.time[0] = visit, time


@kernel
def _has_landed(plan: PlanTable, section: int, following: int, force: Vector, threshold: float) -> bool:
    """Whether a sole that is in the air in one section and on the ground in the other bears more than a threshold."""
    for row in range(plan.contact.shape[1]):
        lands = plan.contact[section, row] == NONE and plan.contact[following, row] != NONE
        if lands and force[row] > threshold:
            return True
    return False


@kernel
def _rate(plan: PlanTable, clock: PlanClock, section: int, pace: float) -> float:
    """Rate at which the plan's lead is gone by the end of a double support; the pace in a swing."""
    left = plan.stretch_duration[section] - plan.stretch_start[section] - clock.time[0]
    if is_swing(plan, section):
        return pace
    if left <= 0.0 or left + clock.lead[0] <= 0.0:
        return float(clock.rate[0])
    return float(min(max(left / (left + clock.lead[0]), _SLOWEST), _FASTEST))


@kernel
def advance(
    plan: PlanTable,
    clock: PlanClock,
    dt: float,
    pace: float,
    force: Vector,
    threshold: float,
    earliest: float,
    window: float,
    longest: float,
) -> int:
    """Advance the clock by one tick.

    Args:
        plan: the plan.
        clock: its clock.
        dt: s.
        pace: rate of the clock in a swing.
        force: (n,) measured normal force on every sole, N.
        threshold: force from which a sole counts as landed, N.
        earliest: share of a swing after which a landing counts.
        window: before the planned landing in which a landing is on time, s: the plan goes on to its own.
        longest: time to wait for a late landing, s.

    Returns:
        How a swing that ends by contact ended in this tick; ON_TIME otherwise.
    """
    if clock.ended[0] == 1:
        return ON_TIME
    section = plan.sequence[clock.visit[0]]
    clock.rate[0] = _rate(plan, clock, section, pace)
    clock.time[0] += dt * clock.rate[0]
    clock.lead[0] += dt * (clock.rate[0] - 1.0)
    clock.since_touchdown[0] += dt
    left = plan.stretch_duration[section] - plan.stretch_start[section] - clock.time[0]
    visit = next_stretch(plan, clock) if plan.by_contact[section] == 1 else -1
    if visit >= 0 and not 0.0 < left <= window and left <= (1.0 - earliest) * plan.stretch_duration[section]:
        event = ON_TIME
        if _has_landed(plan, section, plan.sequence[visit], force, threshold):
            event = EARLY if clock.waited[0] == 0.0 else LATE
        elif left <= 0.0:
            clock.waited[0] += dt
            clock.lead[0] -= dt
            clock.time[0] = plan.duration[section]
            if clock.waited[0] < longest:
                return ON_TIME
            event = FORCED
        if event != ON_TIME:
            clock.lead[0] += max(left, 0.0)
            clock.waited[0], clock.since_touchdown[0] = 0.0, 0.0
            clock.touchdowns[event] += 1
            clock.steps[0] += 1
            _enter(clock, visit, 0.0)
            return event
    while clock.time[0] >= plan.duration[section]:
        visit = _following(plan, clock, clock.visit[0])
        if visit < 0:
            clock.time[0], clock.ended[0] = plan.duration[section], 1
            break
        _enter(clock, visit, clock.time[0] - plan.duration[section])
        section = plan.sequence[visit]
    return ON_TIME
