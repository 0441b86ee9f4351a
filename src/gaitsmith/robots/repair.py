"""Inertias that no body can have, as exporters of URDF write them; each repair is a note."""

from __future__ import annotations

import mujoco
import numpy as np

ROUNDING = 1e-6  # a flat body has A + B = C
LEAST = 1e-3  # eigenvalue of an inertia, of its largest
MASSLESS = 1e-12  # of the robot's mass
POINT = 1e-6  # of a ball's inertia, below which a body has none
VIRTUAL = 1e-6  # of the robot's mass, given to a link that moves without mass
DENSITY = 1000.0  # kg/m³, of a ball that stands for a body without size


def repair_inertias(spec: mujoco.MjSpec, notes: list[str]) -> float:
    """Make inertias possible, and give links without mass and shape that move a little of both.

    Args:
        spec: of a URDF; changed in place.
        notes: names the links.

    Returns:
        Mass that was added, kg.
    """
    total = float(sum(body.mass for body in spec.bodies))
    bent, empty = [], []
    for body in spec.bodies:
        full = np.asarray(body.fullinertia, dtype=np.float64)
        if body.explicitinertial and body.mass > 0.0:
            xx, yy, zz, xy, xz, yz = full if np.isfinite(full).all() else (*body.inertia, 0.0, 0.0, 0.0)
            values, axes = np.linalg.eigh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
            ball = 0.4 * body.mass * (body.mass / DENSITY) ** (2.0 / 3.0)
            point = values[2] <= POINT * ball
            if values[0] > 0.0 and values[0] + values[1] >= (1.0 - ROUNDING) * values[2] and not point:
                continue
            values = np.full(3, ball) if point else np.clip(values, LEAST * values[2], None)
            values = values if values[0] + values[1] >= values[2] else np.full(3, values.mean())
            matrix = (axes * values) @ axes.T
            body.fullinertia = [*np.diag(matrix), matrix[0, 1], matrix[0, 2], matrix[1, 2]]
            bent.append(body.name)
        elif body.mass == 0.0 and not (body.joints and _carried(body) <= MASSLESS * total):
            body.fullinertia, body.inertia = np.full(6, np.nan), np.zeros(3)
        elif body.mass == 0.0 and (body.explicitinertial or not body.geoms) and body.parent.name != "world":
            body.mass, body.explicitinertial = VIRTUAL * total, True
            body.ipos, body.iquat = [0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]
            body.fullinertia = np.full(6, np.nan)
            body.inertia = [0.4 * body.mass * (total / DENSITY) ** (2.0 / 3.0)] * 3
            empty.append(body.name)
    if bent:
        notes.append(f"repaired inertias that no body can have: {', '.join(bent)}")
    if empty:
        notes.append(f"gave links that move without mass {VIRTUAL * total:.3g} kg: {', '.join(empty)}")
    return VIRTUAL * total * len(empty)


def _carried(body: mujoco.MjsBody) -> float:
    """Mass of a body and of what is fixed to it, kg."""
    return float(body.mass + sum(_carried(child) for child in body.bodies if not child.joints))
