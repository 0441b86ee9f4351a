"""Numbers of a motion left free: to the least objective, by quadratic programs (BFGS) within a trust region."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import daqp
import numpy as np
import numpy.typing as npt

from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.motions.catalogue import cyclic
from gaitsmith.synthesis.motions.motion import Motion
from gaitsmith.synthesis.motions.parameters import StepParameters
from gaitsmith.synthesis.motions.settings import Settings
from gaitsmith.synthesis.solution.plan import Planner, PlanResult
from gaitsmith.synthesis.solution.sensitivity import slopes

Array = npt.NDArray[np.float64]
_STEP = {  # first change, least, most
    "swing_split": (0.08, 0.3, 0.7),
    "heel_share": (0.12, 0.12, 0.6),
    "toe_share": (0.12, 0.12, 0.6),
    "toe_off": (0.12, 0.0, 0.5),
    "heel_strike": (0.12, 0.0, 0.4),
}
_FLAT = 0.12  # least share of the double support with both feet flat
_PLANS = 25  # at most
_GAIN = 1e-3  # of J, less than which a step is not worth a plan
_SMALLEST = 0.05  # share of the first changes
_EPSILON = 1e-4  # of the first changes, for slopes
_DAMPED = 0.2  # of the curvature that was expected: the least that counts
_FAR = 1e30
_AGREE = 0.25  # of what the slope promises, below which steps get smaller


@dataclass(frozen=True, eq=False)
class Freedom:
    """Where k numbers may lie.

    Attributes:
        low, high: (k,) of each.
        reach: (k,) largest first change.
        sums, most: (m, k) and (m,): sums @ values <= most.
    """

    low: Array
    high: Array
    reach: Array
    sums: Array
    most: Array

    def step(self, values: Array, slope: Array, curvature: Array, share: float) -> Array:
        """(k,) the change within a share of the reach at which the quadratic model is least."""
        low = np.minimum(np.maximum(self.low - values, -share * self.reach), 0.0)
        high = np.maximum(np.minimum(self.high - values, share * self.reach), 0.0)
        room = np.maximum(self.most - self.sums @ values, 0.0)
        unit = self.reach
        found, _, status, _ = daqp.solve(
            np.ascontiguousarray(curvature * np.outer(unit, unit)),
            np.ascontiguousarray(slope * unit),
            np.ascontiguousarray(self.sums * unit),
            np.concatenate([high / unit, room]),
            np.concatenate([low / unit, np.full(len(room), -_FAR)]),
            np.zeros(len(values) + len(room), dtype=np.int32),
        )
        return np.clip(np.asarray(found) * unit, low, high) if status > 0 else np.zeros(len(values))


def descended(
    values: Array,
    freedom: Freedom,
    first: PlanResult,
    slope: Callable[[Array, PlanResult], Array],
    plan: Callable[[Array, PlanResult], PlanResult],
) -> tuple[Array, PlanResult]:
    """The numbers with the least J that are found, and their plan.

    Args:
        values: (k,) where the search starts.
        freedom: where they may lie.
        first: their plan, solved.
        slope: (k,) dJ by the numbers, of a plan.
        plan: of numbers, from a neighbour's result.
    """
    best, found, share, downhill = values, first, 1.0, slope(values, first)
    bent = np.diag(np.abs(downhill * freedom.reach).max() / freedom.reach**2)
    for _ in range(_PLANS):
        move = freedom.step(best, downhill, bent, share)
        promised = -float(downhill @ move + 0.5 * move @ bent @ move)
        if share < _SMALLEST or promised < _GAIN * found.objective:
            break
        result = plan(best + move, found)
        gain = found.objective - result.objective if result.gait is not None else 0.0
        if gain < _AGREE * promised:
            share *= 0.5
        if result.gait is None:
            continue
        ahead = slope(best + move, result)
        bent = _bent(bent, move, ahead - downhill)
        if gain > 0.0:
            best, found, downhill = best + move, result, ahead
    return best, found


def _bent(curvature: Array, move: Array, change: Array) -> Array:
    """(k, k) curvature after a move that changed the slope: BFGS, damped so that it stays positive."""
    along = curvature @ move
    whole, seen = float(move @ along), float(move @ change)
    if whole <= 0.0:
        return curvature
    share = 1.0 if seen >= _DAMPED * whole else (1.0 - _DAMPED) * whole / (whole - seen)
    change = share * change + (1.0 - share) * along
    return np.asarray(curvature - np.outer(along, along) / whole + np.outer(change, change) / float(move @ change))


def freed_step(
    planner: Planner,
    step: StepParameters,
    first: PlanResult,
    settings: Settings,
    run: Callable[[Motion, PlanResult], PlanResult],
) -> tuple[StepParameters, PlanResult]:
    """A step of a cyclic gait with the phase times and foot pitches that make J least, and its plan."""
    names = list(_STEP)
    shares = np.array([[float(name in ("heel_share", "toe_share")) for name in names]])
    reach, low, high = np.array(list(_STEP.values())).T
    freedom = Freedom(low, high, reach, shares, np.array([1.0 - _FLAT]))

    def motion(values: Array) -> Motion:
        return cyclic(planner.biped, replace(step, **dict(zip(names, values.tolist(), strict=True))))

    values = np.array([getattr(step, name) for name in names])
    values, found = _freed(planner, motion, values, freedom, first, settings, run)
    return replace(step, **dict(zip(names, values.tolist(), strict=True))), found


def freed_motion(
    planner: Planner,
    motion: Motion,
    first: PlanResult,
    settings: Settings,
    run: Callable[[Motion, PlanResult], PlanResult],
) -> PlanResult:
    """The plan of a motion with the durations, of phases that leave them free, that make J least."""
    free = [k for k, phase in enumerate(motion.phases) if phase.between is not None]
    low, high = np.array([motion.phases[k].between for k in free]).T
    values = np.array([motion.phases[k].duration for k in free])
    sums = np.array([] if motion.total is None else [1.0, -1.0])  # neither longer nor shorter
    every = np.outer(sums, np.ones(len(free)))
    freedom = Freedom(low, high, 0.25 * (high - low), every, sums * values.sum())

    def lasting(values: Array) -> Motion:
        phases = list(motion.phases)
        for k, value in zip(free, values.tolist(), strict=True):
            phases[k] = replace(phases[k], duration=value)
        return replace(motion, phases=tuple(phases))

    return _freed(planner, lasting, values, freedom, first, settings, run)[1]


def _freed(
    planner: Planner,
    motion: Callable[[Array], Motion],
    values: Array,
    freedom: Freedom,
    first: PlanResult,
    settings: Settings,
    run: Callable[[Motion, PlanResult], PlanResult],
) -> tuple[Array, PlanResult]:
    robot = planner.suited(motion(values))
    biped: Biped = robot.biped

    def slope(here: Array, result: PlanResult) -> Array:
        changes = _EPSILON * freedom.reach
        moved = [motion(here), *(motion(here + change) for change in np.diag(changes))]
        return slopes(biped, robot.functions, result, moved, settings) / changes

    return descended(values, freedom, first, slope, lambda tried, found: run(motion(tried), found))
