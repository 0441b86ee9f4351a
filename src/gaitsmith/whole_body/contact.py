"""Bearing soles as rows: pivot, contact axes, wrench variables and their bounds (Han 2023, eq. 26 corrected).

A flat sole transmits a force and a moment. A line sole transmits no moment about its own line, a sole on its heel's or
toe's edge none about that edge; such a moment is left out of the variables. Forces and moments are written in the
contact frame, at the pivot: the sole frame's origin, or the middle of the edge.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import Cube, IntVector, Matrix, Vector, kernel
from gaitsmith.compiled.lanes import LANES, none, put
from gaitsmith.qp.quadratic_program import QuadraticProgram
from gaitsmith.whole_body.frames import Frames
from gaitsmith.whole_body.legs import Legs
from gaitsmith.whole_body.reference import FLAT, HEEL, NONE

_TWIST = 0.5  # share of what friction at both ends of an edge could bear as a yaw moment
_FACE = math.cos(math.pi / 8.0)  # distance of a face of the friction pyramid from its axis, its edges on the cone
FORCE_ROWS = 10  # of one sole, besides those of its ZMP: friction 8, yaw moment 2
WRENCH_SIZE = 6  # variables of one sole at most
ROLL_MOMENT, PITCH_MOMENT, YAW_MOMENT = 3, 4, 5  # axes of a wrench after the three of its force


class ContactBounds(NamedTuple):
    """Bounds on the wrench of one sole, as a kernel reads them; see :class:`ContactParameters`."""

    friction: float
    normal_low: float
    normal_high: float
    zmp_margin: float
    yaw_friction: float


class Contacts(NamedTuple):
    """Contacts of one tick; a row for each sole, of use where ``kind`` is not NONE.

    Attributes:
        kind: (n,) of this tick.
        pivot: (n, 3) world, m.
        axes: (n, 3, 3) contact frame to world.
        jacobian: (n, 6, nv) spatial, at the pivot.
        bias: (n, 6) at the pivot.
        half_edge: (n,) half the length of the edge that a sole stands on, m.
        first: (n,) number of its first variable.
    """

    kind: IntVector
    pivot: Matrix
    axes: Cube
    jacobian: Cube
    bias: Matrix
    half_edge: Vector
    first: IntVector


def make_contacts(nv: int, n_soles: int) -> Contacts:
    """Storage for a robot with ``nv`` degrees of freedom and ``n_soles`` soles."""
    n = n_soles
    return Contacts(
        kind=np.zeros(n, dtype=np.int64),
        pivot=np.zeros((n, 3)),
        axes=np.zeros((n, 3, 3)),
        jacobian=np.zeros((n, 6, nv)),
        bias=np.zeros((n, 6)),
        half_edge=np.zeros(n),
        first=np.zeros(n, dtype=np.int64),
    )


@kernel
def transmits(kind: int, half_width: float, axis: int) -> bool:
    """Whether a contact transmits a force or moment along an axis of its wrench."""
    if axis == ROLL_MOMENT:
        return half_width > 0.0
    if axis == PITCH_MOMENT:
        return kind == FLAT
    return kind != NONE


@kernel
def _levelled(sole: Matrix, kind: int, half_width: float, out: Matrix) -> None:
    """Contact axes: the sole's; turned level about the line or edge that the sole stands on."""
    for i in range(3):
        for j in range(3):
            out[i, j] = sole[i, j]
    if kind == FLAT and half_width > 0.0:
        return
    kept = 1 if kind != FLAT else 0  # the line or edge; the other horizontal axis is made level
    level = 1 - kept
    length = math.sqrt(sole[0, kept] ** 2 + sole[1, kept] ** 2)
    if length < 1e-6:
        return
    sign = 1.0 if kept == 0 else -1.0
    out[0, level], out[1, level], out[2, level] = -sign * sole[1, kept] / length, sign * sole[0, kept] / length, 0.0
    out[0, 2] = out[1, 0] * out[2, 1] - out[2, 0] * out[1, 1]
    out[1, 2] = out[2, 0] * out[0, 1] - out[0, 0] * out[2, 1]
    out[2, 2] = out[0, 0] * out[1, 1] - out[1, 0] * out[0, 1]


@kernel
def _at_pivot(frames: Frames, contacts: Contacts, leg: int) -> None:
    """Jacobian and bias of the sole's pivot, from those of its origin."""
    jacobian, bias, out = frames.sole_jacobian[leg], frames.sole_bias[leg], contacts.jacobian[leg]
    x = contacts.pivot[leg, 0] - frames.sole_position[leg, 0]
    y = contacts.pivot[leg, 1] - frames.sole_position[leg, 1]
    z = contacts.pivot[leg, 2] - frames.sole_position[leg, 2]
    for k in range(out.shape[1]):
        a, b, c = jacobian[3, k], jacobian[4, k], jacobian[5, k]
        out[0, k] = jacobian[0, k] + b * z - c * y
        out[1, k] = jacobian[1, k] + c * x - a * z
        out[2, k] = jacobian[2, k] + a * y - b * x
        out[3, k], out[4, k], out[5, k] = a, b, c
    p, q, r = frames.sole_twist[leg, 3], frames.sole_twist[leg, 4], frames.sole_twist[leg, 5]
    u, v, w = q * z - r * y, r * x - p * z, p * y - q * x
    a, b, c = bias[3], bias[4], bias[5]
    contacts.bias[leg, 0] = bias[0] + b * z - c * y + q * w - r * v
    contacts.bias[leg, 1] = bias[1] + c * x - a * z + r * u - p * w
    contacts.bias[leg, 2] = bias[2] + a * y - b * x + p * v - q * u
    contacts.bias[leg, 3], contacts.bias[leg, 4], contacts.bias[leg, 5] = a, b, c


@kernel
def observe_contacts(legs: Legs, frames: Frames, kinds: IntVector, contacts: Contacts) -> bool:
    """Fill ``contacts`` for the kinds of this tick; returns whether any kind is new."""
    changed = False
    for leg in range(kinds.shape[0]):
        kind = kinds[leg]
        changed = changed or contacts.kind[leg] != kind
        contacts.kind[leg] = kind
        if kind == NONE:
            continue
        along = across = 0.0
        if kind != FLAT:
            end = legs.end[leg, 0 if kind == HEEL else 1]
            along, across = end[0], 0.5 * (end[1] + end[2])
            contacts.half_edge[leg] = 0.5 * (end[2] - end[1])
        for i in range(3):
            contacts.pivot[leg, i] = frames.sole_position[leg, i] + along * frames.sole_rotation[leg, i, 0]
            contacts.pivot[leg, i] += across * frames.sole_rotation[leg, i, 1]
        _levelled(frames.sole_rotation[leg], kind, legs.half_width[leg], contacts.axes[leg])
        _at_pivot(frames, contacts, leg)
    return changed


@kernel
def _new_row(qp: QuadraticProgram, m: int, first: int, end: int) -> int:
    """Clear row ``m`` and make it ``row · x ≥ 0``; the caller fills coefficients from ``first`` to before ``end``."""
    if qp.span[m, 0] == first and qp.span[m, 1] == end and end - first <= LANES:  # zero elsewhere, by its span
        put(qp.rows, m, first // LANES * LANES, none())
        put(qp.rows, m, (end - 1) // LANES * LANES, none())
    else:
        for j in range(qp.rows.shape[1]):
            qp.rows[m, j] = 0.0
    qp.row_lower[m], qp.row_upper[m] = 0.0, math.inf
    qp.span[m, 0], qp.span[m, 1] = first, end
    return m + 1


@kernel
def _share_rows(qp: QuadraticProgram, m: int, first: int, end: int, variable: int, reach: float) -> int:
    """``|x[variable]| ≤ reach f_z``."""
    for sign in (-1.0, 1.0):
        m = _new_row(qp, m, first, end)
        qp.rows[m - 1, first + 2], qp.rows[m - 1, variable] = reach, sign
    return m


@kernel
def _friction_rows(qp: QuadraticProgram, m: int, first: int, end: int, friction: float) -> int:
    """The horizontal force inside a pyramid of eight faces whose edges lie on the cone of friction."""
    for x in (-1.0, 0.0, 1.0):
        for y in (-1.0, 0.0, 1.0):
            if x == 0.0 and y == 0.0:
                continue
            m = _new_row(qp, m, first, end)
            face = qp.rows[m - 1]
            face[first], face[first + 1] = x, y
            face[first + 2] = friction * _FACE * math.sqrt(x * x + y * y)
    return m


@kernel
def contact_bounds(
    qp: QuadraticProgram, contacts: Contacts, legs: Legs, bounds: ContactBounds, leg: int, row: int
) -> int:
    """Friction cone by eight faces, ZMP (eq. 26) and yaw moment of one sole; returns the next free row.

    In the contact frame the ZMP is at ``x = -m_y / f_z`` and ``y = m_x / f_z`` from the pivot; it keeps the margin from
    every edge of a flat sole. An edge bears the yaw moment that friction at its ends does.
    """
    m, first, kind = row, contacts.first[leg], contacts.kind[leg]
    normal, yaw, roll, pitch = first + 2, first + 3, 0, 0
    if transmits(kind, legs.half_width[leg], ROLL_MOMENT):
        roll, yaw = yaw, yaw + 1
    if transmits(kind, legs.half_width[leg], PITCH_MOMENT):
        pitch, yaw = yaw, yaw + 1
    end = yaw + 1
    qp.lower[normal], qp.upper[normal] = bounds.normal_low, bounds.normal_high
    m = _friction_rows(qp, m, first, end, bounds.friction)
    twist = bounds.yaw_friction
    if kind != FLAT and roll > 0:
        twist = min(twist, _TWIST * bounds.friction * contacts.half_edge[leg])
        m = _share_rows(qp, m, first, end, roll, max(contacts.half_edge[leg] - bounds.zmp_margin, 0.0))
    for k in range(legs.edges[leg] if kind == FLAT else 0):
        edge = legs.edge[leg, k]
        m = _new_row(qp, m, first, end)
        qp.rows[m - 1, normal] = max(edge[2] - bounds.zmp_margin, 0.0)
        if pitch > 0:
            qp.rows[m - 1, pitch] = edge[0]
        if roll > 0:
            qp.rows[m - 1, roll] = -edge[1]
    return _share_rows(qp, m, first, end, yaw, twist)
