"""How long the control ticks took, in bounded memory: a histogram whose bins are half a per cent wide."""

from __future__ import annotations

import contextlib
import gc
import math
from collections.abc import Iterator
from time import perf_counter

import numpy as np
import numpy.typing as npt

from gaitsmith.simulation.summary import TickTimes

_LEAST, _MOST = 1e2, 1e11  # ns
_BINS_PER_E = 200
_BLOCK = 1000  # ticks that are sorted into bins at once


class WallTimes:
    """Wall times of control ticks.

    Args:
        control_step: s; a longer tick is an overrun.
    """

    def __init__(self, control_step: float) -> None:
        self._limit = 1e9 * control_step
        self._counts = np.zeros(math.ceil(_BINS_PER_E * math.log(_MOST / _LEAST)) + 1, dtype=np.int64)
        self._block = np.zeros(_BLOCK, dtype=np.int64)
        self._filled, self._longest, self._overruns = 0, 0, 0
        self._told, self._told_overruns = self._counts.copy(), 0

    def add(self, nanoseconds: int) -> None:
        """Take note of one tick."""
        self._block[self._filled] = nanoseconds
        self._filled += 1
        if self._filled == _BLOCK:
            self._sort()

    def _sort(self) -> None:
        """Empty the block into the bins."""
        block = self._block[: self._filled]
        if not len(block):
            return
        places = np.rint(_BINS_PER_E * np.log(np.clip(block, _LEAST, _MOST) / _LEAST)).astype(np.int64)
        self._counts += np.bincount(places, minlength=len(self._counts))
        self._longest = max(self._longest, int(block.max()))
        self._overruns += int(np.count_nonzero(block > self._limit))
        self._filled = 0

    def histogram(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
        """Durations, µs, that occurred, and how many ticks took so long."""
        self._sort()
        used = np.flatnonzero(self._counts)
        return 1e-3 * _LEAST * np.exp(used / _BINS_PER_E), self._counts[used]

    def summary(self) -> TickTimes:
        """Median and 99th percentile within half a per cent, the longest, and the overruns."""
        self._sort()
        found = _summary(self._counts, self._overruns)
        return found.model_copy(update={"max": 1e-3 * self._longest})

    def lap(self) -> tuple[int, TickTimes]:
        """How many ticks there were since this was called last, and how long they took, within half a per cent."""
        self._sort()
        counts, overruns = self._counts - self._told, self._overruns - self._told_overruns
        self._told, self._told_overruns = self._counts.copy(), self._overruns
        return int(counts.sum()), _summary(counts, overruns)


def _summary(counts: npt.NDArray[np.int64], overruns: int) -> TickTimes:
    """Of the ticks in the bins."""
    below = np.cumsum(counts)
    if not below[-1]:
        return TickTimes(median=0.0, p99=0.0, max=0.0, overruns=0)
    places = np.searchsorted(below, [0.5 * below[-1], 0.99 * below[-1], below[-1]])
    median, late, longest = (1e-3 * _LEAST * math.exp(place / _BINS_PER_E) for place in places)
    return TickTimes(median=median, p99=late, max=longest, overruns=overruns)


class Stopwatch:
    """Wall time that was spent, collections of garbage left out.

    Attributes:
        seconds: so far.
    """

    def __init__(self) -> None:
        self.seconds = 0.0

    @contextlib.contextmanager
    def running(self) -> Iterator[None]:
        """Count the wall time, undisturbed by collections of garbage."""
        collecting = gc.isenabled()
        gc.disable()
        began = perf_counter()
        try:
            yield
        finally:
            self.seconds += perf_counter() - began
            if collecting:
                gc.enable()
