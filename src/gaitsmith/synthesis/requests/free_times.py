"""Phase times and foot pitches of a step left free: a pattern search, every plan started from the best one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from gaitsmith.synthesis.motions.catalogue import StepParameters
from gaitsmith.synthesis.solution.plan import PlanResult

_Plan = Callable[[StepParameters, PlanResult], PlanResult]
_FREE = {  # first change, least, most
    "swing_split": (0.04, 0.3, 0.7),
    "heel_share": (0.06, 0.12, 0.6),
    "toe_share": (0.06, 0.12, 0.6),
    "toe_off": (0.06, 0.0, 0.5),
    "heel_strike": (0.06, 0.0, 0.4),
}
_FLAT = 0.12  # least share of the double support with both feet flat
_SWEEPS = 3
_GAIN = 1e-3  # of J, less than which a sweep is the last one


def freed(step: StepParameters, first: PlanResult, plan: _Plan) -> tuple[StepParameters, PlanResult]:
    """The step with the least J that the search finds, and its plan.

    Args:
        step: where the search starts.
        first: its plan, solved.
        plan: plans a cyclic gait of a step, from a neighbour's result.
    """
    best, found, shrink = step, first, 1.0
    for _ in range(_SWEEPS):
        before = found.objective
        for name, (change, low, high) in _FREE.items():
            for sign in (1.0, -1.0):
                moved = False
                while True:
                    value = min(max(getattr(best, name) + sign * shrink * change, low), high)
                    tried = replace(best, **{name: value})
                    if value == getattr(best, name) or tried.heel_share + tried.toe_share > 1.0 - _FLAT:
                        break
                    result = plan(tried, found)
                    if result.gait is None or result.objective >= found.objective:
                        break
                    best, found, moved = tried, result, True
                if moved:
                    break
        shrink *= 0.5
        if before - found.objective < _GAIN * before:
            break
    return best, found
