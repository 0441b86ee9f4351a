"""Ticks come when they are due; those that do not are counted."""

from __future__ import annotations

import os
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import pytest

from gaitsmith.live.pace import Pace, go_first, wait_in_line


class Clock:
    def __init__(self):
        self.now, self.slept = 0.0, 0.0

    def __call__(self):
        return self.now

    def sleep(self, seconds):
        self.now, self.slept = self.now + seconds, self.slept + seconds


@pytest.mark.parametrize("factor", [1.0, 0.2])
def test_time_passes_at_the_share_that_is_wished(factor):
    clock = Clock()
    pace = Pace(0.001, clock, clock.sleep)
    pace.factor = factor
    for _ in range(1001):
        pace.wait()
    assert clock.now == pytest.approx(1.0 / factor)
    assert (pace.ticks, pace.late) == (1001, 0)


def test_late_ticks_are_counted_and_made_up_for():
    clock = Clock()
    pace = Pace(0.001, clock, clock.sleep)
    pace.wait()
    clock.now += 0.0045  # something held it up: the ticks of 1, 2 and 3 ms come 3.5, 2.5 and 1.5 ms late
    for _ in range(20):
        pace.wait()
    assert pace.late == 3
    assert pace.worst == pytest.approx(0.0035)
    assert clock.now == pytest.approx(0.020)


def test_what_is_lost_for_good_is_said():
    clock = Clock()
    pace = Pace(0.001, clock, clock.sleep)
    pace.wait()
    clock.now += 5.0
    for _ in range(3):
        pace.wait()
    assert (pace.late, clock.slept) == (1, pytest.approx(0.002))
    assert pace.lost == pytest.approx(4.999)
    pace.forget()
    assert (pace.ticks, pace.late, pace.lost) == (0, 0, 0.0)


def test_it_goes_first_where_that_is_allowed_and_not_for_ever():
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        allowed, during, after = pool.submit(_scheduled).result(60.0)
    assert after == os.SCHED_OTHER
    assert during == (os.SCHED_RR if allowed else os.SCHED_OTHER)


def _scheduled():
    allowed = go_first()
    during = os.sched_getscheduler(0)
    wait_in_line()
    return allowed, during, os.sched_getscheduler(0)
