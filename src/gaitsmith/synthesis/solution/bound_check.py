"""Bounds on a dense grid: where a solution violates them, and which instants to add to the program."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from gaitsmith.synthesis.point.functions import PointFunctions
from gaitsmith.synthesis.point.layout import PointLayout
from gaitsmith.synthesis.program.bounds import NO_LOAD, PhaseBound
from gaitsmith.synthesis.program.margin import TOUCHING
from gaitsmith.synthesis.program.program import ImposedBound
from gaitsmith.synthesis.program.transcription import Points, Transcription, instant_keys
from gaitsmith.synthesis.solution.curves_from_solution import local_inputs, phase_pieces
from gaitsmith.synthesis.solution.passive import LocalPiece, balanced, with_roots

Array = npt.NDArray[np.float64]
_TIGHTEST = 0.3  # of a span: the stored curves close the chain better than the program does
_SPARE = 4e-4  # share of the span by which an added instant is tightened: the worst instant moves a little
_STEP = 1e-6  # share of the range by which a tightened instant is tightened at least
_CLOSE = 0.02  # of a bound's range: what a neighbour may well meet
_ENDS = 0.03  # share of a phase that counts as its end
_PEAKS = 4
_MEETING = 1e-6  # s
_RESTING = 0.1  # share of a phase next to a lift-off or touchdown
_LIGHT = 2e-3  # of the weight: contacts that bear less are looked at as if they bore this
_SAME = 0.02  # share of a phase within which two instants count as one


class BoundTable:
    """A phase's bounds as matrices: value = out @ o + inp @ z + offset."""

    def __init__(self, layout: PointLayout, bounds: list[PhaseBound]) -> None:
        count = len(bounds)
        self.bounds = bounds
        self.out, self.inp = np.zeros((count, layout.outputs)), np.zeros((count, layout.inputs))
        for row, bound in enumerate(bounds):
            self.out[row, list(bound.out)] = list(bound.out.values())
            self.inp[row, list(bound.inp)] = list(bound.inp.values())
        self.low = np.array([bound.low for bound in bounds])[:, None]
        self.high = np.array([bound.high for bound in bounds])[:, None]
        self.span = np.array([bound.span for bound in bounds])[:, None]
        self.slack = np.array([bound.slack for bound in bounds])
        self.interior = [row for row, bound in enumerate(bounds) if bound.interior]
        self._constant = np.array([0.0 if bound.rise else bound.constant for bound in bounds])[:, None]
        self._risen = [row for row, bound in enumerate(bounds) if bound.rise]
        self._loaded = np.array([row for row, bound in enumerate(bounds) if bound.load != NO_LOAD], dtype=np.int64)
        loaded = [bounds[row] for row in self._loaded.tolist()]
        self._load = np.array([bound.load for bound in loaded], dtype=np.int64)
        self._power = np.array([bound.power for bound in loaded], dtype=np.int64)[:, None]
        self._scale = np.array([bound.factor * bound.ratio_span / bound.span for bound in loaded])[:, None]

    def values(self, o: Array, z: Array, s: Array) -> Array:
        """(bounds, N) values in the bounds' units; s (N,) is the normalised time in the phase."""
        found = self.out @ o + self.inp @ z + self._constant
        for row in self._risen:
            found[row] += self.bounds[row].offset(s)
        return np.asarray(found)

    def violations(self, values: Array, loads: Array) -> tuple[Array, Array]:
        """(bounds, N) share of the range by which a bound is violated, and what such a share is of the span.

        Of a contact the range is that of the ratio of its forces, so that a share of the span goes with its load.
        """
        share = np.maximum(self.low - values, values - self.high) / self.span
        scales = np.ones_like(share)
        scales[self._loaded] = self._scale * np.maximum(loads, _LIGHT)[self._load] ** self._power
        return share / scales, scales


class Tables:
    """The bounds of every phase as matrices: those with their margins, and the true ones.

    Args:
        trans: unknowns and bounds.
    """

    def __init__(self, trans: Transcription) -> None:
        self.inner, self.limits = (
            [BoundTable(trans.layout, bounds) for bounds in every] for every in (trans.bounds, trans.limits)
        )


@dataclass(frozen=True, eq=False)
class BoundCheck:
    """Violations of one phase on its dense grid.

    Attributes:
        times: (N,) s.
        violations: (bounds, N) of the bounds with their margins, share of the range.
        scales: (bounds, N) of a bound's span that a share is.
        excess: by how much a violation is more than is accepted, at most.
        values: (bounds, N) of the true bounds.
        loads: (2, N) normal forces on the support sole and the other, as shares of the weight.
        pieces: the phase's curves as they will be stored.
    """

    times: Array
    violations: Array
    scales: Array
    excess: float
    values: Array
    loads: Array
    pieces: list[LocalPiece]


def check_bounds(
    trans: Transcription, functions: PointFunctions, x: Array, count: int, tables: Tables
) -> list[BoundCheck]:
    """All bounds of all phases at ``count`` instants each, on the curves as they will be stored."""
    borders, found = trans.motion.borders, []
    every = [phase_pieces(trans, functions, x, phase) for phase in range(len(trans.motion.phases))]
    for phase, pieces in enumerate(with_roots(trans, functions, every)):
        times = np.linspace(borders[phase], borders[phase + 1], count)
        z = balanced(trans, functions, phase, local_inputs(trans, x, phase, pieces, times))
        o = functions.evaluate(z, np.tile(trans.pivots[phase][:, None], (1, count)), trans.motion.phases[phase].side)
        inner, limits = tables.inner[phase], tables.limits[phase]
        share = trans.share(phase, times)
        loads = np.array([o[trans.layout.force + 2], z[trans.layout.wrench + 2]]) / trans.biped.weight
        violations, scales = inner.violations(inner.values(o, z, share), loads)
        values, most = limits.values(o, z, share), violations.copy()
        interior = inner.interior
        most[interior] = limits.violations(values, loads)[0][interior]  # their margin is a part of what they are
        for end in (0, -1):
            most[interior, end] = np.minimum(most[interior, end], 0.0)
        excess = float((most.max(axis=1) - inner.slack).max())
        found.append(BoundCheck(times, violations, scales, excess, values, loads, pieces))
    return found


def worst_excess(checks: list[BoundCheck]) -> float:
    """Largest violation of any bound beyond what is accepted of it, as a share of its range."""
    return max(item.excess for item in checks)


def with_violated(
    trans: Transcription, checks: list[BoundCheck], imposed: list[ImposedBound], tolerance: float, settled: bool = True
) -> list[ImposedBound]:
    """The imposed bounds with an instant added, or tightened, at every local worst violation above ``tolerance``.

    ``settled``: whether they hold to the solver's tolerance; after a rough solve none is tightened.
    """
    found, places = list(imposed), places_of(imposed)
    for phase, bound, k in _peaks(trans, checks, tolerance, 0.0):
        item = checks[phase]
        scale, time = float(item.scales[bound, k]), float(item.times[k])
        near = _near(trans, found, places[phase, bound], phase, bound, time)
        if near is None:
            places[phase, bound].append(len(found))
            found.append(ImposedBound(phase, bound, time, scale * _spare(trans, phase, bound, time)))
        elif settled:
            # What was not enough before is doubled beside what is lacking: the worst instant moves away from this one.
            old, more = found[near], scale * (1.2 * float(item.violations[bound, k]) + _STEP)
            found[near] = ImposedBound(phase, bound, old.time, min(2.0 * old.tighten + more, _TIGHTEST))
    return found


def _spare(trans: Transcription, phase: int, bound: int, time: float) -> float:
    """How far an added instant is tightened: not at all where a foot still rests, or has no load yet."""
    item = trans.bounds[phase][bound]
    other = min(item.inp, default=0) >= trans.layout.wrench or max(item.out, default=0) >= trans.layout.twist
    share = float(trans.share(phase, np.array(time)))
    exact = item.slack <= TOUCHING and not item.interior  # met exactly, and not to be missed there
    return 0.0 if exact or ((item.interior or other) and min(share, 1.0 - share) < _RESTING) else _SPARE


def with_close(trans: Transcription, checks: list[BoundCheck], imposed: list[ImposedBound]) -> list[ImposedBound]:
    """The imposed bounds with every instant added at which a bound is nearly met, for neighbours in which it may be."""
    found, places = list(imposed), places_of(imposed)
    for phase, bound, k in _peaks(trans, checks, -_CLOSE, _ENDS):
        time = float(checks[phase].times[k])
        if _near(trans, found, places[phase, bound], phase, bound, time) is None:
            places[phase, bound].append(len(found))
            found.append(ImposedBound(phase, bound, time))
    return found


def _peaks(
    trans: Transcription, checks: list[BoundCheck], tolerance: float, ends: float
) -> Iterator[tuple[int, int, int]]:
    """Phase, bound and instant of local worst violations, at most four of a bound and phase, the worst first.

    ``ends``: share of a phase that is left out at both ends, where a foot at rest and no load sit on their bounds.
    """
    for phase, item in enumerate(checks):
        last = len(item.times) - 1
        slacks = np.array([bound.slack for bound in trans.bounds[phase]])
        least = np.minimum(tolerance, 0.25 * slacks)
        for bound in np.flatnonzero(item.violations.max(axis=1) > least).tolist():
            v = item.violations[bound].copy()
            if ends or slacks[bound] <= TOUCHING:
                v[: int(ends * last) + 1], v[last - int(ends * last) :] = -np.inf, -np.inf
            before, after = np.append(-np.inf, v[:-1]), np.append(v[1:], -np.inf)
            peaks = np.flatnonzero((v > least[bound]) & (v >= before) & (v > after))
            for k in sorted(peaks.tolist(), key=lambda k: -v[k])[:_PEAKS]:
                yield phase, bound, k


def places_of(imposed: list[ImposedBound]) -> defaultdict[tuple[int, int], list[int]]:
    """Indices of imposed bounds, by phase and bound."""
    found = defaultdict[tuple[int, int], list[int]](list)
    for index, item in enumerate(imposed):
        found[item.phase, item.bound].append(index)
    return found


def _near(
    trans: Transcription, imposed: list[ImposedBound], places: list[int], phase: int, bound: int, time: float
) -> int | None:
    """Index of the imposed one of the same bound, which are at ``places``, that is as good as at the same time."""
    # A bound that is met exactly at a border is not to be missed there because of an instant beside it.
    exact = trans.bounds[phase][bound].slack <= TOUCHING
    within = _MEETING if exact else _SAME * trans.motion.phases[phase].duration
    near = [(abs(imposed[index].time - time), index) for index in places]
    near = [item for item in near if item[0] < within]
    return min(near)[1] if near else None


def with_times(trans: Transcription, points: Points, imposed: list[ImposedBound]) -> Points:
    """Points with those instants of the imposed bounds added that they lack."""
    own = [len(bounds) for bounds in trans.bounds]  # rates count on from these
    real = [item for item in imposed if item.bound < own[item.phase]]
    phases = np.array([item.phase for item in real], dtype=np.int64)
    times = np.array([item.time for item in real], dtype=np.float64)
    keys = instant_keys(phases, times)
    first = np.sort(np.unique(keys, return_index=True)[1])  # in the order in which they were imposed
    first = first[~np.isin(keys[first], points.keys())]
    return points.with_(trans.instants(phases[first], times[first]))
