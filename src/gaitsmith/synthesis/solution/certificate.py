"""The certificate: every constraint's worst value over a dense grid, with the time and place where it occurs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from gaitsmith.synthesis.motions.motion import Phase
from gaitsmith.synthesis.program.bounds import PhaseBound

Array = npt.NDArray[np.float64]
ALLOWED = 1e-3  # share of a bound's range
AGREES = 5e-3  # share of a bound's range by which a file's certificate may differ: verify's grid may be coarser


@dataclass(frozen=True)
class BoundMargin:
    """A constraint where it is closest to its limit, or furthest beyond it.

    Attributes:
        constraint: its name.
        value: in ``unit``.
        limit: the limit that it is compared with.
        unit: of both.
        time: s from the start of the motion.
        phase: name of the phase.
        violation: share of the constraint's range; negative inside.
        twin: name of the same constraint in the mirror image, empty if that has the same one.
    """

    constraint: str
    value: float
    limit: float
    unit: str
    time: float
    phase: str
    violation: float
    twin: str = ""

    def as_dict(self) -> dict[str, object]:
        """Plain data for JSON."""
        return {key: value for key, value in vars(self).items() if key != "twin"}


def merge(found: dict[str, BoundMargin], phase: Phase, bounds: list[PhaseBound], times: Array, values: Array) -> None:
    """Add one phase's values (bounds, N) to the worst so far."""
    for bound, row in zip(bounds, values, strict=True):
        over, under = (row - bound.high) / bound.span, (bound.low - row) / bound.span
        both = np.maximum(over, under)
        if bound.interior:
            both = both.copy()
            both[[0, -1]] = np.minimum(both[[0, -1]], 0.0)
        k = int(np.argmax(both))
        worst = float(both[k])
        # A number that is not finite stays the worst.
        if bound.name not in found or worst > found[bound.name].violation or np.isnan(worst):
            limit = bound.high if over[k] >= under[k] else bound.low
            value, limit = bound.shown(float(row[k])), bound.shown(float(limit))
            found[bound.name] = BoundMargin(
                bound.name, value, limit, bound.unit, float(times[k]), phase.name, worst, bound.twin
            )


def ranked(found: dict[str, BoundMargin]) -> list[BoundMargin]:
    """The worst first."""
    return sorted(found.values(), key=lambda item: -np.inf if np.isnan(item.violation) else -item.violation)


def disagreements(stored: dict[str, Any], found: dict[str, BoundMargin]) -> list[str]:
    """What a file's certificate says otherwise than physics, in words.

    A constraint and its mirror image count as one, because a walk repeats one cycle's certificate for the mirrored one.

    Args:
        stored: the certificate in the file, of whatever shape.
        found: every constraint's worst value as recomputed.
    """
    entries = stored.get("worst")
    if not isinstance(entries, list) or not entries:
        return ["the certificate in the file has no list of worst values"]
    pairs = [(item.constraint, item.twin) for item in found.values() if item.twin]
    same = {name: min(pair) for pair in pairs for name in pair}
    told: dict[str, float] = {}
    for index, entry in enumerate(entries):
        fields = entry if isinstance(entry, dict) else {}
        name, violation = fields.get("constraint"), fields.get("violation")
        if not isinstance(name, str) or not isinstance(violation, float) or not abs(violation) < np.inf:
            return [f"the certificate in the file does not say the constraint and its violation in worst[{index}]"]
        name = same.get(name, name)
        told[name] = max(told.get(name, -np.inf), violation)
    real: dict[str, float] = {}
    for item in found.values():
        name = same.get(item.constraint, item.constraint)
        real[name] = max(real.get(name, -np.inf), item.violation)
    texts = []
    for name in sorted(told.keys() ^ real.keys()):
        texts.append(f"{name[:60]} is only {'in' if name in told else 'missing from'} the file's certificate")
    for name in sorted(told.keys() & real.keys()):
        if abs(told[name] - real[name]) > AGREES:
            texts.append(f"{name}: violation {told[name]:.6g} in the file's certificate, {real[name]:.6g} by physics")
    return texts
