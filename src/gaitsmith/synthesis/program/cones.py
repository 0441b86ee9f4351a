"""Cones of the foot that loads or unloads: on the Bernstein coefficients of its wrench, and so at all times.

Friction, ZMP and normal force of the other foot are cones, linear in u. If the coefficients lie in a cone, so does the
curve. Where u goes to zero its direction tends to that of the coefficient next to it, for which the yaw moment's bound
is imposed too: at that end the curve's own values are too small to tell. The same goes for a support sole that has just
landed while the other foot bears all.
"""

from __future__ import annotations

from dataclasses import replace

from gaitsmith.synthesis.program.bounds import Kind, PhaseBound
from gaitsmith.synthesis.program.rows import Rows, bound_label
from gaitsmith.synthesis.program.transcription import SOON, WRENCH_DEGREE, Points, Transcription

_EARLY = 0.02  # of a range: the direction of the first load is not yet that at the instant looked at
_SPARE = 2e-3  # of a yaw moment's limit: next to the end the curve has another direction


def is_cone(trans: Transcription, bound: PhaseBound) -> bool:
    """Whether a bound is a cone of the other foot's wrench alone, linear in it."""
    return not bound.out and bool(bound.inp) and min(bound.inp) >= trans.layout.wrench


def cone_rows(rows: Rows, trans: Transcription, points: Points) -> None:
    """Append the cones of every phase of double support."""
    motion, layout, weight = trans.motion, trans.layout, trans.biped.weight
    for index, phase in enumerate(motion.phases):
        if not phase.double:
            continue
        columns, start = trans.wrench_columns(index), float(motion.borders[index])
        first, last = int(motion.meets(index)), WRENCH_DEGREE - int(motion.leaves(index))
        for bound in trans.bounds[index]:
            if not is_cone(trans, bound):
                continue
            low, high = bound.low / bound.span, bound.high / bound.span
            for k in range(first, last + 1):
                label = bound_label(bound, index, start + phase.duration * k / WRENCH_DEGREE)
                terms = bound.inp.items()
                form = {int(columns[i - layout.wrench, k]): weight * value / bound.span for i, value in terms}
                rows.add(label, low, high, lin=form)
    for index in (k for k in range(len(motion.phases)) if motion.takes_over(k)):
        _first_load(rows, trans, points, index)
    for point, (index, control) in enumerate(zip(points.phase.tolist(), points.control.tolist(), strict=True)):
        if control >= 0:
            for bound in trans.bounds[index]:
                if bound.kind is Kind.YAW_MOMENT and set(bound.out) == {layout.twist + 1, layout.load + 1}:
                    time = float(points.time[point])
                    rows.add_bound(bound, index, time, point, 0.0, _SPARE)


def _first_load(rows: Rows, trans: Transcription, points: Points, index: int) -> None:
    """Bounds on the support sole's first load, soon after it has landed, relative to the time since then."""
    time = float(trans.borders[index] + SOON * trans.motion.phases[index].duration)
    point = points.places()[index, round(time, 9)]
    for bound in trans.bounds[index]:
        if bound.load == 0:
            scale = SOON**-bound.power
            out = {k: scale * value for k, value in bound.out.items()}
            rows.add_bound(replace(bound, out=out), index, time, point, SOON, _EARLY)
