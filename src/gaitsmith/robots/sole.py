"""Shapes of soles about the sole frame (on the sole below the ankle, x forward, z up); m."""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from gaitsmith.robots.parameters import Finite, NonNegative, Parameters, Positive

Array = NDArray[np.float64]
_END = 0.05  # of a sole's length: corners so close to its extreme belong to the edge that it turns about


class Sole(Parameters):
    """Shape of a sole; heel, toe and half width of a polygon follow from its points.

    Attributes:
        kind: a line from `-heel` to `toe` along x, a rectangle that adds `±half_width` along y, or a convex polygon.
        heel: distance from the frame back to the heel.
        toe: distance from the frame forward to the toe.
        half_width: largest distance to either side; 0 for a line.
        points: (k, 2) corners of a polygon, counter-clockwise seen from above, around the frame's origin.
    """

    kind: Literal["line", "rectangle", "polygon"]
    heel: Positive
    toe: Positive
    half_width: NonNegative = 0.0
    points: Annotated[tuple[tuple[Finite, Finite], ...], Field(max_length=12)] = ()

    @model_validator(mode="before")
    @classmethod
    def _measured(cls, given: Any) -> Any:
        """A polygon with its extent."""
        if not isinstance(given, dict) or given.get("kind") != "polygon":
            return given
        try:
            corners = np.array(given.get("points", ()), dtype=np.float64)
        except (TypeError, ValueError):
            corners = np.zeros(0)
        if corners.ndim != 2 or corners.shape[1] != 2 or len(corners) < 3 or not np.isfinite(corners).all():
            raise ValueError("points of a polygon: 3 to 12 corners [x, y]")
        (x, y), sides = corners.T, np.roll(corners, -1, axis=0) - corners
        after = np.roll(sides, -1, axis=0)
        turns = np.arctan2(sides[:, 0] * after[:, 1] - sides[:, 1] * after[:, 0], np.sum(sides * after, axis=1))
        inside = corners[:, 0] * sides[:, 1] - corners[:, 1] * sides[:, 0] > 0.0
        if not (turns.min() > 0.0 and turns.sum() < 7.0 and inside.all()):
            raise ValueError("points of a convex polygon, counter-clockwise, around the sole frame's origin")
        size = {"heel": -float(x.min()), "toe": float(x.max()), "half_width": float(np.abs(y).max())}
        if any(given.get(name, value) != value for name, value in size.items()):
            raise ValueError("points alone for a polygon: heel, toe and half_width follow from them")
        return {**given, **size, "points": tuple(map(tuple, given["points"]))}

    @cached_property
    def corners(self) -> Array:
        """(k, 2) corners, counter-clockwise; of a line its ends."""
        if self.points:
            return np.array(self.points)
        back, front, w = -self.heel, self.toe, self.half_width
        return np.array([(back, -w), (front, -w), (front, w), (back, w)] if w > 0.0 else [(back, 0.0), (front, 0.0)])

    @cached_property
    def edges(self) -> Array:
        """(k, 3) unit normals outward, x and y, and distances of the edges from the origin; of a line its ends."""
        if self.half_width == 0.0:
            return np.array([(-1.0, 0.0, self.heel), (1.0, 0.0, self.toe)])
        sides = np.roll(self.corners, -1, axis=0) - self.corners
        normals = np.column_stack([sides[:, 1], -sides[:, 0]]) / np.linalg.norm(sides, axis=1, keepdims=True)
        return np.column_stack([normals, np.sum(normals * self.corners, axis=1)])

    @cached_property
    def ends(self) -> Array:
        """(2, 3) edges that the sole turns about, heel and toe: x, least and greatest y."""
        x, y = self.corners.T
        near = _END * (self.heel + self.toe)
        rows = ((-self.heel, y[x <= near - self.heel]), (self.toe, y[x >= self.toe - near]))
        return np.array([(at, found.min(), found.max()) for at, found in rows])

    def as_line(self) -> Sole:
        """The part of the sole along x: all that a leg without roll at the ankle can use."""
        if self.half_width == 0.0:
            return self
        x, _, distance = self.edges.T
        toe, heel = (float((distance[s * x > 0] / abs(x[s * x > 0])).min()) for s in (1, -1))
        return Sole(kind="line", heel=heel, toe=toe)
