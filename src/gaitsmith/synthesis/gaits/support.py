"""The support polygon: the hull of all contact points, and how far inside it the ZMP lies."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.motions.motion import Phase

Array = npt.NDArray[np.float64]


def contact_points(biped: Biped, phase: Phase) -> Array:
    """(N, 2) corners of both soles that touch the ground in a phase, world, m."""
    sole = biped.leg("left").sole
    ends = {"heel": (-sole.heel,), "toe": (sole.toe,), "flat": (-sole.heel, sole.toe), "air": ()}
    found = [
        (phase.foothold[0] + x, phase.foothold[1] + y)
        for x in (-sole.heel, sole.toe)
        for y in (-sole.half_width, sole.half_width)
    ]
    if phase.other is not None:
        found += [
            (phase.other[0] + x, phase.other[1] + y)
            for x in ends[phase.contact]
            for y in (-sole.half_width, sole.half_width)
        ]
    return np.array(found)


def hull(points: Array) -> Array:
    """(M, 2) corners of the convex hull, counterclockwise."""
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

    return np.array(chain(ordered) + chain(ordered[::-1]))


def zmp(phase: Phase, wrench: Array) -> Array:
    """(2, N) zero moment point of both contact wrenches (12, N) on the ground, world, m; eq. (12)."""
    places = {phase.support: phase.foothold, "left" if phase.support == "right" else "right": phase.other}
    force, mx, my = np.zeros(wrench.shape[1]), np.zeros(wrench.shape[1]), np.zeros(wrench.shape[1])
    for first, side in ((0, "left"), (6, "right")):
        place = places[side]
        if place is None:
            continue
        fz = wrench[first + 2]
        force += fz
        mx += wrench[first + 3] + place[1] * fz
        my += wrench[first + 4] - place[0] * fz
    return np.array([-my / force, mx / force])


def hull_margin(biped: Biped, phase: Phase, wrench: Array) -> float:
    """Smallest distance of the ZMP from the hull's edge, m; negative outside.

    The moment of a foot that turns about an edge is about its sole frame's origin, which has moved with the foot; that
    part is small and enters through the file's wrench.
    """
    corners = hull(contact_points(biped, phase))
    points = zmp(phase, wrench)
    edges = np.roll(corners, -1, axis=0) - corners
    normals = np.stack([-edges[:, 1], edges[:, 0]], axis=1) / np.linalg.norm(edges, axis=1)[:, None]
    inside = normals @ points - np.sum(normals * corners, axis=1)[:, None]
    return float(inside.min())
