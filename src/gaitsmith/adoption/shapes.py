"""Colliding shapes as points with a radius: enough to know what touches the ground from any side."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
_RIM = 24  # points of a cylinder's rim
_BALL = 200  # points of an ellipsoid


@dataclass(frozen=True, eq=False)
class Shape:
    """Points in the world with one radius: the shape's hull is that of the balls around them.

    Attributes:
        points: (n, 3), m.
        radius: m.
    """

    points: Array
    radius: float
    body: int

    def extent(self, direction: Array) -> tuple[float, float]:
        """Lowest and highest place along a unit direction, m."""
        along = self.points @ direction
        return float(along.min()) - self.radius, float(along.max()) + self.radius

    def surface(self, direction: Array) -> Array:
        """(n, 3) the points moved to the shape's surface in a unit direction."""
        return self.points + self.radius * direction


def colliding(model: mujoco.MjModel, data: mujoco.MjData, bodies: Iterable[int]) -> tuple[Shape, ...]:
    """Shapes of some bodies that can touch anything, placed as in `data`."""
    paired = {int(g) for g in (*model.pair_geom1, *model.pair_geom2)}
    found = []
    for body in bodies:
        first = int(model.body_geomadr[body])
        for geom in range(first, first + int(model.body_geomnum[body])):
            if not (model.geom_contype[geom] or model.geom_conaffinity[geom] or geom in paired):
                continue
            local = _points(model, geom)
            if local is not None:
                world = data.geom_xpos[geom] + local[0] @ data.geom_xmat[geom].reshape(3, 3).T
                found.append(Shape(world, local[1], int(body)))
    return tuple(found)


def lowest(shapes: Sequence[Shape], absent: ArrayLike = (0.0, 0.0, np.inf)) -> Array:
    """(3,) the lowest point of some shapes; another if there are none."""
    down = np.array([0.0, 0.0, -1.0])
    points = [shape.surface(down) for shape in shapes]
    if not points:
        return np.asarray(absent, dtype=np.float64)
    stacked = np.vstack(points)
    found: Array = stacked[int(np.argmin(stacked[:, 2]))]
    return found


def _points(model: mujoco.MjModel, geom: int) -> tuple[Array, float] | None:
    """Points in the shape's own frame, and their radius; None for what has no hull."""
    kind, size = int(model.geom_type[geom]), model.geom_size[geom]
    signs = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
        return np.zeros((1, 3)), float(size[0])
    if kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
        return np.array([[0.0, 0.0, -size[1]], [0.0, 0.0, size[1]]]), float(size[0])
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        return signs * size, 0.0
    if kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
        angles = np.linspace(0.0, 2.0 * np.pi, _RIM, endpoint=False)
        rim = np.column_stack([size[0] * np.cos(angles), size[0] * np.sin(angles)])
        return np.vstack([np.column_stack([rim, np.full(_RIM, z)]) for z in (-size[1], size[1])]), 0.0
    if kind == mujoco.mjtGeom.mjGEOM_ELLIPSOID:
        k = np.arange(_BALL) + 0.5
        polar, around = np.arccos(1.0 - 2.0 * k / _BALL), np.pi * (1.0 + np.sqrt(5.0)) * k
        ball = np.column_stack([np.cos(around) * np.sin(polar), np.sin(around) * np.sin(polar), np.cos(polar)])
        return ball * size, 0.0
    if kind == mujoco.mjtGeom.mjGEOM_MESH and model.geom_dataid[geom] >= 0:
        mesh = int(model.geom_dataid[geom])
        first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        return model.mesh_vert[first : first + count].astype(np.float64), 0.0
    return None
