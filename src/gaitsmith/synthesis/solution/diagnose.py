"""Why a motion could not be planned, in words."""

from __future__ import annotations

import numpy as np

from gaitsmith.synthesis.program.program import Program
from gaitsmith.synthesis.program.transcription import Transcription
from gaitsmith.synthesis.solution.elastic import Elastic, Excess, excess_of
from gaitsmith.synthesis.solution.ipopt import Solution

_TOLD = 2  # bounds that a reason names
_SLIGHT = 0.01  # of a bound's range


def place(trans: Transcription, phase: int, time: float) -> str:
    """Where in the motion an instant lies: "62 % of single support"."""
    phases, borders = trans.motion.phases, trans.motion.borders
    first = last = phase
    while first > 0 and phases[first - 1].double == phases[phase].double:
        first -= 1
    while last + 1 < len(phases) and phases[last + 1].double == phases[phase].double:
        last += 1
    share = 100.0 * (time - borders[first]) / (borders[last + 1] - borders[first])
    stretch = "double support" if phases[phase].double else "single support"
    return f"{share:.0f} % of {stretch}"


def lacking(trans: Transcription, least: Elastic) -> str:
    """What a request would take that the robot does not have: "right_knee torque 178 of 40 N·m at 97 % of ...".

    Where hardly any bound is exceeded and the conditions still do not hold, it is they that contradict each other.
    """
    missed = next((item for item in least.excesses if item.label.exact), least.unmet)
    if missed is not None and all(item.share < _SLIGHT for item in least.excesses if not item.label.exact):
        text = _described(trans, missed)
        return f"no solution: the conditions do not hold together, whatever the robot could do: {text}"
    said = [_described(trans, item) for item in least.excesses[:_TOLD]]
    return f"no solution: it would take {', and '.join(said)}"


def undecided(trans: Transcription, program: Program, found: Solution, spent: int) -> str:
    """What did not hold yet when the iterations were spent: neither a gait nor a reason why there is none."""
    ending = f"not decided after {spent} iterations, --max-iterations allows more"
    z, o = program.evaluate(found.x)
    if not (np.isfinite(z).all() and np.isfinite(o).all()):
        return f"{ending}: the solver left the range of finite numbers"
    values = program.constraint(found.x, o)
    gaps = program.violation(values)
    if gaps.max(initial=0.0) < 1e-6:
        return f"{ending}: every constraint holds, but the torques are not at their least yet"
    unequal = program.high - program.low > 0.0
    # A bound says more than the closure that it makes impossible.
    bound_gaps = np.where(unequal, gaps, 0.0)
    row = int(np.argmax(bound_gaps)) if bound_gaps.max(initial=0.0) > 1e-4 else int(np.argmax(gaps))
    return f"{ending}: {_described(trans, excess_of(program, row, values))}"


def _described(trans: Transcription, excess: Excess) -> str:
    """A value beside its limit, and where; "beyond its limit" where the value is measured from there."""
    label, value, limit = excess.label, excess.value, excess.limit
    digits = 3 if f"{value:.3g}" != f"{limit:.3g}" else 7
    pair = f"{value:.{digits}g} of {limit:.{digits}g} {label.unit}"
    if limit == 0.0:
        pair = f"{abs(value):.3g} {label.unit} beyond its limit"
    return f"{label.name} {pair} at {place(trans, label.phase, label.time)}"
