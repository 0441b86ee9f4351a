"""Motors that do not give the torque they are told to: named by what the robot's velocity misses.

Over a window of ticks the change of velocity is compared with the accelerations that the whole-body solutions predict.
What is missing is put down to one motor after the other, as if it gave nothing, with the standing soles held where they
are: ``δq̈ = -P M⁻¹ Sᵀ τ_j``, P = 1 - M⁻¹Jᵀ (J M⁻¹ Jᵀ)⁻¹ J. A motor is named if it explains most of it; a push or an
impact moves all joints at once, and no single motor explains that.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import IntVector, Matrix, Vector, kernel
from gaitsmith.whole_body.contact import WRENCH_SIZE, Contacts, transmits
from gaitsmith.whole_body.forward_dynamics import Motion
from gaitsmith.whole_body.frames import Body
from gaitsmith.whole_body.problem import WholeBody
from gaitsmith.whole_body.reference import NONE

_WINDOW = 0.1  # 1/ω
_KEEP = 0.5  # of the windows before
_EXPLAINED = 0.75  # of what is missing, by one motor, from which it is named
_LEAST, _MOST = 0.4, 1.6  # of its torque that is missing then
_GOOD = 0.2  # below which it is good again
_TORQUE, _SPEED = 0.05, 0.013  # of the limit, and ω: what cannot be told from nothing
_ABSURD = 1e6  # rad²/s²: more than this is missing only if a reading is absurd
_NEVER_SINGULAR = 1e-9  # share added to the diagonal of J M⁻¹ Jᵀ


class Motors(NamedTuple):
    """Memory of the window.

    Attributes:
        what: (nj,) 1 for a motor that gives less than it is told.
        ticks: (1,) of the window so far; -1 before its first.
        window: (1,) ticks that it has.
        least_speed: (1,) that cannot be told from nothing, rad/s.
        kind: (n,) of the contacts in the window.
        before: (nv,) velocity when it began.
        expected: (nv,) change of velocity by the solutions.
        extra: (nv,) and by the torques that were sent beside them, no sole held.
        torque: (nj,) sum of what was sent, N·m.
        along: (nj,) product of what is missing and what a dead motor would miss, of this window and those before.
        own: (nj,) square of the latter.
        missing: (1,) square of the former.
        system: (6 n, 6 n + nj + 1) J M⁻¹ Jᵀ; J times the effect of every torque, and times ``extra``.
    """

    what: IntVector
    ticks: IntVector
    window: IntVector
    least_speed: Vector
    kind: IntVector
    before: Vector
    expected: Vector
    extra: Vector
    torque: Vector
    along: Vector
    own: Vector
    missing: Vector
    system: Matrix


def make_motors(n_joints: int, n_soles: int, rate: float, dt: float) -> Motors:
    """Memory that has seen nothing; ``rate`` is ω, 1/s."""
    size = WRENCH_SIZE * n_soles
    return Motors(
        what=np.zeros(n_joints, dtype=np.int64),
        ticks=np.array([-1]),
        window=np.array([max(2, round(_WINDOW / rate / dt))]),
        least_speed=np.array([_SPEED * rate]),
        kind=np.zeros(n_soles, dtype=np.int64),
        **{name: np.zeros(6 + n_joints) for name in ("before", "expected", "extra")},
        **{name: np.zeros(n_joints) for name in ("torque", "along", "own")},
        missing=np.zeros(1),
        system=np.zeros((size, size + n_joints + 1)),
    )


@kernel
def _restart(m: Motors, v: Vector) -> None:
    m.ticks[0] = 0
    for k in range(v.shape[0]):
        m.before[k] = v[k]
        m.expected[k] = m.extra[k] = 0.0
    for j in range(m.torque.shape[0]):
        m.torque[j] = 0.0


@kernel
def _fill(m: Motors, body: Body, contacts: Contacts, motion: Motion) -> int:
    """The system's equations; returns how many."""
    legs, response, nj = body.legs, motion.response, m.torque.shape[0]
    size, total, nv = 0, 0, nj + 6
    for leg in range(m.kind.shape[0]):
        for axis in range(WRENCH_SIZE):
            if contacts.kind[leg] != NONE and transmits(contacts.kind[leg], legs.half_width[leg], axis):
                total += 1
    for leg in range(m.kind.shape[0]):
        axes, jacobian = contacts.axes[leg], contacts.jacobian[leg]
        for axis in range(WRENCH_SIZE):
            if contacts.kind[leg] == NONE or not transmits(contacts.kind[leg], legs.half_width[leg], axis):
                continue
            row = 3 * (axis // 3)
            x, y, z = axes[0, axis - row], axes[1, axis - row], axes[2, axis - row]
            line = m.system[size]
            for c in range(total + nj + 1):
                line[c] = 0.0
            for k in range(nv):
                along = x * jacobian[row, k] + y * jacobian[row + 1, k] + z * jacobian[row + 2, k]
                for c in range(total):
                    line[c] += along * response[k, nj + c]
                for j in range(nj):
                    line[total + j] += along * response[k, j]
                line[total + nj] += along * m.extra[k]
            line[size] *= 1.0 + _NEVER_SINGULAR
            size += 1
    return size


@kernel
def _eliminate(a: Matrix, n: int, columns: int) -> None:
    """Solve the first n equations of ``a``, symmetric and positive, for the columns after the n-th, in place."""
    for i in range(n):
        over = 1.0 / a[i, i]
        for c in range(i, columns):
            a[i, c] *= over
        for k in range(n):
            if k == i:
                continue
            share = a[k, i]
            for c in range(i, columns):
                a[k, c] -= share * a[i, c]


@kernel
def _forget(m: Motors) -> None:
    """All windows before, and what they left."""
    m.missing[0] = 0.0
    for j in range(m.own.shape[0]):
        m.along[j] = m.own[j] = 0.0
    for i in range(m.system.shape[0]):
        for c in range(m.system.shape[1]):
            m.system[i, c] = 0.0


@kernel
def _judge(m: Motors, body: Body, motion: Motion, n: int, dt: float) -> int:
    """Name motors by the window that is full; returns how many have become bad or good."""
    nj, response, span, changes = m.torque.shape[0], motion.response, dt * m.ticks[0], 0
    for j in range(nj):
        m.along[j] *= _KEEP
        m.own[j] *= _KEEP
    m.missing[0] *= _KEEP
    for i in range(nj):
        row = response[6 + i]
        off = body.v[6 + i] - m.before[6 + i] - m.expected[6 + i] - m.extra[6 + i]
        for c in range(n):
            off += row[nj + c] * m.system[c, n + nj]
        m.missing[0] += off * off
        for j in range(nj):
            effect = row[j]
            for c in range(n):
                effect -= row[nj + c] * m.system[c, n + j]
            lost = -dt * effect * m.torque[j]
            m.along[j] += lost * off
            m.own[j] += lost * lost + (_TORQUE * span * effect * body.legs.torque_limit[j]) ** 2
    if not m.missing[0] < _ABSURD:
        _forget(m)
        return 0
    for j in range(nj):
        own = m.own[j] + m.least_speed[0] ** 2
        share, explained = m.along[j] / own, m.along[j] ** 2 / (own * (m.missing[0] + m.least_speed[0] ** 2))
        bad = 1 if explained > _EXPLAINED and _LEAST < share < _MOST else m.what[j]
        bad = 0 if abs(share) < _GOOD else bad
        changes += 1 if bad != m.what[j] else 0
        m.what[j] = bad
    return changes


@kernel
def watch_motors(m: Motors, body: Body, g: WholeBody, sent: Vector, driven: bool, dt: float) -> int:
    """Go on with the window by one tick.

    Args:
        m: memory.
        body: as this tick sees it.
        g: as the last tick left it.
        sent: (nj,) torque of the last tick, N·m.
        driven: whether the last tick was on time and its torques those of the whole-body solution.
        dt: control period, s.

    Returns:
        How many motors have become bad or good.
    """
    if not driven:
        m.ticks[0] = -1
        return 0
    if m.ticks[0] < 0:
        _restart(m, body.v)
        return 0
    contacts, motion, solution = g.contacts, g.motion, g.solution
    nj = sent.shape[0]
    for leg in range(m.kind.shape[0]):
        if m.ticks[0] == 0:
            m.kind[leg] = contacts.kind[leg]
        elif m.kind[leg] != contacts.kind[leg]:
            _restart(m, body.v)
            return 0
    beside = False
    for j in range(nj):
        m.torque[j] += sent[j]
        beside = beside or sent[j] != solution.torque[j]
    for k in range(nj + 6):
        more, row = 0.0, motion.response[k]
        for j in range(nj if beside else 0):
            more += row[j] * (sent[j] - solution.torque[j])
        m.extra[k] += dt * more
        m.expected[k] += dt * solution.acceleration[k]
    m.ticks[0] += 1
    if m.ticks[0] < m.window[0]:
        return 0
    n = _fill(m, body, contacts, motion)
    _eliminate(m.system, n, n + nj + 1)
    changes = _judge(m, body, motion, n, dt)
    _restart(m, body.v)
    return changes
