"""The plan's clock: on time, early, late, and in step with time again."""

import numpy as np
import pytest
from tests.planned.plans import DOUBLE, SINGLE, two_steps

from gaitsmith.planned.clock import EARLY, FORCED, LATE, ON_TIME, advance, make_plan_clock
from gaitsmith.planned.table import ENDLESS

DT, FORCE, SHARE, WINDOW, LONGEST = 1e-3, 10.0, 0.6, 0.02, 0.05
STEP = SINGLE + DOUBLE


def run(plan, until, lands):
    """Events with their times; ``lands(time)`` says whether the swing sole touches the ground."""
    clock, events = make_plan_clock(), []
    for tick in range(round(until / DT)):
        force = np.full(2, 2.0 * FORCE if lands(tick * DT) else 0.0)
        event = advance(plan, clock, DT, 1.0, force, FORCE, SHARE, WINDOW, LONGEST)
        if event != ON_TIME:
            events.append((event, (tick + 1) * DT))
    return clock, events


def test_a_sole_that_lands_early_ends_the_swing_and_the_time_is_given_back():
    clock, events = run(two_steps(), STEP + 0.01, lambda time: time > 0.25)
    assert events[0] == (EARLY, pytest.approx(0.252, abs=2e-3))
    clock, _ = run(two_steps(), 0.3, lambda time: time > 0.25)
    assert clock.lead[0] > 0.0
    clock, _ = run(two_steps(), STEP, lambda time: 0.275 < time < 0.3)
    assert clock.lead[0] == pytest.approx(0.0, abs=2.0 * DT)
    assert clock.visit[0] in (1, 2)


def test_a_contact_before_its_share_of_the_swing_is_not_a_landing():
    _, events = run(two_steps(), 0.5 * SINGLE, lambda time: True)
    assert events == []


def test_a_landing_just_before_its_time_is_on_time():
    _, events = run(two_steps(), SINGLE + 0.05, lambda time: time > SINGLE - 0.9 * WINDOW)
    assert events == [(EARLY, pytest.approx(SINGLE, abs=3.0 * DT))]


def test_the_clock_waits_for_a_late_landing_and_catches_up():
    clock, events = run(two_steps(), SINGLE + 0.5 * LONGEST, lambda time: False)
    assert events == []
    assert clock.lead[0] == pytest.approx(-0.5 * LONGEST, abs=2.0 * DT)
    _, events = run(two_steps(), STEP, lambda time: time > SINGLE + 0.02)
    assert events == [(LATE, pytest.approx(SINGLE + 0.02, abs=3.0 * DT))]


def test_waiting_has_an_end():
    clock, events = run(two_steps(), SINGLE + 2.0 * LONGEST, lambda time: False)
    assert events == [(FORCED, pytest.approx(SINGLE + LONGEST, abs=2.0 * DT))]
    assert clock.touchdowns[FORCED] == clock.steps[0] == 1


def test_a_loop_is_passed_as_often_as_it_says():
    def on_time(time):
        return time % STEP > SINGLE - 1.5 * DT

    clock, _ = run(two_steps(passes=3), 6.0 * STEP + 0.1, on_time)
    assert clock.ended[0] == 1
    assert clock.steps[0] == 6
    clock, _ = run(two_steps(passes=3), 6.0 * STEP - 0.05, on_time)
    assert clock.ended[0] == 0
    clock, _ = run(two_steps(passes=ENDLESS), 20.0 * STEP, on_time)
    assert clock.ended[0] == 0
    assert clock.steps[0] == 20
