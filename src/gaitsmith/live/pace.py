"""When the next tick is due: in real time, slower, or not at all; how many came late; who goes first."""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable

LATE = 1e-3  # s after it was due that a tick counts as late
_GIVE_UP = 0.25  # s behind after which the clock is set anew: what was lost is not made up for


class Pace:
    """Keeps a loop at a share of real time.

    Args:
        step: simulated time of a tick, s.
        clock: monotonic, s.
        sleep: waits for so many s.

    Attributes:
        ticks: paced so far.
        late: of them, begun more than 1 ms after they were due.
        worst: how late the latest one was since :meth:`forget`, s.
        lost: s that were given up because the loop had fallen too far behind.
    """

    def __init__(
        self, step: float, clock: Callable[[], float] = time.perf_counter, sleep: Callable[[float], None] = time.sleep
    ) -> None:
        self._step, self._clock, self._sleep = step, clock, sleep
        self._factor = 1.0
        self.ticks, self.late, self.worst, self.lost = 0, 0, 0.0, 0.0
        self.restart()

    @property
    def factor(self) -> float:
        """Simulated time over wall time."""
        return self._factor

    @factor.setter
    def factor(self, factor: float) -> None:
        if factor != self._factor:
            self._factor = factor
            self.restart()

    def restart(self) -> None:
        """The next tick is due now."""
        self._due = self._clock()

    def forget(self) -> None:
        """Begin anew to count."""
        self.ticks, self.late, self.worst, self.lost = 0, 0, 0.0, 0.0

    def wait(self) -> None:
        """Wait until the next tick is due, and take note if it is too late for that."""
        now = self._clock()
        while now < self._due:
            self._sleep(self._due - now)
            now = self._clock()
        behind = now - self._due
        self.ticks += 1
        self.worst = max(self.worst, behind)
        if behind > LATE:
            self.late += 1
        if behind > _GIVE_UP:
            self.lost += behind
            self._due = now
        self._due += self._step / self._factor


def go_first() -> bool:
    """Let this process run ahead of ordinary ones where the system allows that; whether it does.

    Round robin at the lowest real-time priority, which needs CAP_SYS_NICE or a limit ``rtprio`` above 0.
    """
    if not hasattr(os, "sched_setscheduler"):
        return False
    try:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))
    except OSError:
        return False
    return True


def wait_in_line() -> None:
    """Be an ordinary process again."""
    with contextlib.suppress(OSError, AttributeError):
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
