"""Ground that is known ahead: a map of heights, or a list of footholds; asked at every step."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.files import read_bounded, reason

if TYPE_CHECKING:
    from gaitsmith.control import Controller
    from gaitsmith.robots import Robot
    from gaitsmith.robots.sole import Sole
    from gaitsmith.simulation.scenario import Scenario
    from gaitsmith.simulation.terrain import Terrain
    from gaitsmith.simulation.truth import Truth

Array = npt.NDArray[np.float64]
_EVERY = 5  # ticks between two looks
_LEVEL = 0.1  # of the sole's length: ground that is no rougher bears all of it
_FAR = 0.5  # of the leg: a listed foothold farther from where the walk wants to step is none
_ROOM = 0.05  # of the sole's length, before and behind it that is to bear too: it may land so much off
_BESIDE = 0.25  # of the sole's length, before and behind it: no higher ground there, which the foot would touch
_CLEAR = 0.5, 0.5  # of a climb, and of a drop, that the sole is lifted higher
_EDGE = 0.1  # of the sole's length, from its ends: between them it bears the walk as well as at its middle
_MISSED, _TURNED = 4.0, 3.0  # cost of a place that the sole cannot bear, and of another one than before, per m moved
_COLUMNS = 3  # x, y, z
_WIDE = 2.0  # of the sole's length: a longer way of the swing foot costs as much as a place that cannot bear
_FREE = 0.3  # of the period: so long after its swing began a sole may be sent to any other place
_LARGEST = 1_000_000  # bytes of a file of footholds


class Landing(NamedTuple):
    """Where to land, world frame, m.

    Attributes:
        place: (2,) of the sole frame.
        height: of the ground there.
        highest: of the ground on the way there.
    """

    place: Array
    height: float
    highest: float


class Source(Protocol):
    """What knows the ground: a map, a list, a camera's module."""

    def landing(
        self, sole: Sole, start: Array, wanted: Array, yaw: float, before: Array | None = None
    ) -> Landing | None:
        """Where the swing sole is to land; None where nothing is known.

        Args:
            sole: its shape.
            start: (3,) where its swing began, world, m.
            wanted: (2,) where the walk would put it, world, m.
            yaw: heading, rad.
            before: (2,) what was answered last for the same step, world, m; None as long as any other place will do.
        """


class Heights(Protocol):
    """Ground as a height over x and y."""

    def heights(self, x: Array, y: Array) -> Array:
        """(n,) heights at (n,) places, world frame, m; NaN where unknown."""


@dataclass(frozen=True)
class HeightMap:
    """Heights on a grid; between its points that of the nearest one.

    Attributes:
        origin: (x, y) of the first cell's centre, world, m.
        cell: size of the square cells, m.
        values: (i, j) heights, along x and y, m; NaN where unknown.
    """

    origin: tuple[float, float]
    cell: float
    values: Array

    def __post_init__(self) -> None:
        if self.cell <= 0.0 or self.values.ndim != 2 or not self.values.size:
            raise BadInput("height map", self.values.shape, "a grid of heights with cells of more than 0 m")

    def heights(self, x: Array, y: Array) -> Array:
        """Heights at places, NaN beside the map."""
        i = np.rint((x - self.origin[0]) / self.cell).astype(np.int64)
        j = np.rint((y - self.origin[1]) / self.cell).astype(np.int64)
        inside = (i >= 0) & (i < self.values.shape[0]) & (j >= 0) & (j < self.values.shape[1])
        found = np.full(len(x), np.nan)
        found[inside] = self.values[i[inside], j[inside]]
        return found


@dataclass(frozen=True)
class MappedGround:
    """Lands where all of the sole has even ground below it, as near to where the walk would step as there is such.

    A sole that is moved along itself bears where it would have been (:func:`gaitsmith.template.ground.stand_on`): that
    costs no balance as far as the sole reaches there.

    Attributes:
        ground: its heights.
    """

    ground: Heights

    def landing(
        self, sole: Sole, start: Array, wanted: Array, yaw: float, before: Array | None = None
    ) -> Landing | None:
        """The ground below the sole: a line along it where it is even, else what the sole meets first."""
        ahead = np.array([math.cos(yaw), math.sin(yaw)])
        found = self._below(sole, wanted[None], ahead)
        if found is None:
            return None
        (height,), (rough,) = found
        place, length = wanted, sole.heel + sole.toe
        if rough > _LEVEL * length:
            moved = np.linspace(-1.0, 1.0, 41) * length
            below = self._below(sole, wanted + moved[:, None] * ahead, ahead)
            if below is not None and (even := below[1] <= _LEVEL * length).any():
                bears = np.clip(-moved, _EDGE * length - sole.heel, sole.toe - _EDGE * length)
                cost = np.abs(moved) + _MISSED * np.abs(moved + bears)
                way = wanted + moved[:, None] * ahead - start[:2]
                cost += _MISSED * np.maximum(np.linalg.norm(way, axis=1) - _WIDE * length, 0.0)
                if before is not None:
                    cost += _TURNED * np.abs(moved - (before - wanted) @ ahead)
                best = int(np.argmin(np.where(even, cost, np.inf)))
                place, height = wanted + moved[best] * ahead, below[0][best]
        passed = start[:2] + np.linspace(0.0, 1.0, 9)[:, None] * (place - start[:2])
        between = self.ground.heights(*passed.T)
        if np.isnan(between).any():
            return None
        highest = max(float(between.max()), float(height))
        climb, drop = (max(float(by), 0.0) for by in (height - between.min(), between.max() - height))
        return Landing(place, float(height), highest + _CLEAR[0] * climb + _CLEAR[1] * drop)

    def _below(self, sole: Sole, places: Array, ahead: Array) -> tuple[Array, Array] | None:
        """Height of the ground below a sole at (n, 2) places, and how uneven it is, (n,) m; None if unknown."""
        length, aside = sole.heel + sole.toe, np.array([-ahead[1], ahead[0]])
        along = np.linspace(-sole.heel - _ROOM * length, sole.toe + _ROOM * length, 7)
        along = np.array([-sole.heel - _BESIDE * length, *along, sole.toe + _BESIDE * length])
        sides = (0.0,) if sole.half_width == 0.0 else (-sole.half_width, sole.half_width)
        parts = np.array([x * ahead + y * aside for y in sides for x in along])
        under = self.ground.heights(*(places[:, None] + parts).reshape(-1, 2).T).reshape(len(places), -1)
        if np.isnan(under).any():
            return None
        x, bears = np.tile(along, len(sides)), np.tile(np.arange(len(along)) % (len(along) - 1) > 0, len(sides))
        slope, level = np.polyfit(x[bears], under[:, bears].T, 1)
        beyond = under - level[:, None] - slope[:, None] * x
        rough = np.maximum(np.ptp(beyond[:, bears], axis=1), beyond[:, ~bears].max(axis=1))
        under = under[:, bears]
        return np.where(rough <= _LEVEL * length, level, under.max(axis=1)), rough


@dataclass(frozen=True)
class FootholdList:
    """Lands on the listed foothold that is nearest to where the walk would step.

    Attributes:
        points: (n, 3) world, m.
        farthest: from there, m.
    """

    points: Array
    farthest: float

    def landing(
        self, sole: Sole, start: Array, wanted: Array, yaw: float, before: Array | None = None
    ) -> Landing | None:
        """The nearest one, None if it is too far."""
        away = np.linalg.norm(self.points[:, :2] - wanted, axis=1)
        nearest = int(np.argmin(away))
        if away[nearest] > self.farthest:
            return None
        x, y, z = self.points[nearest]
        return Landing(np.array([x, y]), float(z), max(float(z), float(start[2])))


def read_footholds(path: str | Path, leg: float) -> FootholdList:
    """Footholds from a text file with x, y and z in every line, separated by commas; ``#`` begins a remark.

    Args:
        path: of the file.
        leg: length of the legs, m.

    Raises:
        BadInput: no such file, or a line that is no foothold.
    """
    try:
        text = read_bounded(path, _LARGEST).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise BadInput("footholds", str(path), "terrain, or a readable file of footholds", reason(error)) from None
    rows = []
    for number, line in enumerate(text.splitlines(), start=1):
        if not (entry := line.partition("#")[0].strip()):
            continue
        try:
            row = [float(word) for word in entry.split(",")]
        except ValueError:
            row = []
        if len(row) != _COLUMNS or not all(abs(value) < 1e3 for value in row):
            raise BadInput(f"{path}: line {number}", entry, "x, y, z of a foothold in m, separated by commas")
        rows.append(row)
    if not rows:
        raise BadInput("footholds", str(path), "at least one foothold: a line with x, y, z")
    return FootholdList(np.array(rows), _FAR * leg)


def source_of(scenario: Scenario, terrain: Terrain, robot: Robot) -> Source | None:
    """What a scenario's walk knows of the ground; None if nothing.

    Raises:
        BadInput: the file of footholds is none.
    """
    if not scenario.footholds:
        return None
    if scenario.footholds == "terrain":
        return MappedGround(terrain)
    return read_footholds(scenario.footholds, robot.card.gait_limits.height[1])


class Guided:
    """Tells the controller of the ground at its next landing: an observer.

    Args:
        source: that knows the ground.
        controller: that walks.
        truth: of the robot: a camera sees where its soles are.

    Attributes:
        told, blind: looks at which the source knew the ground, and at which it did not.
    """

    def __init__(self, source: Source, controller: Controller, truth: Truth) -> None:
        self._source, self._controller, self._truth = source, controller, truth
        self._soles = [leg.sole for leg in controller.robot.legs]
        self.told = self.blind = 0
        self._place: Array | None = None
        self._swing, self._start = -1, np.zeros(3)

    def observe(self, tick: int) -> bool:
        """Look, every few ticks of a walk."""
        if tick % _EVERY or self._controller.state != "walking":
            return False
        stance, swing, planned = self._controller.planned_landing
        yaw, soles = float(self._truth.attitude[2]), self._truth.sole.reshape(-1, 3)
        c, s = math.cos(yaw), math.sin(yaw)
        turn = np.array([[c, -s], [s, c]])
        bearing = soles[stance]
        wanted = bearing[:2] + turn @ planned
        if swing != self._swing:
            self._swing, self._start, self._place = swing, soles[swing].copy(), None
        found = self._source.landing(self._soles[swing], self._start, wanted, yaw, self._place)
        free = self._controller.telemetry.step_time[0] < _FREE * self._controller.gait.period
        self._place = None if found is None or free else found.place
        if found is None:
            self.blind += 1
            return False
        self.told += 1
        shift = turn.T @ (found.place - wanted)
        level = float(bearing[2])
        self._controller.see(shift, found.height - level, found.highest - level)
        return False

    @property
    def warnings(self) -> tuple[str, ...]:
        """That the ground was not known everywhere."""
        if not self.blind:
            return ()
        return (f"footholds: no ground known at {self.blind} of {self.told + self.blind} looks; it felt its way there",)

    def hear(self, event: Mapping[str, Any]) -> None:
        """Nothing to note."""
