"""Bounds on a dense grid: where a solution violates them, and which instants to add to the program."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from gaitsmith.synthesis.bounds import Bound
from gaitsmith.synthesis.closure import LocalPiece, local_inputs, phase_pieces
from gaitsmith.synthesis.layout import Layout
from gaitsmith.synthesis.point import PointFunctions
from gaitsmith.synthesis.program import Pick
from gaitsmith.synthesis.transcription import Points, Transcription

Array = npt.NDArray[np.float64]
_TIGHTEST = 0.05
_SPARE = 4e-4  # share of the span by which an added instant is tightened: the worst instant moves a little
_SAME = 0.02  # share of a phase within which two instants count as one


class BoundTable:
    """A phase's bounds as matrices: value = out @ o + inp @ z + offset."""

    def __init__(self, layout: Layout, bounds: list[Bound]) -> None:
        count = len(bounds)
        self.bounds = bounds
        self.out, self.inp = np.zeros((count, layout.outputs)), np.zeros((count, layout.inputs))
        for row, bound in enumerate(bounds):
            for index, value in bound.out.items():
                self.out[row, index] = value
            for index, value in bound.inp.items():
                self.inp[row, index] = value
        self.low = np.array([bound.low for bound in bounds])[:, None]
        self.high = np.array([bound.high for bound in bounds])[:, None]
        self.span = np.array([bound.span for bound in bounds])[:, None]

    def values(self, o: Array, z: Array, s: Array) -> Array:
        """(bounds, N) values in the bounds' units; s (N,) is the normalised time in the phase."""
        return np.asarray(
            self.out @ o + self.inp @ z + np.array([np.broadcast_to(bound.offset(s), s.shape) for bound in self.bounds])
        )

    def violations(self, values: Array) -> Array:
        """(bounds, N) share of the span by which a bound is violated; negative inside."""
        return np.asarray(np.maximum(self.low - values, values - self.high) / self.span)


@dataclass(frozen=True, eq=False)
class DenseCheck:
    """Violations of one phase on its dense grid.

    Attributes:
        times: (N,) s.
        violations: (bounds, N) share of the span.
        values: (bounds, N).
        pieces: the phase's curves as they will be stored.
    """

    times: Array
    violations: Array
    values: Array
    pieces: list[LocalPiece]


def check(trans: Transcription, functions: PointFunctions, x: Array, count: int) -> list[DenseCheck]:
    """All bounds of all phases at ``count`` instants each, on the curves as they will be stored."""
    borders, found = trans.motion.borders, []
    for phase in range(len(trans.motion.phases)):
        pieces = phase_pieces(trans, functions, x, phase)
        times = np.linspace(borders[phase], borders[phase + 1], count)
        z = local_inputs(trans, x, phase, pieces, times)
        o = functions.evaluate(z, np.tile(trans.pivots[phase][:, None], (1, count)))
        table = BoundTable(trans.layout, trans.bounds[phase])
        values = table.values(o, z, trans.share(phase, times))
        found.append(DenseCheck(times, table.violations(values), values, pieces))
    return found


def worst_violation(checks: list[DenseCheck]) -> float:
    """Largest violation of any bound, as a share of its span."""
    return float(max(item.violations.max() for item in checks))


def new_picks(trans: Transcription, checks: list[DenseCheck], picks: list[Pick], tolerance: float) -> list[Pick]:
    """The picks with an instant added, or tightened, at every local worst violation above ``tolerance``."""
    found = list(picks)
    known: dict[tuple[int, int], list[int]] = {}
    for index, pick in enumerate(found):
        known.setdefault((pick.phase, pick.bound), []).append(index)
    for phase, item in enumerate(checks):
        length = trans.motion.phases[phase].duration
        last = len(item.times) - 1
        for bound in np.flatnonzero(item.violations.max(axis=1) > tolerance):
            v = item.violations[bound]
            if trans.bounds[phase][bound].interior:
                v = v.copy()
                v[[0, last]] = -1.0
            above = [int(k) for k in np.flatnonzero(v > tolerance)]
            peaks = [k for k in above if v[k] >= v[max(k - 1, 0)] and v[k] > v[min(k + 1, last)]]
            peaks = peaks or [int(np.argmax(v))]
            for k in sorted(peaks, key=lambda k: -v[k])[:4]:
                near = [
                    i for i in known.get((phase, int(bound)), []) if abs(found[i].time - item.times[k]) < _SAME * length
                ]
                if near:
                    i = min(near, key=lambda i: abs(found[i].time - item.times[k]))
                    old = found[i]
                    found[i] = Pick(old.phase, old.bound, old.time, min(old.tighten + 1.2 * float(v[k]), _TIGHTEST))
                else:
                    known.setdefault((phase, int(bound)), []).append(len(found))
                    found.append(Pick(phase, int(bound), float(item.times[k]), _SPARE))
    return found


def with_times(trans: Transcription, points: Points, picks: list[Pick]) -> Points:
    """Points with those instants of the picks added that they lack."""
    have = {(int(p), round(float(t), 9)) for p, t in zip(points.phase, points.time, strict=True)}
    phase, section, time = [], [], []
    for pick in picks:
        key = (pick.phase, round(pick.time, 9))
        if key not in have:
            have.add(key)
            first = trans.first_section[pick.phase]
            last = first + trans.motion.phases[pick.phase].sections - 1
            phase.append(pick.phase)
            section.append(min(max(trans.spline.section_at(pick.time), first), last))
            time.append(pick.time)
    if not phase:
        return points
    return Points(
        np.concatenate([points.phase, phase]).astype(np.int64),
        np.concatenate([points.section, section]).astype(np.int64),
        np.concatenate([points.time, time]),
        np.concatenate([points.weight, np.zeros(len(time))]),
    )
