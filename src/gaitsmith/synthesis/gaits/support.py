"""The support polygon: the hull of all contact points, and how far inside it the ZMP lies."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.motions.motion import Phase, Side, about_vertical

Array = npt.NDArray[np.float64]


def contact_points(biped: Biped, phase: Phase) -> Array:
    """(N, 2) corners of both soles that touch the ground in a phase, world, m."""
    if phase.flies:
        return np.zeros((0, 2))
    found = [_placed(biped.corners(phase.support_contact, phase.support), phase.foothold, phase.heading)]
    if phase.other is not None:
        found.append(_placed(biped.corners(phase.contact, phase.other_foot), phase.other, phase.other_heading))
    return np.concatenate(found)


def _placed(corners: Array, place: tuple[float, float], heading: float) -> Array:
    """Points (N, 2) of a sole in the world."""
    return corners @ about_vertical(heading)[:2, :2].T + place


def hull(points: Array) -> Array:
    """(M, 2) corners of the convex hull, counterclockwise; none of nothing."""
    ordered = sorted(map(tuple, points.tolist()))

    def chain(items: list[tuple[float, ...]]) -> list[tuple[float, ...]]:
        found: list[tuple[float, ...]] = []
        for p in items:
            while len(found) > 1:
                (ax, ay), (bx, by) = found[-2], found[-1]
                if (bx - ax) * (p[1] - ay) - (by - ay) * (p[0] - ax) > 0.0:
                    break
                found.pop()
            found.append(p)
        return found[:-1]

    return np.array(chain(ordered) + chain(ordered[::-1])).reshape(-1, 2)


def zmp(phase: Phase, wrench: Array, moved: Array | None = None) -> Array:
    """(2, N) zero moment point of both contact wrenches (12, N) on the ground, world, m; eq. (12).

    ``moved``: (3, N) of the support sole's frame from its foothold, m; None where it stands still.
    """
    level = phase.straight
    force, mx, my = np.zeros(wrench.shape[1]), np.zeros(wrench.shape[1]), np.zeros(wrench.shape[1])
    feet: tuple[tuple[int, Side], ...] = ((0, "left"), (6, "right"))
    for first, side in feet:
        place = level.place(side)
        if place is None:
            continue
        fx, fy, fz = wrench[first : first + 3]
        x, y, z = np.zeros((3, 1)) if moved is None or side != phase.support else moved
        force += fz
        mx += wrench[first + 3] + (place[1] + y) * fz - z * fy
        my += wrench[first + 4] - (place[0] + x) * fz + z * fx
    point, origin = np.array([-my / force, mx / force]), np.array(phase.foothold)[:, None]
    return np.asarray(origin + about_vertical(phase.heading)[:2, :2] @ (point - origin)) if phase.heading else point


def inside(corners: Array, points: Array) -> Array:
    """(N,) distance of points (2, N) from the edge of a convex hull (M, 2), m; negative outside, NaN where none is."""
    if len(corners) == 0:
        return np.full(points.shape[1], np.nan)
    if len(corners) == 2:  # a line: its ends are its edge
        along = (corners[1] - corners[0]) / np.linalg.norm(corners[1] - corners[0])
        share, length = along @ (points - corners[0][:, None]), float(np.linalg.norm(corners[1] - corners[0]))
        return np.asarray(np.minimum(share, length - share))
    edges = np.roll(corners, -1, axis=0) - corners
    normals = np.stack([-edges[:, 1], edges[:, 0]], axis=1) / np.linalg.norm(edges, axis=1)[:, None]
    return np.asarray((normals @ points - np.sum(normals * corners, axis=1)[:, None]).min(axis=0))


def depths(biped: Biped, phases: Sequence[Phase], points: Array) -> Array:
    """(N,) how far points (N, 2) lie inside the support polygons of N phases, m; negative outside."""
    hulls = {phase: hull(contact_points(biped, phase)) for phase in dict.fromkeys(phases)}
    pairs = zip(phases, points, strict=True)
    return np.array([float(inside(hulls[phase], point[:, None])[0]) for phase, point in pairs])
