"""Wishes on their way from the page to the loop: few, and of what can change often only the last."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable

from gaitsmith.live.handover import Ring
from gaitsmith.live.wishes import Kind, Wish

_MOST = 16
_SELDOM = {Kind.RESET: 1.0, Kind.TERRAIN: 1.0, Kind.RECORD: 0.5, Kind.PUSH: 0.1}  # s between two of a kind
_LATEST = {Kind.GAIT, Kind.HOLD, Kind.FACTOR}


class Desk:
    """Takes wishes from the page's controls, in any thread, and hands them over when it is told to.

    Args:
        ring: to the loop.
        clock: monotonic, s.

    Attributes:
        dropped: wishes that came too fast.
    """

    def __init__(self, ring: Ring, clock: Callable[[], float] = time.monotonic) -> None:
        self._ring, self._clock = ring, clock
        self._waiting: deque[Wish] = deque()
        self._latest: dict[Kind, Wish] = {}
        self._last: dict[Kind, float] = {}
        self.dropped = 0

    def ask(self, kind: Kind, *values: float) -> None:
        """Wish for something."""
        if kind in _LATEST:
            self._latest[kind] = Wish(kind, values)
            return
        now = self._clock()
        if now - self._last.get(kind, -1e9) < _SELDOM.get(kind, 0.0) or len(self._waiting) >= _MOST:
            self.dropped += 1
            return
        self._last[kind] = now
        self._waiting.append(Wish(kind, values))

    def hand_over(self) -> None:
        """Give the loop what was wished for since the last time; it may look at it whenever it likes."""
        latest, self._latest = self._latest, {}
        for wish in latest.values():
            self._ring.write(wish.row())
        while self._waiting:
            self._ring.write(self._waiting.popleft().row())
