"""The sole of a found foot: what touches the ground when the foot is put down flat, and a shape that the card knows."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from gaitsmith.adoption.anatomy import Anatomy, LegFound
from gaitsmith.adoption.refusals import Unfit
from gaitsmith.adoption.shapes import Shape

Array = NDArray[np.float64]

_FLAT = 0.004  # of hip height: what is this near to the ground stands on it
_POINT = 0.06  # of hip height: shorter is no sole
_LINE = 0.02  # of hip height: narrower is a line
_RECTANGLE = 0.97  # of its box's area
_CORNERS = 8  # of a polygon
_EQUAL = 1e-6  # of a polygon's area: corners that differ by less enclose the same
_DIGITS = 4  # of lengths in m
_TURN = 1e-3  # rad: a polygon's outline turns by more at a corner
_UPRIGHT = float(np.cos(np.radians(0.5)))
_DIRECTIONS, _ROUND = 24, 0.93  # of looking for a wheel: least reach of the largest
_SETTLING = 4  # rounds of putting the foot down


@dataclass(frozen=True, eq=False)
class SoleFound:
    """A sole in its frame: below the ankle, x forward and z up.

    Attributes:
        kind: `line`, `rectangle` or `polygon`.
        points: (n, 2) corners, counter-clockwise, m; the ends of a line.
        position: (3,) of the frame in the world at the zero pose, m.
        axes: (3, 3) of the frame in the world at the zero pose, as columns.
        source: what it was inferred from, in words.
        wide: width of the shapes that touch the ground where the sole is a line for want of an ankle roll joint, m.
    """

    kind: str
    points: Array
    body: int
    position: Array
    axes: Array
    source: str
    wide: float = 0.0

    @property
    def heel(self) -> float:
        """From the frame back, m."""
        return round(float(-self.points[:, 0].min()), _DIGITS)

    @property
    def toe(self) -> float:
        """From the frame forward, m."""
        return round(float(self.points[:, 0].max()), _DIGITS)

    @property
    def half_width(self) -> float:
        """To either side, m; 0 for a line."""
        return 0.0 if self.kind == "line" else round(float(self.points[:, 1].max()), _DIGITS)

    def entry(self) -> dict[str, object]:
        """The card's `sole`."""
        if self.kind == "polygon":
            return {"kind": "polygon", "points": [[float(v) for v in p] for p in _strict(self.points)]}
        return {"kind": self.kind, "heel": self.heel, "toe": self.toe} | (
            {"half_width": self.half_width} if self.kind == "rectangle" else {}
        )


@dataclass(frozen=True)
class GivenSole:
    """A sole that the user measured: from below the ankle, m."""

    heel: float
    toe: float
    half_width: float
    depth: float


def find_sole(leg: LegFound, anatomy: Anatomy, entry: str) -> SoleFound:
    """The sole of a leg whose foot has shapes.

    The foot is put down as its zero pose has it; if it then stands on a point or an edge, on the face of its hull that
    is next to it, below the ankle.

    Raises:
        BadInput: it touches the ground in a point.
    """
    size, up = anatomy.hip_height, anatomy.axes[:, 2]
    if _is_wheel(leg, anatomy):
        raise Unfit(entry, f"a {leg.name} foot that is round about its last joint, a wheel")
    touching, normal = _settled(leg.shapes, up, _FLAT * size)
    tilted = False
    length, width = _spread(touching, normal)
    if (length < _POINT * size or width < _LINE * size) and (face := _face(leg.shapes, leg.ankle, up)) is not None:
        other, other_normal = _settled(leg.shapes, face, _FLAT * size)
        spread = _spread(other, other_normal)
        if spread[0] >= _POINT * size and spread[1] > width + _FLAT * size:
            touching, normal, tilted, length = other, other_normal, True, spread[0]
    if length < _POINT * size:
        raise Unfit(entry, f"a {leg.name} foot that touches the ground in a point")
    axes = _frame(normal, anatomy.axes[:, 0])
    ground = float(np.mean(touching @ normal))
    below = leg.ankle + (ground - leg.ankle @ normal) * normal
    flat = (touching - below) @ axes[:, :2]
    corners = _hull(flat)
    source = f"{len(touching)} points of {_count(leg.shapes)} that touch the ground"
    source += " when the foot is put down flat" if tilted else " at the zero pose"
    kind, points, shift = _classified(corners, leg, _LINE * size)
    across = float(np.ptp(corners[:, 1]))
    wide = across if kind == "line" and across >= _LINE * size else 0.0
    return SoleFound(kind, points, leg.foot, below + axes[:, :2] @ shift, axes, source, wide)


def _is_wheel(leg: LegFound, anatomy: Anatomy) -> bool:
    """Whether the foot reaches as far from its last joint in every direction across the axis."""
    axis, centre = anatomy.data.xaxis[leg.joints[-1]], anatomy.data.xanchor[leg.joints[-1]]
    across = np.linalg.svd(axis[None])[2][1:]
    angles = np.linspace(0.0, 2.0 * np.pi, _DIRECTIONS, endpoint=False)
    reach = [
        max(shape.extent(direction)[1] for shape in leg.shapes) - centre @ direction
        for direction in np.cos(angles)[:, None] * across[0] + np.sin(angles)[:, None] * across[1]
    ]
    return bool(min(reach) > _ROUND * max(reach))


def measured_sole(leg: LegFound, anatomy: Anatomy, given: GivenSole) -> SoleFound:
    """The sole that the user gives, level at the zero pose."""
    position = leg.ankle - given.depth * anatomy.axes[:, 2]
    x, y = (-given.heel, given.toe), given.half_width
    kind = "rectangle" if y > 0.0 and leg.ankle_roll >= 0 else "line"
    width = y if kind == "rectangle" else 0.0
    points = np.array([[x[0], -width], [x[1], -width], [x[1], width], [x[0], width]])
    points = points if kind == "rectangle" else points[:2]
    return SoleFound(kind, points, leg.foot, position, anatomy.axes, "--sole")


def _count(shapes: tuple[Shape, ...]) -> str:
    return f"{len(shapes)} shape{'s' if len(shapes) > 1 else ''}"


def _settled(shapes: tuple[Shape, ...], up: Array, tolerance: float) -> tuple[Array, Array]:
    """Points that touch a plane next to a direction, and the plane's normal fitted to them."""
    normal = up
    for _ in range(_SETTLING):
        surface = np.vstack([shape.surface(-normal) for shape in shapes])
        heights = surface @ normal
        touching = surface[heights < heights.min() + tolerance]
        if _spread(touching, normal)[1] < 2.0 * tolerance:  # a line or a point says nothing of tilt
            return touching, normal
        centred = touching - touching.mean(axis=0)
        fitted: Array = np.linalg.svd(centred)[2][2]
        fitted = fitted * np.sign(fitted @ up)
        if fitted @ normal > 1.0 - 1e-12:
            break
        normal = fitted
    snapped = _upright(normal, up)
    return touching, snapped


def _upright(normal: Array, up: Array) -> Array:
    """Up, if a normal is within half a degree of it: what is left is the mesh's own roughness."""
    return up if normal @ up > _UPRIGHT else normal


def _spread(points: Array, normal: Array) -> tuple[float, float]:
    """Length and width of some points in a plane, m."""
    flat = points - np.outer(points @ normal, normal)
    flat = flat - flat.mean(axis=0)
    if len(points) < 2:
        return 0.0, 0.0
    axes = np.linalg.svd(flat, full_matrices=False)[2]
    sizes = sorted((float(np.ptp(flat @ axis)) for axis in axes), reverse=True)
    return sizes[0], sizes[1] if len(sizes) > 1 else 0.0


def _face(shapes: tuple[Shape, ...], ankle: Array, up: Array) -> Array | None:
    """Upward normal of the hull's largest face within 60 degrees of the ground, the ankle as one more point."""
    points = np.vstack([*(shape.surface(-up) for shape in shapes), ankle[None]])
    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):
        return None
    normals = -hull.equations[:, :3]
    corners = points[hull.simplices]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    downward = (normals @ up > 0.5) & ~(hull.simplices == len(points) - 1).any(axis=1)
    best, largest = None, 0.0
    for normal in normals[downward]:
        alike = downward & (normals @ normal > 0.9998)
        area = float(areas[alike].sum())
        if area > largest:
            best, largest = normals[alike].T @ areas[alike], area
    return None if best is None else best / np.linalg.norm(best)


def _frame(normal: Array, forward: Array) -> Array:
    """Columns x forward, y left, z along the normal."""
    ahead = forward - forward @ normal * normal
    ahead = ahead / np.linalg.norm(ahead)
    return np.column_stack([ahead, np.cross(normal, ahead), normal])


def _hull(flat: Array) -> Array:
    """(n, 2) corners of the convex hull, counter-clockwise; the two ends of points on a line."""
    try:
        corners: Array = flat[ConvexHull(flat).vertices]
        return corners
    except (QhullError, ValueError):
        along = flat - flat.mean(axis=0)
        axis = np.linalg.svd(along, full_matrices=False)[2][0]
        return flat[[int(np.argmin(along @ axis)), int(np.argmax(along @ axis))]]


def _strict(corners: Array) -> Array:
    """Corners as they are written, without those that rounding has put onto an edge or a neighbour."""
    rounded: Array = np.round(corners, _DIGITS) + 0.0
    while len(rounded) > 3:
        before, after = rounded - np.roll(rounded, 1, axis=0), np.roll(rounded, -1, axis=0) - rounded
        turns = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
        lengths = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
        least = int(np.argmin(turns / np.maximum(lengths, 1e-12)))
        if turns[least] > _TURN * lengths[least] > 0.0:
            break
        rounded = np.delete(rounded, least, axis=0)
    return rounded


def _area(corners: Array) -> float:
    x, y = corners.T
    return float(abs(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2.0


def _classified(corners: Array, leg: LegFound, narrow: float) -> tuple[str, Array, Array]:
    """Kind, points about the frame, and the frame's place in the plane from below the ankle."""
    (back, right), (front, left) = corners.min(axis=0), corners.max(axis=0)
    x = float(np.clip(0.0, back + 0.05 * (front - back), front - 0.05 * (front - back)))
    if leg.ankle_roll < 0 or left - right < narrow:
        middle = np.array([x, float(corners[:, 1].mean()) if left - right < narrow else (left + right) / 2.0])
        ends = np.array([[back - x, 0.0], [front - x, 0.0]])
        return "line", ends, middle
    box = (front - back) * (left - right)
    middle = np.array([x, (left + right) / 2.0])
    if _area(corners) >= _RECTANGLE * box:
        edges = np.array([[back, right], [front, right], [front, left], [back, left]])
        return "rectangle", edges - middle, middle
    outline = _thinned(corners) if leg.name != "right" else _mirrored(_thinned(_mirrored(corners)))
    ankle, centre = np.array([x, 0.0]), outline.mean(axis=0)
    steps = (ankle + share * (centre - ankle) for share in np.linspace(0.0, 1.0, 21))
    origin = next((step for step in steps if _inside(outline, step, 0.1 * (left - right))), centre)
    return "polygon", outline - origin, origin


def _inside(corners: Array, point: Array, margin: float) -> bool:
    """Whether a point is that far inside a convex outline, m."""
    edges = np.roll(corners, -1, axis=0) - corners
    away = edges[:, 0] * (point - corners)[:, 1] - edges[:, 1] * (point - corners)[:, 0]
    return bool((away >= margin * np.linalg.norm(edges, axis=1)).all())


def _thinned(corners: Array) -> Array:
    """At most eight corners, those that enclose most; of equal ones the first from the foremost on goes."""
    corners = np.roll(corners, -int(np.lexsort(np.round(corners.T[::-1], _DIGITS))[-1]), axis=0)
    share = _EQUAL * _area(corners)
    while len(corners) > _CORNERS:
        losses = np.array([_area(corners[[k - 1, k, (k + 1) % len(corners)]]) for k in range(len(corners))])
        corners = np.delete(corners, int(np.argmin(np.round(losses / share))), axis=0)
    return corners


def _mirrored(corners: Array) -> Array:
    """Left and right exchanged, counter-clockwise again."""
    exchanged: Array = (corners * [1.0, -1.0])[::-1]
    return exchanged


def rocking(soles: list[SoleFound]) -> list[str]:
    """What to note of feet that are wide although no joint lets them lie flat: at most one line."""
    width = max(sole.wide for sole in soles)
    words = "counts as a line along its middle, but will rock on its edges"
    return [f"a foot {100.0 * width:.2g} cm wide, without a roll joint below the knee, {words}"] if width else []


def matched(soles: list[SoleFound], narrow: float) -> list[SoleFound]:
    """Left and right soles as mirror images, if they differ by less than a length, m; else as they are."""
    left, right = soles
    mirrored = right.points * [1.0, -1.0]
    order = sorted(range(len(mirrored)), key=lambda k: (round(mirrored[k][0] / narrow), mirrored[k][1]))
    own = sorted(range(len(left.points)), key=lambda k: (round(left.points[k][0] / narrow), left.points[k][1]))
    alike = left.kind == right.kind and len(own) == len(order)
    if not alike or np.abs(left.points[own] - mirrored[order]).max() > narrow:
        return soles
    mean = left.points.copy()
    mean[own] = (left.points[own] + mirrored[order]) / 2.0
    turned = (mean * [1.0, -1.0])[::-1] if left.kind != "line" else mean
    return [replace(left, points=mean), replace(right, points=turned)]
