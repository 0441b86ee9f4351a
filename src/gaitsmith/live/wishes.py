"""What a page may ask of a walk: rows of numbers, each kind with its range; nothing else crosses to the loop."""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import IntEnum
from typing import NamedTuple

WIDTH = 10
"""Numbers in a row: the kind, then its arguments."""
SLOWEST, FASTEST = 0.05, 1.0
"""Simulated time over wall time."""
TERRAINS = ("flat", "slope", "boxes")
"""Kinds of ground by number; inclination in degrees or height in m, and seed, follow."""
PUSH_TIME = 0.1
"""s that a push lasts."""
HOLD_TIME = 0.3
"""s after which a force that is not renewed ends: the hand that drags may be gone."""


class Kind(IntEnum):
    """What is wished for."""

    GAIT = 0
    """All numbers of the gait, in the order of :func:`gaitsmith.robots.parameters.gait_numbers`."""
    WALK = 1
    """1 to walk, 0 to stand."""
    PUSH = 2
    """Impulse forward, to the left and up, heading axes, N·s."""
    HOLD = 3
    """Force, world axes, N, until the next one or for 0.3 s."""
    PAUSE = 4
    """1 to pause, 0 to go on."""
    STEP = 5
    """So many ticks while paused."""
    FACTOR = 6
    """Simulated time over wall time."""
    RESET = 7
    """Begin anew."""
    TERRAIN = 8
    """Begin anew on another ground: kind, amount, seed."""
    RECORD = 9
    """1 to begin, 0 to end."""
    END = 10
    """No more."""


class Wish(NamedTuple):
    """One wish; what is not given is 0."""

    kind: Kind
    values: tuple[float, ...] = ()

    def row(self) -> tuple[float, ...]:
        """The numbers that are handed over."""
        return (float(self.kind), *self.values, *(0.0,) * (WIDTH - 1 - len(self.values)))


def understood(row: Sequence[float]) -> Wish | None:
    """The wish in a row; None for what is none or is not finite."""
    if len(row) != WIDTH or not all(math.isfinite(number) for number in row) or row[0] not in list(Kind):
        return None
    return Wish(Kind(int(row[0])), tuple(row[1:]))
