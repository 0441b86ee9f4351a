"""A phase's numbers, and what a motion may bound or fix of them, as docs/synthesis.md states it.

The numbers may be NumPy arrays (instants) or Taylor models (all times of a stretch): only sums and products occur.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.motions.motion import Phase
from gaitsmith.synthesis.motions.quantities import QUANTITIES, of_joint


@dataclass(frozen=True, eq=False)
class Measured:
    """A phase's motion and forces, of any kind of number, in the world of :attr:`Phase.straight`.

    Attributes:
        q, v, a, torque, rate: [joint] rad, rad/s, rad/s², N·m, N·m/s.
        moving: [joint] whether it moves.
        force, moment: [3] on the support sole, about its frame's origin, N and N·m.
        push, turn: [3] on the other sole, about the point that it turns about (its origin if flat).
        pivot: [3] that point, m.
        rotation, torso: [3, 3] of the other sole and of the torso.
        hip: height of the hips' midpoint, m.
        ankle, ankle_velocity: [3] origin of the body that carries the other sole, m, m/s.
        own: [3] the support sole's frame, m; level: [3, 3] its rotation.
        body: [3] the torso's frame, m.
        centre: gives the centre of mass [3], m, and its velocity [3], m/s.
        profile: of (lifts, lands): the height that the swing sole has to have, from 0 to 1.
    """

    q: Any
    v: Any
    a: Any
    torque: Any
    rate: Any
    moving: Any
    force: Any
    moment: Any
    push: Any
    turn: Any
    pivot: Any
    rotation: Any
    torso: Any
    hip: Any
    ankle: Any
    ankle_velocity: Any
    own: Any
    level: Any
    body: Any
    centre: Callable[[], tuple[Any, Any]]
    profile: Callable[[bool, bool], Any]


def along_sole(vector: Any, heading: float) -> tuple[Any, Any, Any]:
    """A vector in the axes of a sole that is turned by ``heading``, rad, about the vertical."""
    cos, sin = float(np.cos(heading)), float(np.sin(heading))
    return vector[0] * cos + vector[1] * sin, vector[1] * cos - vector[0] * sin, vector[2]


def about_toe(found: Measured, biped: Biped, phase: Phase) -> tuple[Any, Any, Any]:
    """(3,) moment on the support sole about the middle of its toe's edge, world axes, N·m: M - r × F."""
    x, right, left = biped.sole(phase.support).ends[1]
    rx, ry, rz = (found.level[k, 0] * x + found.level[k, 1] * (0.5 * (right + left)) for k in range(3))
    fx, fy, fz = (found.force[k] for k in range(3))
    mx, my, mz = (found.moment[k] for k in range(3))
    return mx - ry * fz + rz * fy, my - rz * fx + rx * fz, mz - rx * fy + ry * fx


def own_heights(found: Measured, biped: Biped, phase: Phase) -> list[Any]:
    """Heights of the support sole's corners above the ground under it, m."""
    row, above = found.level[2], found.own[2] - phase.height
    return [above + row[0] * x + row[1] * y for x, y in biped.corners("flat", phase.support).tolist()]


def corner_heights(found: Measured, biped: Biped, phase: Phase) -> list[Any]:
    """Heights of the other sole's corners above the ground under it, m."""
    centre = biped.pivot(phase)
    corners = biped.corners("flat", phase.other_foot).tolist()
    row = found.rotation[2]
    return [
        found.pivot[2] - phase.other_height + row[0] * (x - float(centre[0])) + row[1] * (y - float(centre[1]))
        for x, y in corners
    ]


def quantity(found: Measured, biped: Biped, phase: Phase, name: str) -> Any:
    """A quantity of a joint, or of :data:`QUANTITIES` in the world of :attr:`Phase.straight`, of angles the sine."""
    joint = of_joint(name)
    if joint is not None:
        rows = {"angle": found.q, "velocity": found.v, "acceleration": found.a, "torque": found.torque}[joint[1]]
        return rows[biped.robot.joint_names.index(joint[0])]
    part, axis, _ = QUANTITIES[name]
    if part in ("foot", "torso"):
        rotation = found.rotation if part == "foot" else found.torso
        return (rotation[2, 1], -rotation[2, 0], rotation[1, 0])[axis]
    if part == "hip":
        return found.hip
    if part == "support":
        return found.own[2]
    if part in ("centre", "centre velocity"):
        return found.centre()[part == "centre velocity"][axis]
    if part == "body":
        return found.body[axis]
    if part in ("ankle", "ankle velocity"):
        return (found.ankle if part == "ankle" else found.ankle_velocity)[axis]
    sole = biped.sole(phase.other_foot)
    x, y, _ = (float(value) for value in biped.pivot(phase))
    ahead = {"sole": 0.0, "toe": sole.toe, "heel": -sole.heel}[part] - x
    return found.pivot[axis] + found.rotation[axis, 0] * ahead - found.rotation[axis, 1] * y
