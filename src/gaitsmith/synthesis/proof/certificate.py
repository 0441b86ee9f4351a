"""The certificate of a file against what physics says: every field of every entry, and that none is missing."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from gaitsmith.synthesis.gaits.gait import Gait
from gaitsmith.synthesis.gaits.worst import Worst
from gaitsmith.synthesis.motions.motion import Phase
from gaitsmith.synthesis.proof.definitions import LOADED, Bound

Array = npt.NDArray[np.float64]
EXACT = 2e-6  # share of a bound's range by which two engines may differ at one instant
COARSE = 5e-3  # share of a bound's range by which the worst of two grids may differ
_TIME = 1e-7  # s
_SAME = 1e-9  # relative: numbers that were copied
_KEYS = {
    "constraint": str,
    "value": float,
    "limit": float,
    "unit": str,
    "time": float,
    "phase": str,
    "violation": float,
}
_WHOLE = {"claims", "dense_points", "effort_weights", "objective", "wrench_weight", "worst"}


def readings(bound: Bound) -> tuple[Array, Array, Array]:
    """(N,) values as shown, limits as shown, and violations; where a contact bears too little they are -inf."""
    value = np.asarray(bound.value, dtype=np.float64)
    if bound.load is not None:
        load = np.asarray(bound.load, dtype=np.float64)
        loaded = ~(load < LOADED)
        safe = np.where(loaded, load, 1.0)
        beyond = value / (bound.factor * safe**bound.power)
        shown, limit = bound.limit + beyond, np.full_like(value, bound.limit)
        return shown, limit, np.where(loaded, beyond / bound.span, -np.inf)
    over, under = (value - bound.high) / bound.span, (bound.low - value) / bound.span
    # Of a bound that holds inside a phase only, the ends count as kept where they are not beyond it.
    violation, limit = np.maximum(over, under), np.where(over >= under, bound.high, bound.low)
    if bound.sine:
        value, limit = np.arcsin(np.clip(value, -1.0, 1.0)), np.arcsin(np.clip(limit, -1.0, 1.0))
    return value, limit, violation


def tally(found: dict[str, Worst], beyond: dict[str, Worst], phase: Phase, bounds: list[Bound], times: Array) -> None:
    """Add one phase's bounds on its grid, ends included, to the worst so far, and to the worst that is not allowed."""
    for bound in bounds:
        shown, limit, violation = readings(bound)
        if bound.interior:
            violation[[0, -1]] = np.minimum(violation[[0, -1]], 0.0)
        k = int(np.argmax(violation))
        worst = float(violation[k])
        if worst == -np.inf:
            continue
        at = float(shown[k]), float(limit[k])
        entry = Worst(bound.name, *at, bound.unit, float(times[k]), phase.name, worst)
        held = worst <= bound.allowed and np.isfinite(entry.value)
        for items in (found,) if held else (found, beyond):
            if bound.name not in items or worst > items[bound.name].violation or np.isnan(worst):
                items[bound.name] = entry


def unloaded(bounds: list[Bound]) -> float:
    """Largest violation of the cones of contacts that bear too little for ratios, as a share of the weight."""
    most = 0.0
    for bound in bounds:
        if bound.load is not None:
            few = np.asarray(bound.value)[np.asarray(bound.load) < LOADED]
            most = float(np.maximum(most, few.max(initial=0.0)))
    return most


def ranked(found: dict[str, Worst]) -> list[Worst]:
    """The worst first."""
    return sorted(found.values(), key=lambda item: -np.inf if np.isnan(item.violation) else -item.violation)


def entries(stored: dict[str, Any]) -> tuple[list[dict[str, Any]], list[str]]:
    """The certificate's entries, if all of them are of the right shape, and what is wrong with it in words."""
    problems = [f"the certificate's {key}: no such entry is known" for key in sorted(set(stored) - _WHOLE)][:3]
    problems += [f"the certificate has no {key}" for key in sorted(_WHOLE - set(stored))]
    rows = stored.get("worst")
    if not isinstance(rows, list) or not rows:
        return [], [*problems, "the certificate in the file has no list of worst values"]
    for index, row in enumerate(rows):
        if not isinstance(row, dict) or set(row) != set(_KEYS):
            return [], [*problems, f"the certificate's worst[{index}] does not have the entries {', '.join(_KEYS)}"]
        for key, kind in _KEYS.items():
            value = row[key]
            fits = isinstance(value, (int, float)) if kind is float else isinstance(value, kind)
            if not fits or isinstance(value, bool) or (kind is float and not abs(value) < np.inf):
                return [], [*problems, f"the certificate's worst[{index}].{key} is no {kind.__name__}"]
    points = stored.get("dense_points")
    if type(points) is not int or not 50 <= points <= 5000:
        problems.append("the certificate's dense_points are no whole number from 50 to 5000")
    names = [row["constraint"] for row in rows]
    problems += [f"the certificate has {name[:60]} twice" for name in sorted({n for n in names if names.count(n) > 1})]
    sizes = [row["violation"] for row in rows]
    if sizes != sorted(sizes, reverse=True):
        problems.append("the certificate's worst values are not in the order of their violations")
    return rows, problems


def claimed_at(rows: list[dict[str, Any]], gait: Gait, points: int) -> dict[int, list[dict[str, Any]]]:
    """Entries by the phase that they name, if their time is one of its instants; the others under -1."""
    borders, found = gait.motion.borders, dict[int, list[dict[str, Any]]]()
    for row in rows:
        place = -1
        for index, phase in enumerate(gait.motion.phases):
            share = (row["time"] - borders[index]) / phase.duration * (points - 1)
            on_grid = abs(share - round(share)) * phase.duration <= _TIME * (points - 1)
            if phase.name == row["phase"] and on_grid and 0 <= round(share) <= points - 1:
                place = index
        found.setdefault(place, []).append(row)
    return found


def disagrees(row: dict[str, Any], bounds: list[Bound], instant: int) -> str:
    """What an entry says otherwise than physics at its own time, in words; empty if nothing.

    Args:
        row: the entry.
        bounds: of its phase, at the times of the phase's entries.
        instant: its place among those times.
    """
    name, texts = row["constraint"], []
    for bound in (item for item in bounds if item.name == name):
        shown, limit, violation = (values[instant] for values in readings(bound))
        span = bound.span if not bound.sine else max(bound.span, 1e-3)
        worst = min(violation, 0.0) if bound.interior and row["violation"] == 0.0 else violation
        wrong = [
            f"{key} {row[key]:.6g}, {real:.6g} by physics"
            for key, real, allowed in (
                ("value", shown, EXACT * max(span, abs(limit) if np.isfinite(limit) else 0.0)),
                ("limit", limit, _SAME * max(1.0, abs(limit))),
                ("violation", worst, EXACT * max(1.0, abs(worst))),
            )
            if not abs(row[key] - real) <= allowed
        ]
        if row["unit"] != bound.unit:
            wrong.append(f"unit {row['unit'][:20]!r}, it is {bound.unit!r}")
        if not wrong:
            return ""
        texts.append(wrong[0])
    if not texts:
        return f"{name[:60]} at {row['time']:.6g} s in {row['phase'][:40]}: no such bound there"
    return f"{name} in the file's certificate: {min(texts, key=len)}"


def missing(rows: list[dict[str, Any]], found: dict[str, Worst]) -> list[str]:
    """Constraints that only one side has, and those whose worst value the file does not tell."""
    told = {row["constraint"]: row for row in rows}
    texts = []
    for name in sorted(told.keys() ^ found.keys()):
        texts.append(f"{name[:60]} is only {'in' if name in told else 'missing from'} the file's certificate")
    for name in sorted(told.keys() & found.keys()):
        if not found[name].violation - told[name]["violation"] <= COARSE:
            texts.append(
                f"{name}: violation {told[name]['violation']:.6g} in the file's certificate, "
                f"{found[name].violation:.6g} by physics at {found[name].time:.4g} s"
            )
    return texts
