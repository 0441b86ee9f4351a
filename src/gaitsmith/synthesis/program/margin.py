"""Bounds drawn in by a margin, so that a plan keeps the true ones at every instant, between those that were looked at.

A grid finds a violation up to what a curve does between its instants. The program therefore holds bounds that
are drawn in by :data:`MARGIN` of their range, and a plan is accepted when it exceeds these by at most :data:`SLACK`.
What a motion meets exactly has no margin: a foot that meets or leaves the ground, the edge on which it bears before
and after it turns about it, a limit on which a condition lies, a foot without load where a flight begins or ends.
"""

from __future__ import annotations

from typing import Any

from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.motions.motion import At, Motion
from gaitsmith.synthesis.point.layout import PointLayout, layout_of
from gaitsmith.synthesis.program.bounds import NO_LOAD, Kind, PhaseBound

MARGIN = 1e-3  # share of a bound's range
SLACK = 0.8 * MARGIN  # of what is drawn in: the rest is for what lies between the instants of the dense grid
EXACT = 1e-6  # share of the range, of a bound without a margin: what the solver leaves
TOUCHING = 4e-6  # the same of a sole that leaves or meets the ground
TURNING = 6e-7  # rad, of a sole that turns about its edge and comes to lie flat
_STEEPER = 1.02  # the profile that the swing sole is held above, relative to the one that it must not sink below
_LEFT = 0.2  # of a range, which margins leave at least
_ON = 1e-9


def drawn_in(bounds: list[PhaseBound], biped: Biped, motion: Motion, index: int) -> list[PhaseBound]:
    """A phase's bounds with their margins, and with the violation that is accepted of each."""
    beside = motion.phases[index].double or motion.beside_edge(index)
    flies = motion.takes_over(index) or any(phase.flies for phase in motion.phases[max(index - 1, 0) : index + 2])
    ends = [item for item in motion.conditions if isinstance(item, At) and item.border in (index, index + 1)]
    layout, weight = layout_of(biped), biped.weight
    return [PhaseBound(**(vars(bound) | _margin(bound, layout, weight, beside, flies, ends))) for bound in bounds]


def _margin(
    bound: PhaseBound, layout: PointLayout, weight: float, beside: bool, flies: bool, ends: list[At]
) -> dict[str, Any]:
    """What a margin changes of a bound.

    Args:
        bound: the bound.
        layout: of a point.
        weight: of the robot, N.
        beside: whether both feet stand in its phase, or a foot turns about its edge beside it.
        flies: whether a flight is beside it, or a foot takes over the load.
        ends: conditions at its phase's ends.
    """
    other = min(bound.inp, default=0) >= layout.wrench
    if beside and bound.name.endswith(("ZMP forward", "ZMP backward")):
        return {"slack": EXACT}
    if bound.load != NO_LOAD:
        share = MARGIN * bound.ratio_span * bound.factor / weight
        out, inp = dict(bound.out), dict(bound.inp)
        form, place = (inp, layout.wrench + 2) if bound.load else (out, layout.force + 2)
        if bound.power == 2:
            form, place = out, layout.load + bound.load
        form[place] = form.get(place, 0.0) + share
        return {"out": out, "inp": inp, "slack": SLACK}
    if bound.interior:
        return {"rise": bound.rise * _STEEPER, "slack": TURNING if bound.sine else TOUCHING}
    met = any(
        item.quantity == bound.name and min(abs(item.value - bound.low), abs(item.value - bound.high)) <= _ON
        for item in ends
    )
    if met or ((other or flies) and bound.kind is Kind.NORMAL_FORCE):
        return {"slack": EXACT}
    room = min(MARGIN * bound.span, 0.5 * (1.0 - _LEFT) * (bound.high - bound.low))
    return {"low": bound.low + room, "high": bound.high - room, "slack": SLACK * room / (MARGIN * bound.span)}
