"""The certificate: every constraint's worst value over a dense grid, with the time and place where it occurs."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from gaitsmith.synthesis.gaits.worst import Worst
from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.motions.motion import Phase, opposite
from gaitsmith.synthesis.program.bounds import NO_LOAD, PhaseBound
from gaitsmith.synthesis.program.transcription import Transcription
from gaitsmith.synthesis.solution.bound_check import BoundCheck

Array = npt.NDArray[np.float64]
LOADED = 0.01  # of the weight: ratios of a foot's forces are told where it bears at least this


def merge(
    found: dict[str, Worst],
    phase: Phase,
    bounds: list[PhaseBound],
    times: Array,
    values: Array,
    loads: Array | None = None,
) -> None:
    """Add one phase's values (bounds, N) to the worst so far.

    A contact's value is shown as the ratio of its forces, where the foot bears enough for one.

    Args:
        found: the worst so far.
        phase: the phase.
        bounds: its bounds.
        times: (N,) s.
        values: (bounds, N) of their forms.
        loads: (2, N) normal forces on the support sole and the other, as shares of the weight.
    """
    for bound, row in zip(bounds, values, strict=True):
        low, high, span = bound.low, bound.high, bound.span
        shown, enough = row, np.ones(len(row), dtype=bool)
        if bound.load != NO_LOAD and loads is not None:
            enough = ~(loads[bound.load] < LOADED)
            shown = bound.limit + row / (bound.factor * np.where(enough, loads[bound.load], 1.0) ** bound.power)
            high, span = bound.limit, bound.ratio_span
        over, under = (shown - high) / span, (low - shown) / span
        both = np.where(enough, np.maximum(over, under), -np.inf)
        if bound.interior:
            both[[0, -1]] = np.minimum(both[[0, -1]], 0.0)
        k = int(np.argmax(both))
        worst = float(both[k])
        # A number that is not finite stays the worst.
        known = found.get(bound.name)
        if (worst > -np.inf and (known is None or worst > known.violation)) or np.isnan(worst):
            value, limit = (bound.shown(float(v)) for v in (shown[k], high if over[k] >= under[k] else low))
            found[bound.name] = Worst(bound.name, value, limit, bound.unit, float(times[k]), phase.name, worst)


def ranked(found: dict[str, Worst]) -> list[Worst]:
    """The worst first."""
    return sorted(found.values(), key=lambda item: -np.inf if np.isnan(item.violation) else -item.violation)


def mirrored_entry(entry: dict[str, Any], biped: Biped) -> dict[str, Any]:
    """An entry of a certificate in the mirror image: of the other leg's joints, of the other foot."""
    joint, _, what = str(entry["constraint"]).partition(" ")
    names = biped.robot.joint_names
    for place, name in enumerate(names):
        if entry["constraint"] in (f"{name} torque", f"{name} angle", f"{name} velocity", f"{name} torque rate"):
            other, sign = int(biped.partner[place]), float(biped.sign[int(biped.partner[place])])
            constraint = names[other] + str(entry["constraint"])[len(name) :]
            return entry | {"constraint": constraint, "value": sign * entry["value"], "limit": sign * entry["limit"]}
    if joint in ("left", "right") and what.startswith("foot "):
        return entry | {"constraint": f"{opposite('left' if joint == 'left' else 'right')} {what}"}
    return entry


def certificate(trans: Transcription, checks: list[BoundCheck]) -> list[Worst]:
    """Every constraint's worst value, the worst first."""
    found: dict[str, Worst] = {}
    for phase, bounds, item in zip(trans.motion.phases, trans.limits, checks, strict=True):
        merge(found, phase, bounds, item.times, item.values, item.loads)
    return ranked(found)
