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
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.library.folder import Folder, end_keys
from gaitsmith.library.spec import Index, key_of, point_of
from gaitsmith.planned import Plan, PlanTable
from gaitsmith.planned.table import COM, ENDLESS, PER_SOLE, SOLES, TERMS
from gaitsmith.robots import Robot
from gaitsmith.splines.polynomial import chebyshev_fit
from gaitsmith.synthesis.gaits.walkable import walkable
from gaitsmith.whole_body.reference import NONE

Array = npt.NDArray[np.float64]
Weights = dict[Index, float]
_NAMES = {"speed": "speed", "step_height": "lift", "period": "period", "yaw_rate": "yaw_rate"}
"""What a gait input is called along each axis; the slope is the ground's."""
_DIGITS = 9  # of shares that count as one
_HELD, _BOUNDING = 128, 16  # gaits kept ready, and before they are cut


class _Stretch(NamedTuple):
    """One stretch of a gait, cut at the library's shares.

    Attributes:
        span: s.
        motion, effort: (sections, TERMS, channels).
        place: (sections, n, 4).
    """

    span: float
    motion: Array
    effort: Array
    place: Array


class Family:
    """The gaits of a library, as one plan whose loop is written anew while it is walked.

    Args:
        folder: of the library.
        robot: that walks.
        slope: of the ground, degrees, for a library that has slopes.

    Attributes:
        spec: the grid.
        base: the point that start and stop belong to.
        rest: weights of the gaits for that step on this ground.
        plan: start, two steps of the loop, and stop.
        stretch: (visits,) number of every visit's stretch, counted through the plan.
        loop: numbers of the loop's stretches: swing, double support, swing, double support.

    Raises:
        BadInput: the library is not finished, was edited, is another robot's, has no start and stop, or none for the
            slope.
    """

    def __init__(self, folder: Folder, robot: Robot, slope: float = 0.0) -> None:
        self._folder, self._robot = folder, robot
        self.spec, made_for = folder.spec()
        base, self._records = folder.whole()
        if made_for != robot.content_hash:
            valid = f"the robot that the library was planned for, {self.spec.robot} with hash {made_for[:12]}"
            raise BadInput("--library", robot.card.name, valid, "build it again for this one")
        if not base:
            raise BadInput("--library", str(folder.path), "a library with a start and a stop", "library show says why")
        self.base = point_of(base)
        self.rest = self._on_ground(slope)
        wholes = [self._whole(point) for point in self.rest]
        numbers = _stretches(wholes[0].table, list(range(len(wholes[0].table.sequence))))
        first, last = (int(numbers[visit]) for visit in (wholes[0].table.loop_first, wholes[0].table.loop_end - 1))
        self.loop = tuple(range(first, last + 1))
        self._nodes, self._fit = chebyshev_fit(TERMS)
        rows = [_rows(whole.table, 0, len(whole.table.sequence)) for whole in wholes]
        self._loops = lru_cache(_BOUNDING)(self._loop_of)
        self._cuts = self._shares(wholes, rows)
        self._curves = lru_cache(_HELD)(self._load)
        self.plan, self.stretch = self._laid_out(wholes, numbers)
        self._rows = [np.flatnonzero(self.stretch == number) for number in range(len(self._cuts))]
        if len(wholes) > 1:
            shares = np.array([*self.rest.values()])
            for number in set(range(len(self._cuts))) - set(self.loop):
                self._mix(number, [self._cut(w.table, r[number], number) for w, r in zip(wholes, rows, strict=True)],
                          shares, shares)  # fmt: skip
        for half in (0, 1):
            self.write(half, self.rest, self.rest)

    def _on_ground(self, slope: float) -> Weights:
        """Weights of the base's gaits on the slopes around one; they have starts and stops.

        Raises:
            BadInput: naming the terrain, where the library has none.
        """
        axis = self.spec.slope
        if not axis:
            return {self.base: 1.0}
        found = {(*self.base[:-1], k): share for k, share in _between(axis, slope, "terrain", "ramp:DEG of ")}
        for point in found:
            if not all(key in self._records and self._records[key].certified for key in end_keys(self.spec, point)):
                valid = f"slopes with a start and a stop, unlike {axis[point[-1]]:g} degrees"
                raise BadInput("terrain", f"ramp:{slope:g}", valid, "library show says why")
        return found

    def _whole(self, point: Index) -> Plan:
        """Start, two steps of a point's gait, and stop."""
        start, stop = end_keys(self.spec, point)
        gaits = [self._folder.gait(key, self._records[key]) for key in (start, key_of(point), stop)]
        return walkable(gaits, self._robot, cycles=2)

    def _loop_of(self, point: Index) -> tuple[PlanTable, list[list[int]]]:
        """A gait's own table, and the sections of every stretch of its loop."""
        key = key_of(point)
        table = walkable([self._folder.gait(key, self._records[key])], self._robot).table
        return table, _rows(table, table.loop_first, table.loop_end)

    def _shares(self, wholes: list[Plan], rows: list[list[list[int]]]) -> list[Array]:
        """Where every stretch is cut: wherever a gait is of the walk's beginning and of the ends of the axes."""
        found: list[set[float]] = [set() for _ in rows[0]]
        for whole, stretches in zip(wholes, rows, strict=True):
            for cuts, sections in zip(found, stretches, strict=True):
                cuts |= set(np.round(_cumulative(whole.table, sections), _DIGITS).tolist())
        bounding = [*self.rest]
        for n, axis in enumerate(self.spec.axes):
            bounding += [(*self.base[:n], k, *self.base[n + 1 :]) for k in (0, len(axis) - 1)]
        for point in dict.fromkeys(bounding):
            if self.certified(point):
                table, stretches = self._loops(point)
                for number, sections in zip(self.loop, stretches, strict=True):
                    found[number] |= set(np.round(_cumulative(table, sections), _DIGITS).tolist())
        return [np.array(sorted(cuts)) for cuts in found]

    def _load(self, point: Index) -> list[_Stretch]:
        """One gait's loop, cut at the library's shares."""
        table, rows = self._loops(point)
        return [self._cut(table, sections, number) for number, sections in zip(self.loop, rows, strict=True)]

    def _cut(self, table: PlanTable, sections: list[int], number: int) -> _Stretch:
        """Sections that make up a stretch, cut at the library's shares."""
        ends = _cumulative(table, sections)
        motion, effort, place = list[Array](), list[Array](), list[Array]()
        for low, high in itertools.pairwise(self._cuts[number].tolist()):
            shares = low + (high - low) * self._nodes
            of = _section(ends, low, high)
            local = (shares - ends[of]) / (ends[of + 1] - ends[of])
            basis = np.polynomial.chebyshev.chebvander(2.0 * local - 1.0, TERMS - 1)
            motion.append(self._fit.T @ (basis @ table.motion[sections[of]]))
            effort.append(self._fit.T @ (basis @ table.effort[sections[of]]))
            place.append(table.place[sections[of]])
        span = float(table.duration[sections].sum())
        return _Stretch(span, np.array(motion), np.array(effort), np.array(place))

    def _laid_out(self, wholes: list[Plan], numbers: npt.NDArray[np.int64]) -> tuple[Plan, npt.NDArray[np.int64]]:
        """Start, loop and stop of the first with a section for every cut; and every visit's stretch."""
        table = wholes[0].table
        rows, stretch = list[int](), list[int]()
        for number, cuts in enumerate(self._cuts):
            sections = [int(table.sequence[v]) for v in np.flatnonzero(numbers == number)]
            ends = _cumulative(table, sections)
            rows += [sections[_section(ends, low, high)] for low, high in itertools.pairwise(cuts.tolist())]
            stretch += [number] * (len(cuts) - 1)
        first, end = stretch.index(self.loop[0]), len(stretch) - stretch[::-1].index(self.loop[-1])
        columns = {name: np.ascontiguousarray(getattr(table, name)[rows]) for name in PlanTable._fields[4:]}
        made = PlanTable(np.arange(len(rows)), first, end, ENDLESS, **columns)
        shares = [*self.rest.values()]
        q, v = (np.average([whole.start[k] for whole in wholes], axis=0, weights=shares) for k in (0, 1))
        q[3:7] /= np.linalg.norm(q[3:7])
        plan = replace(wholes[0], name="library", table=made, duration=np.inf, start=(q, v))
        return plan, np.array(stretch)

    def certified(self, point: Index) -> bool:
        """Whether there is a gait at a point."""
        return self._records[key_of(point)].certified

    def coordinates(self, point: Index) -> dict[str, float]:
        """A point as gait inputs by name."""
        return {_NAMES[name]: value for name, value in self.spec.place(point).items() if name in _NAMES}

    def weights(self, inputs: dict[str, float]) -> Weights:
        """Weights of the gaits around a place, multilinear; they sum to 1.

        Raises:
            BadInput: the place is outside the grid, or a gait beside it could not be planned.
        """
        pairs = []
        for name, axis in zip(self.spec.names, self.spec.axes, strict=True):
            if name == "slope":
                pairs.append([(point[-1], share) for point, share in self.rest.items()])
            else:
                own = _NAMES[name]
                pairs.append(_between(axis, inputs.get(own, axis[0]), own))
        found: Weights = {}
        for chosen in itertools.product(*pairs):
            weight = float(np.prod([share for _, share in chosen]))
            if weight > 0.0:
                found[tuple(k for k, _ in chosen)] = weight
        for point in found:
            if not self.certified(point):
                shown = ", ".join(f"{name} {value:g}" for name, value in self.spec.place(point).items())
                remedy = "library show lists what there is"
                raise BadInput("speed", f"a place beside {shown}", "a place among gaits that could be planned", remedy)
        return found

    def write(self, half: int, before: Weights, after: Weights) -> None:
        """Write a step of the loop: its swing from the weights of the step before to its own, then double support.

        Args:
            half: 0 for the loop's first step, 1 for the second.
            before, after: weights that sum to 1.
        """
        points = [*dict.fromkeys([*before, *after])]
        curves = [self._curves(point) for point in points]
        last = np.array([after.get(point, 0.0) for point in points])
        for k, weights in ((2 * half, before), (2 * half + 1, after)):
            first = np.array([weights.get(point, 0.0) for point in points])
            self._mix(self.loop[k], [gait[k] for gait in curves], first, last)

    def _mix(self, number: int, gaits: list[_Stretch], first: Array, last: Array) -> None:
        """Write a stretch, from the weights (gaits,) at its beginning to those at its end."""
        spans = np.array([gait.span for gait in gaits])
        began, ends = float(first @ spans), float(last @ spans)
        whole = 0.5 * (began + ends)
        cuts, table, rows = self._cuts[number], self.plan.table, self._rows[number]
        times = _when(cuts, whole / began, whole / ends)  # shares of the new stretch at which s passes the cuts
        motion = np.array([gait.motion for gait in gaits])
        effort = np.array([gait.effort for gait in gaits])
        place = np.einsum("k,ksij->sij", last, np.array([gait.place for gait in gaits]))
        bore, soles = table.support[rows[0]], table.contact.shape[1]
        for k, row in enumerate(rows):
            at = times[k] + (times[k + 1] - times[k]) * self._nodes
            s = _share(at, whole / began, whole / ends)
            local = (s - cuts[k]) / (cuts[k + 1] - cuts[k])
            basis = np.polynomial.chebyshev.chebvander(2.0 * local - 1.0, TERMS - 1)
            mixed = basis[None] * (first[:, None] + (last - first)[:, None] * _smooth(at))[:, :, None]
            values = np.einsum("knt,ktc->knc", mixed, motion[:, k])
            bears = table.support[row]
            if bears != bore and np.any(headings := [-gait.place[k, bore, 3] for gait in gaits]):
                before = table.support[rows] == bore
                change = float(times[1 + np.flatnonzero(before)[-1]])
                _turn(values, soles, headings - last @ headings, 1.0 - _smooth((at - change) / (1.0 - change)))
                place[k, bore] = _seen_back(place[int(np.flatnonzero(before)[-1]), bears])
            table.motion[row] = self._fit.T @ values.sum(axis=0)
            table.effort[row] = self._fit.T @ np.einsum("knt,ktc->nc", mixed, effort[:, k])
            table.place[row] = place[k]
        table.duration[rows] = whole * np.diff(times)
        table.stretch_start[rows] = whole * times[:-1]
        table.stretch_duration[rows] = whole


def _between(axis: tuple[float, ...], value: float, name: str, kind: str = "") -> list[tuple[int, float]]:
    """Numbers and weights of the values of an axis around one.

    Raises:
        BadInput: naming the axis, for a value outside of it.
    """
    low, high = axis[0], axis[-1]
    if not low - 1e-9 <= value <= high + 1e-9:
        held = f"{low:g}" if len(axis) == 1 else f"{low:g} to {high:g}"
        raise BadInput(name, f"{value:g} degrees" if kind else value, f"{kind}{held}, what the library holds")
    if len(axis) == 1:
        return [(0, 1.0)]
    k = min(max(int(np.searchsorted(axis, value, side="right")) - 1, 0), len(axis) - 2)
    share = min(max((value - axis[k]) / (axis[k + 1] - axis[k]), 0.0), 1.0)
    return [(number, weight) for number, weight in ((k, 1.0 - share), (k + 1, share)) if weight > 0.0]


def _turn(values: Array, soles: int, angle: Array, share: Array) -> None:
    """Turn the places of the CoM and the soles, (gaits, nodes, channels), by a share (nodes,) of an angle a gait, rad.

    Gaits that turn by different angles agree on where they are as seen from the sole that bore, not from the one that
    will: what they say about the latter is turned to their mean, and less and less.
    """
    cos, sin = np.cos(np.outer(angle, share)), np.sin(np.outer(angle, share))
    for first in (COM, *(SOLES + PER_SOLE * row for row in range(soles))):
        x, y = values[:, :, first].copy(), values[:, :, first + 1].copy()
        values[:, :, first], values[:, :, first + 1] = cos * x - sin * y, sin * x + cos * y


def _seen_back(place: Array) -> Array:
    """Where a sole stands, seen from one that it sees at a place (x, y, z, heading)."""
    x, y, z, heading = place
    cos, sin = math.cos(heading), math.sin(heading)
    return np.array([-cos * x - sin * y, sin * x - cos * y, -z, -heading])


def _rows(table: PlanTable, first: int, end: int) -> list[list[int]]:
    """Sections of every stretch among some visits."""
    visits = list(range(first, end))
    numbers = _stretches(table, visits)
    return [[int(table.sequence[v]) for v, n in zip(visits, numbers, strict=True) if n == k] for k in set(numbers)]


def _section(ends: Array, low: float, high: float) -> int:
    """Which of the sections that end at some shares holds a cut."""
    return min(int(np.searchsorted(ends, 0.5 * (low + high), side="right")) - 1, len(ends) - 2)


def _smooth(at: Array) -> Array:
    """From 0 to 1 without rate or acceleration at the ends."""
    return at**3 * (10.0 - at * (15.0 - 6.0 * at))


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
