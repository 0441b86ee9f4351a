"""Sole wrenches as variables of the whole-body QP, and their bounds (Han 2023, eq. 26 and its corrections).

Forces and moments are written in the contact frame, at the sole frame's origin. A line sole transmits no moment
about its own axis; that variable is left out.
"""

from __future__ import annotations

import math

from gaitsmith.compiled import kernel
from gaitsmith.qp.quadratic_program import QuadraticProgram
from gaitsmith.whole_body.frames import Legs
from gaitsmith.whole_body.targets import TaskGains

CONTACT_ROWS = 10  # of one sole: friction 4, ZMP along 2, ZMP across 2, yaw moment 2


@kernel
def wrench_size(half_width: float) -> int:
    """Number of wrench variables of a sole: a line sole has no moment about its axis."""
    return 6 if half_width > 0.0 else 5


@kernel
def moment_axis(half_width: float, index: int) -> int:
    """Axis of the ``index``-th moment variable."""
    return index if half_width > 0.0 else index + 1


@kernel
def _new_row(qp: QuadraticProgram, m: int) -> int:
    """Clear row ``m`` and make it ``row · x ≥ 0``; the caller fills the coefficients."""
    for j in range(qp.rows.shape[1]):
        qp.rows[m, j] = 0.0
    qp.row_lower[m] = 0.0
    qp.row_upper[m] = math.inf
    return m + 1


@kernel
def contact_bounds(qp: QuadraticProgram, legs: Legs, gains: TaskGains, leg: int, first: int, row: int) -> int:
    """Friction pyramid, ZMP (eq. 26) and yaw moment of one sole; returns the next free row.

    In the contact frame the ZMP is at ``x = -m_y / f_z`` and ``y = m_x / f_z``.
    """
    m = row
    qp.lower[first + 2] = gains.normal_low
    qp.upper[first + 2] = gains.normal_high
    for axis in range(2):
        for sign in (-1.0, 1.0):
            m = _new_row(qp, m)
            qp.rows[m - 1, first + 2] = gains.friction
            qp.rows[m - 1, first + axis] = sign
    size = wrench_size(legs.half_width[leg])
    pitch = first + size - 2
    yaw = first + size - 1
    m = _new_row(qp, m)
    qp.rows[m - 1, first + 2] = max(legs.toe[leg] - gains.zmp_margin, 0.0)
    qp.rows[m - 1, pitch] = 1.0
    m = _new_row(qp, m)
    qp.rows[m - 1, first + 2] = max(legs.heel[leg] - gains.zmp_margin, 0.0)
    qp.rows[m - 1, pitch] = -1.0
    for sign in (-1.0, 1.0):
        m = _new_row(qp, m)
        qp.rows[m - 1, first + 2] = gains.yaw_friction
        qp.rows[m - 1, yaw] = sign
    if size == 6:
        for sign in (-1.0, 1.0):
            m = _new_row(qp, m)
            qp.rows[m - 1, first + 2] = max(legs.half_width[leg] - gains.zmp_margin, 0.0)
            qp.rows[m - 1, first + 3] = sign
    return m
