"""Gaits of a library mixed: between the points of the grid, and from step to step without a seam.

All gaits of a library have the same phases, at the same shares of their stretches (a stretch is the time with the same
soles on the ground). A mix of gaits k with weights λ_k has the curves Σ λ_k(t) F_k(s(t)), s the share of the stretch.
While one sole swings, λ goes from the weights of the step before to its own, with rates and accelerations of zero at
both ends, and s(t) is the cubic whose rate at the ends is that of the gaits before and after: place, velocity and
acceleration go on evenly. While all soles stand, λ stays, as footholds do.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.library.folder import START, STOP, Folder
from gaitsmith.library.spec import AXES, Index, key_of
from gaitsmith.planned import Plan, PlanTable
from gaitsmith.planned.table import ENDLESS, TERMS
from gaitsmith.robots import Robot
from gaitsmith.splines.polynomial import chebyshev_fit
from gaitsmith.synthesis.gaits.walkable import walkable
from gaitsmith.whole_body.reference import NONE

Array = npt.NDArray[np.float64]
Weights = dict[Index, float]
_NAMES = {"speed": "speed", "step_height": "lift", "period": "period"}
"""What a gait input is called along each axis."""
_DIGITS = 9  # of shares that count as one
_HELD = 128  # gaits kept ready


@dataclass(frozen=True, eq=False)
class _Curves:
    """One gait's loop, cut at the library's shares.

    Attributes:
        spans: (stretches,) s.
        motion, effort: for every stretch (sections, TERMS, channels).
        place: for every stretch (sections, n, 3).
    """

    spans: Array
    motion: list[Array]
    effort: list[Array]
    place: list[Array]


class Family:
    """The gaits of a library, as one plan whose loop is written anew while it is walked.

    Args:
        folder: of the library.
        robot: that walks.

    Attributes:
        spec: the grid.
        base: the point that start and stop belong to.
        plan: start, two steps of the loop, and stop.
        stretch: (visits,) number of every visit's stretch, counted through the plan.
        loop: numbers of the loop's stretches: swing, double support, swing, double support.

    Raises:
        BadInput: the library is not finished, was edited, is another robot's, or has no start and stop.
    """

    def __init__(self, folder: Folder, robot: Robot) -> None:
        self._folder, self._robot = folder, robot
        self.spec, made_for = folder.spec()
        base, self._records = folder.whole()
        if made_for != robot.content_hash:
            valid = f"the robot that the library was planned for, {self.spec.robot} with hash {made_for[:12]}"
            raise BadInput("--library", robot.card.name, valid, "build it again for this one")
        if not base:
            raise BadInput("--library", str(folder.path), "a library with a start and a stop", "library show says why")
        self.base: Index = tuple(map(int, base.split("-")))
        gaits = [folder.gait(key, self._records[key]) for key in (START, base, STOP)]
        whole = walkable(gaits, robot, cycles=2)
        table = whole.table
        numbers = _stretches(table, list(range(len(table.sequence))))
        first, last = int(numbers[table.loop_first]), int(numbers[table.loop_end - 1])
        self.loop = tuple(range(first, last + 1))
        self._nodes, self._fit = chebyshev_fit(TERMS)
        self._cuts = self._shares()
        self._curves = lru_cache(_HELD)(self._load)
        self.plan, self.stretch = self._laid_out(whole, numbers)
        self._rows = [np.flatnonzero(self.stretch == number) for number in self.loop]
        at = {self.base: 1.0}
        for half in (0, 1):
            self.write(half, at, at)

    def _loop_of(self, point: Index) -> tuple[PlanTable, list[list[int]]]:
        """A gait's own table, and the sections of every stretch of its loop."""
        key = key_of(point)
        table = walkable([self._folder.gait(key, self._records[key])], self._robot).table
        visits = list(range(table.loop_first, table.loop_end))
        numbers = _stretches(table, visits)
        rows = [[int(table.sequence[v]) for v, n in zip(visits, numbers, strict=True) if n == k] for k in set(numbers)]
        return table, rows

    def _shares(self) -> list[Array]:
        """Where the stretches of the loop are cut: wherever one of the certified gaits at the grid's corners is."""
        found: list[set[float]] = [set() for _ in self.loop]
        ends = [sorted({0, len(axis) - 1}) for axis in self.spec.axes]
        corners = [point for point in itertools.product(*ends) if self.certified(point)]
        for point in dict.fromkeys([self.base, *corners]):
            table, rows = self._loop_of(point)
            for cuts, sections in zip(found, rows, strict=True):
                cuts |= set(np.round(_cumulative(table, sections), _DIGITS).tolist())
        return [np.array(sorted(cuts)) for cuts in found]

    def _load(self, point: Index) -> _Curves:
        """One gait, cut at the library's shares."""
        table, rows = self._loop_of(point)
        spans, motion, effort, place = list[float](), list[Array](), list[Array](), list[Array]()
        for cuts, sections in zip(self._cuts, rows, strict=True):
            ends = _cumulative(table, sections)
            spans.append(float(table.duration[sections].sum()))
            kinds: list[list[Array]] = [[], [], []]
            for low, high in itertools.pairwise(cuts.tolist()):
                shares = low + (high - low) * self._nodes
                of = min(int(np.searchsorted(ends, 0.5 * (low + high), side="right")) - 1, len(sections) - 1)
                local = (shares - ends[of]) / (ends[of + 1] - ends[of])
                basis = np.polynomial.chebyshev.chebvander(2.0 * local - 1.0, TERMS - 1)
                kinds[0].append(self._fit.T @ (basis @ table.motion[sections[of]]))
                kinds[1].append(self._fit.T @ (basis @ table.effort[sections[of]]))
                kinds[2].append(table.place[sections[of]])
            for kept, values in zip((motion, effort, place), kinds, strict=True):
                kept.append(np.array(values))
        return _Curves(np.array(spans), motion, effort, place)

    def _laid_out(self, whole: Plan, numbers: npt.NDArray[np.int64]) -> tuple[Plan, npt.NDArray[np.int64]]:
        """Start, loop and stop, the loop with a section for every cut; and every visit's stretch."""
        table = whole.table
        rows = [int(section) for section in table.sequence[: table.loop_first]]
        stretch = [int(number) for number in numbers[: table.loop_first]]
        for number, cuts in zip(self.loop, self._cuts, strict=True):
            sections = [int(table.sequence[v]) for v in np.flatnonzero(numbers == number)]
            ends = _cumulative(table, sections)
            for low, high in itertools.pairwise(cuts.tolist()):
                of = min(int(np.searchsorted(ends, 0.5 * (low + high), side="right")) - 1, len(sections) - 1)
                rows.append(sections[of])
                stretch.append(number)
        first, end = table.loop_first, len(rows)
        rows += [int(section) for section in table.sequence[table.loop_end :]]
        stretch += [int(number) for number in numbers[table.loop_end :]]
        columns = {name: np.ascontiguousarray(getattr(table, name)[rows]) for name in PlanTable._fields[4:]}
        made = PlanTable(np.arange(len(rows)), first, end, ENDLESS, **columns)
        plan = replace(whole, name="library", table=made, duration=np.inf)
        return plan, np.array(stretch)

    def certified(self, point: Index) -> bool:
        """Whether there is a gait at a point."""
        return self._records[key_of(point)].certified

    def coordinates(self, point: Index) -> dict[str, float]:
        """A point as gait inputs by name; an axis that the grid does not have is left out."""
        return {_NAMES[name]: value for name, value in self.spec.place(point).items()}

    def weights(self, inputs: dict[str, float]) -> Weights:
        """Weights of the gaits around a place, multilinear; they sum to 1.

        Raises:
            BadInput: the place is outside the grid, or a gait beside it could not be planned.
        """
        pairs = []
        for name, axis in zip(AXES, self.spec.axes, strict=True):
            low, high = axis[0], axis[-1]
            value = low if math.isnan(low) else inputs.get(_NAMES[name], low)
            if not math.isnan(low) and not low - 1e-9 <= value <= high + 1e-9:
                held = f"{low:g}" if len(axis) == 1 else f"{low:g} to {high:g}"
                raise BadInput(_NAMES[name], value, f"{held}, what the library holds")
            if len(axis) == 1:
                pairs.append([(0, 1.0)])
                continue
            k = min(max(int(np.searchsorted(axis, value, side="right")) - 1, 0), len(axis) - 2)
            share = min(max((value - axis[k]) / (axis[k + 1] - axis[k]), 0.0), 1.0)
            pairs.append([(k, 1.0 - share), (k + 1, share)])
        found: Weights = {}
        for chosen in itertools.product(*pairs):
            weight = float(np.prod([share for _, share in chosen]))
            if weight > 0.0:
                found[tuple(k for k, _ in chosen)] = weight
        for point in found:
            if not self.certified(point):
                shown = ", ".join(f"{name} {value:g}" for name, value in self.coordinates(point).items())
                remedy = "library show lists what there is"
                raise BadInput("speed", f"a place beside {shown}", "a place among gaits that could be planned", remedy)
        return found

    def write(self, half: int, before: Weights, after: Weights) -> None:
        """Write a step of the loop: its swing from the weights of the step before to its own, then double support.

        Args:
            half: 0 for the loop's first step, 1 for the second.
            before, after: weights that sum to 1.
        """
        for stretch, first in ((2 * half, before), (2 * half + 1, after)):
            self._write_stretch(stretch, first, after)

    def _write_stretch(self, stretch: int, before: Weights, after: Weights) -> None:
        points = [*dict.fromkeys([*before, *after])]
        curves = [self._curves(point) for point in points]
        first = np.array([before.get(point, 0.0) for point in points])
        last = np.array([after.get(point, 0.0) for point in points])
        spans = np.array([gait.spans[stretch] for gait in curves])
        began, ends = float(first @ spans), float(last @ spans)
        whole = 0.5 * (began + ends)
        cuts, table, rows = self._cuts[stretch], self.plan.table, self._rows[stretch]
        times = _when(cuts, whole / began, whole / ends)  # shares of the new stretch at which s passes the cuts
        motion = np.array([gait.motion[stretch] for gait in curves])
        effort = np.array([gait.effort[stretch] for gait in curves])
        place = np.einsum("k,ksij->sij", last, np.array([gait.place[stretch] for gait in curves]))
        for number, row in enumerate(rows):
            at = times[number] + (times[number + 1] - times[number]) * self._nodes
            s = _share(at, whole / began, whole / ends)
            local = (s - cuts[number]) / (cuts[number + 1] - cuts[number])
            basis = np.polynomial.chebyshev.chebvander(2.0 * local - 1.0, TERMS - 1)
            turn = at**3 * (10.0 - at * (15.0 - 6.0 * at))
            mixed = basis[None] * (first[:, None] + (last - first)[:, None] * turn)[:, :, None]
            table.motion[row] = self._fit.T @ np.einsum("knt,ktc->nc", mixed, motion[:, number])
            table.effort[row] = self._fit.T @ np.einsum("knt,ktc->nc", mixed, effort[:, number])
            table.place[row] = place[number]
        table.duration[rows] = whole * np.diff(times)
        table.stretch_start[rows] = whole * times[:-1]
        table.stretch_duration[rows] = whole


def _stretches(table: PlanTable, visits: list[int]) -> npt.NDArray[np.int64]:
    """Number of every visit's stretch."""
    bearing = table.contact[table.sequence[visits]] != NONE
    changes = np.any(bearing[1:] != bearing[:-1], axis=1)
    return np.concatenate([[0], np.cumsum(changes)]).astype(np.int64)


def _cumulative(table: PlanTable, sections: list[int]) -> Array:
    """Shares of a stretch at which its sections begin and end."""
    ends = np.concatenate([[0.0], np.cumsum(table.duration[sections])])
    return np.asarray(ends / ends[-1])


def _share(at: Array, first: float, last: float) -> Array:
    """The cubic s with s(0) = 0, s(1) = 1, and these rates at the ends."""
    a, b = first + last - 2.0, 3.0 - 2.0 * first - last
    return ((a * at + b) * at + first) * at


def _when(cuts: Array, first: float, last: float) -> Array:
    """Where that cubic takes on some values; it rises as long as both rates are below 3."""
    at = cuts.copy()
    a, b = first + last - 2.0, 3.0 - 2.0 * first - last
    for _ in range(30):
        at -= (_share(at, first, last) - cuts) / ((3.0 * a * at + 2.0 * b) * at + first)
    at[0], at[-1] = 0.0, 1.0
    return at
