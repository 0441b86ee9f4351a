"""The certificate: every constraint's worst value over a dense grid, with the time and place where it occurs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from gaitsmith.synthesis.bounds import Bound
from gaitsmith.synthesis.motion import Phase

Array = npt.NDArray[np.float64]
ALLOWED = 1e-3  # share of a bound's range


@dataclass(frozen=True)
class Worst:
    """A constraint where it is closest to its limit, or furthest beyond it.

    Attributes:
        constraint: its name.
        value: in ``unit``.
        limit: the limit that it is compared with.
        unit: of both.
        time: s from the start of the motion.
        phase: name of the phase.
        violation: share of the constraint's range; negative inside.
    """

    constraint: str
    value: float
    limit: float
    unit: str
    time: float
    phase: str
    violation: float

    def as_dict(self) -> dict[str, object]:
        """Plain data for JSON."""
        return {
            "constraint": self.constraint,
            "value": self.value,
            "limit": self.limit,
            "unit": self.unit,
            "time": self.time,
            "phase": self.phase,
            "violation": self.violation,
        }


def merge(found: dict[str, Worst], phase: Phase, bounds: list[Bound], times: Array, values: Array) -> None:
    """Add one phase's values (bounds, N) to the worst so far."""
    for bound, row in zip(bounds, values, strict=True):
        over, under = (row - bound.high) / bound.span, (bound.low - row) / bound.span
        both = np.maximum(over, under)
        if bound.interior:
            both = both.copy()
            both[[0, -1]] = np.minimum(both[[0, -1]], 0.0)
        k = int(np.argmax(both))
        worst = float(both[k])
        if bound.name not in found or worst > found[bound.name].violation:
            limit = bound.high if over[k] >= under[k] else bound.low
            value, limit = bound.shown(float(row[k])), bound.shown(float(limit))
            found[bound.name] = Worst(bound.name, value, limit, bound.unit, float(times[k]), phase.name, worst)


def ranked(found: dict[str, Worst]) -> list[Worst]:
    """The worst first."""
    return sorted(found.values(), key=lambda item: -item.violation)
