"""A plan from a neighbour's, and where that leads nowhere, from nothing."""

from __future__ import annotations

from dataclasses import replace

from gaitsmith.synthesis.motions.motion import Motion
from gaitsmith.synthesis.motions.settings import Settings
from gaitsmith.synthesis.solution.plan import Planner, PlanResult


def plan_nearby(
    planner: Planner, motion: Motion, settings: Settings, neighbour: PlanResult | None
) -> tuple[PlanResult, bool]:
    """Plan from a neighbour's result if there is one, else, or if that gives no gait, from nothing.

    Args:
        planner: for the robot.
        motion: phases and conditions.
        settings: bounds, order, tolerances.
        neighbour: result for the same phases with nearby numbers, or one whose gait has phases of the same names.

    Returns:
        The result, and whether it comes from the neighbour. One without a gait and with another number of unknowns
        gives no start: the plan comes from nothing then. What was spent on a neighbour that led nowhere counts in its
        iterations, and as one fallback more.
    """
    if neighbour is None:
        return planner.plan(motion, settings), False
    near = planner.plan(motion, settings, neighbour=neighbour)
    if neighbour.gait is None and near.variables != len(neighbour.x):
        return near, False
    if near.gait is not None:
        return near, True
    found = planner.plan(motion, settings)
    spent, fallbacks = near.iterations + found.iterations, near.fallbacks + found.fallbacks + 1
    return replace(found, iterations=spent, fallbacks=fallbacks), False
