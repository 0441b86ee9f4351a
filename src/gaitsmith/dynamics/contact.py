"""Geometry of the soles: where they are, what ground they span, and how far the ZMP is from its edge."""

from __future__ import annotations

import numpy as np

from gaitsmith.compiled import Matrix, Vector, kernel
from gaitsmith.dynamics.tree import Tree, TreeState


@kernel
def sole_pose(
    tree: Tree,
    state: TreeState,
    body: int,
    position: Vector,
    rotation: Matrix,
    position_out: Vector,
    rotation_out: Matrix,
) -> None:
    """Pose of a sole frame in the world; any frame fixed to a body works.

    Args:
        tree: the tree.
        state: filled by :func:`gaitsmith.dynamics.update_dynamics`.
        body: number of the body that carries the sole.
        position: (3,) origin of the sole frame in body axes, m.
        rotation: (3, 3) sole axes to body axes.
        position_out: (3,) receives the origin in the world, m.
        rotation_out: (3, 3) receives sole axes to world.
    """
    r = state.body_rotation
    for i in range(3):
        a, b, c = r[body, i, 0], r[body, i, 1], r[body, i, 2]
        position_out[i] = state.body_position[body, i] + a * position[0] + b * position[1] + c * position[2]
        for j in range(3):
            rotation_out[i, j] = a * rotation[0, j] + b * rotation[1, j] + c * rotation[2, j]


def sole_corners(heel: float, toe: float, half_width: float = 0.0) -> Matrix:
    """Corners of a sole in its own frame, (2, 3) for a line sole or (4, 3) for a rectangle, m.

    Args:
        heel: distance from the origin back to the edge.
        toe: distance from the origin forward to the edge.
        half_width: distance to either side; 0 for a line sole.
    """
    sides = (-half_width, half_width) if half_width > 0.0 else (0.0,)
    return np.array([[x, y, 0.0] for x in (-heel, toe) for y in sides])


def support_polygon(corners: Matrix) -> Matrix:
    """Convex hull of all corners in contact, seen from above.

    Args:
        corners: (n, 2) or (n, 3) points in the world, m; the height is ignored.

    Returns:
        (k, 2) vertices, counterclockwise, without points inside an edge; k is 1 or 2 for a point or a line.
    """
    points = np.unique(np.asarray(corners, dtype=np.float64)[:, :2], axis=0)
    if len(points) < 3:
        return points
    halves = []
    for ordered in (points, points[::-1]):
        half: list[Vector] = []
        for point in ordered:
            while len(half) > 1 and _turn(half[-2], half[-1], point) <= 0.0:
                half.pop()
            half.append(point)
        halves.append(half[:-1])
    return np.array(halves[0] + halves[1])


def _turn(a: Vector, b: Vector, c: Vector) -> float:
    """Twice the signed area of a triangle: positive if a, b, c run counterclockwise."""
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def zmp_margin(polygon: Matrix, zmp: Vector) -> float:
    """Distance from the ZMP to the support polygon's edge, m: positive inside, negative outside.

    Args:
        polygon: (k, 2) vertices from :func:`support_polygon`, m.
        zmp: (2,) zero-moment point on the ground, m.

    Returns:
        The distance; 0 at best if the polygon is a line or a point.
    """
    inside = len(polygon) > 2
    nearest = np.inf
    for start, end in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        edge = end - start
        length = float(edge @ edge)
        share = float(np.clip((zmp - start) @ edge / length, 0.0, 1.0)) if length > 0.0 else 0.0
        nearest = min(nearest, float(np.linalg.norm(zmp - start - share * edge)))
        inside = inside and _turn(start, end, zmp) >= 0.0
    return nearest if inside else -nearest
