"""Ground under the robot: flat, slopes, random boxes, stairs, ice; described as plain blocks for the physics engine."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from gaitsmith.documents import nearest
from gaitsmith.errors import BadInput

Array = npt.NDArray[np.float64]
VALID = (
    "flat, slope:DEGREES, ramp:DEGREES or cross:DEGREES (-30 to 30), boxes:METRES (0 to 0.3), "
    "stairs:RISE,TREAD,EDGE,COUNT, or ice:FRICTION,FROM,LENGTH (0.05 to 5, from 0.3 m ahead on)"
)
_ONE = {
    **dict.fromkeys(("slope", "ramp", "cross"), "DEGREES, -30 to 30"),
    "boxes": "METRES, 0 to 0.3",
    "ice": "FRICTION,FROM,LENGTH: 0.05 to 5, 0.3 to 50 m ahead, above 0 up to 50 m",
    "stairs": "RISE,TREAD,EDGE,COUNT: -0.5 to 0.5 m and not 0, 0.05 to 2 m, -10 to 10 m, 1 to 100 steps",
}
SLOPE_START = 0.6  # m ahead of the origin: the start stance is level
BOX_PITCH = 0.3
FLAT_RADIUS = 1.05  # m: boxes whose centre is nearer than this to the origin have no height
_FIELD = 200  # cells each way: heights are drawn for all of them, so they don't depend on the region asked for
_FAR = 5.0  # m of level ground before and behind stairs, and beside them
_SUNK = 0.05  # m of every box below the plane


class Region(NamedTuple):
    """Where ground is needed, world frame, m: (lowest, highest) of x and of y."""

    x: tuple[float, float] = (-3.0, 10.0)
    y: tuple[float, float] = (-2.0, 2.0)


class Block(NamedTuple):
    """A box of ground, world frame, m and rad: centre, half extents, rotation about y (nose down) or about x; friction.

    The friction is the ground's own if None.
    """

    centre: tuple[float, float, float]
    half_size: tuple[float, float, float]
    pitch: float = 0.0
    roll: float = 0.0
    friction: float | None = None


@dataclass(frozen=True)
class Terrain:
    """One kind of ground.

    Attributes:
        kind: ``flat``; ``slope``, level until 0.6 m ahead of the origin and then inclined about y; ``ramp``, inclined
            everywhere, through the origin; ``boxes``, a grid of 0.3 m pitch with heights drawn evenly from 0 to
            ``amount``, level within about 1 m of the origin; ``stairs`` up from z = 0, or down to it; ``cross``, level
            until 0.6 m ahead and then inclined about x; ``ice``, flat with a patch across the path that has a friction
            of its own.
        amount: inclination in degrees (uphill, or left side up, positive), largest box height in m, how much higher
            every tread is than the one before, m, negative for stairs that lead down, or friction of the ice; 0 for
            flat ground.
        seed: seed of the box heights.
        tread, edge, count: of stairs: from one edge to the next, where the first one is, m, and how many there are.
        patch: where ice begins and how long it is, m ahead of the origin.
    """

    kind: Literal["flat", "slope", "ramp", "cross", "boxes", "stairs", "ice"] = "flat"
    amount: float = 0.0
    seed: int = 0
    tread: float = 0.2
    edge: float = 0.12
    count: int = 0
    patch: tuple[float, float] = (0.0, 0.0)

    def height(self, x: float, y: float) -> float:
        """Height of the ground at a point of the world, m; on an edge between boxes, of either."""
        return float(self.heights(np.array([x]), np.array([y]))[0])

    def heights(self, x: Array, y: Array) -> Array:
        """Heights at (n,) places, m."""
        if self.kind == "slope":
            return np.asarray(np.maximum(x - SLOPE_START, 0.0) * math.tan(math.radians(self.amount)))
        if self.kind == "ramp":
            return np.asarray(x * math.tan(math.radians(self.amount)))
        if self.kind == "cross":
            return np.where(x > SLOPE_START, y * math.tan(math.radians(self.amount)), 0.0)
        if self.kind == "boxes":
            i, j = (np.rint(places / BOX_PITCH).astype(np.int64) for places in (x, y))
            level = (np.hypot(i, j) * BOX_PITCH <= FLAT_RADIUS) | (np.maximum(abs(i), abs(j)) > _FIELD)
            cells = (np.clip(index, -_FIELD, _FIELD) + _FIELD for index in (i, j))
            return np.asarray(np.where(level, 0.0, _field(self.amount, self.seed)[tuple(cells)]))
        if self.kind == "stairs":
            number = np.clip(np.floor((x - self.edge) / self.tread) + 1, 0, self.count)
            return np.asarray(self.amount * number + max(-self.amount * self.count, 0.0))
        return np.zeros(len(x))

    def _tread_height(self, number: int) -> float:
        """Of the level ground before the stairs (0), or of a tread; the lowest one is in the plane."""
        return self.amount * number + max(-self.amount * self.count, 0.0)

    def blocks(self, region: Region) -> list[Block]:
        """Boxes of ground that cover ``region``, besides the level plane; none farther than 60 m from the origin."""
        if self.kind == "slope":
            return _slope_blocks(math.radians(self.amount), region)
        if self.kind == "ramp":
            return [_ramp_block(math.radians(self.amount), region)]
        if self.kind == "cross":
            return _cross_blocks(math.radians(self.amount), region)
        if self.kind == "ice":
            return _ice_blocks(self.amount, *self.patch, region)
        if self.kind == "boxes":
            return self._box_blocks(region)
        if self.kind == "stairs":
            return self._tread_blocks(region)
        return []

    def _box_blocks(self, region: Region) -> list[Block]:
        """Boxes standing in the plane z = 0, a cell each; a height depends on the seed and its cell only."""
        x, y = (BOX_PITCH * grid.ravel() for grid in np.meshgrid(_cells(*region.x), _cells(*region.y), indexing="ij"))
        edge, found = BOX_PITCH / 2, []
        for place in zip(x.tolist(), y.tolist(), self.heights(x, y).tolist(), strict=True):
            half = (place[2] + _SUNK) / 2
            found += [Block((*place[:2], place[2] - half), (edge, edge, half))] if place[2] > 0.0 else []
        return found

    def _tread_blocks(self, region: Region) -> list[Block]:
        """One box a tread that is above the plane, from edge to edge; the first and the last reach far."""
        edges = [self.edge + k * self.tread for k in range(self.count)]
        begins = [min(region.x[0], self.edge) - _FAR, *edges]
        ends = [*edges, max(region.x[1], edges[-1]) + _FAR]
        breadth, found = max(-region.y[0], region.y[1], _FAR), []
        for number, (begin, end) in enumerate(zip(begins, ends, strict=True)):
            height = self._tread_height(number)
            if height > 0.0:
                middle, half = (begin + end) / 2, (height + _SUNK) / 2
                found.append(Block((middle, 0.0, height - half), ((end - begin) / 2, breadth, half)))
        return found


def parse_terrain(text: str, seed: int = 0) -> Terrain:
    """Terrain named as :data:`VALID` says.

    Raises:
        BadInput: unknown kind, or a number missing, not finite, or out of range.
    """
    kind, _, number = text.partition(":")
    if text == "flat":
        return Terrain()
    if kind == "stairs":
        return _parsed_stairs(text, number)
    try:
        amount, *patch = map(float, number.split(","))
    except ValueError:
        amount, patch = math.nan, []
    if kind == "ice" and len(patch) == 2 and 0.05 <= amount <= 5.0 and 0.3 <= patch[0] <= 50.0 and 0 < patch[1] <= 50.0:
        return Terrain("ice", amount, patch=(patch[0], patch[1]))
    amount = math.nan if patch else amount
    if kind == "cross" and abs(amount) <= 30.0:
        return Terrain("cross", amount)
    if kind == "slope" and abs(amount) <= 30.0:
        return Terrain("slope", amount)
    if kind == "ramp" and abs(amount) <= 30.0:
        return Terrain("ramp", amount)
    if kind == "boxes" and 0.0 <= amount <= 0.3:
        return Terrain("boxes", amount, seed)
    if kind in _ONE:
        raise BadInput("terrain", text, f"{kind}:{_ONE[kind]}")
    raise BadInput("terrain", text, VALID, nearest(kind, _ONE))


def _parsed_stairs(text: str, numbers: str) -> Terrain:
    try:
        rise, tread, edge, count = (float(part) for part in numbers.split(","))
    except ValueError:
        rise = tread = edge = count = math.nan
    sound = 0.0 < abs(rise) <= 0.5 and 0.05 <= tread <= 2.0 and abs(edge) <= 10.0 and count in range(1, 101)
    if not sound:
        raise BadInput("terrain", text, f"stairs:{_ONE['stairs']}")
    return Terrain("stairs", rise, tread=tread, edge=edge, count=int(count))


def _slope_blocks(angle: float, region: Region) -> list[Block]:
    """Level block and inclined block whose top faces meet exactly at x = SLOPE_START, z = 0."""
    back, ahead = max(-region.x[0], 5.0), max(region.x[1] - SLOPE_START, 5.0) / math.cos(angle)
    breadth = max(-region.y[0], region.y[1], 5.0)
    depth = 1.0
    level = Block(((SLOPE_START - back) / 2, 0.0, -depth / 2), ((SLOPE_START + back) / 2, breadth, depth / 2))
    along, up = (math.cos(angle), math.sin(angle)), (-math.sin(angle), math.cos(angle))
    half = ahead / 2
    centre = (SLOPE_START + half * along[0] - depth / 2 * up[0], 0.0, half * along[1] - depth / 2 * up[1])
    return [level, Block(centre, (half, breadth, depth / 2), -angle)]


def _ramp_block(angle: float, region: Region) -> Block:
    """Ground turned about the y axis, whose top contains that axis."""
    back, ahead, breadth = _bounds(region)
    centre = ((back + ahead) / 2 * math.cos(angle) + 0.5 * math.sin(angle), 0.0)
    height = (back + ahead) / 2 * math.sin(angle) - 0.5 * math.cos(angle)
    return Block((*centre, height), ((ahead - back) / 2 / math.cos(angle), breadth, 0.5), -angle)


def _level(first: float, last: float, breadth: float, friction: float | None = None) -> Block:
    """Level ground from one x to another, its top at z = 0."""
    return Block(((first + last) / 2, 0.0, -0.5), ((last - first) / 2, breadth, 0.5), friction=friction)


def _bounds(region: Region) -> tuple[float, float, float]:
    """Least and greatest x, and greatest |y|, with room."""
    return min(region.x[0], -5.0), max(region.x[1], SLOPE_START + 5.0), max(-region.y[0], region.y[1], 5.0)


def _cross_blocks(angle: float, region: Region) -> list[Block]:
    """Level start, then ground turned about the x axis, whose top contains that axis."""
    back, ahead, breadth = _bounds(region)
    centre = ((SLOPE_START + ahead) / 2, 0.5 * math.sin(angle), -0.5 * math.cos(angle))
    tilted = Block(centre, ((ahead - SLOPE_START) / 2, breadth / math.cos(angle), 0.5), roll=angle)
    return [_level(back, SLOPE_START, breadth), tilted]


def _ice_blocks(friction: float, first: float, length: float, region: Region) -> list[Block]:
    """Level ground, a patch of ice across it, and level ground."""
    back, ahead, breadth = _bounds(region)
    end = first + length
    return [
        _level(back, first, breadth),
        _level(first, end, breadth, friction),
        _level(end, max(ahead, end + 5.0), breadth),
    ]


def _cells(low: float, high: float) -> range:
    """Indices of the cells that cover an interval, within the drawn field."""
    return range(max(math.floor(low / BOX_PITCH), -_FIELD), min(math.ceil(high / BOX_PITCH), _FIELD) + 1)


@lru_cache(maxsize=4)
def _field(height: float, seed: int) -> Array:
    """Drawn heights of all cells."""
    return np.random.default_rng([seed, 0xB0]).uniform(0.0, height, (2 * _FIELD + 1, 2 * _FIELD + 1))
