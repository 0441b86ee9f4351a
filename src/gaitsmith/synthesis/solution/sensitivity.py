"""How a plan's objective changes with the numbers of its motion, from the multipliers of its solution."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.motions.motion import Motion
from gaitsmith.synthesis.motions.settings import Settings
from gaitsmith.synthesis.point.functions import PointFunctions
from gaitsmith.synthesis.program.program import make_program
from gaitsmith.synthesis.program.transcription import Transcription
from gaitsmith.synthesis.solution.bound_check import with_times
from gaitsmith.synthesis.solution.neighbour import rescaled
from gaitsmith.synthesis.solution.plan import PlanResult

Array = npt.NDArray[np.float64]


def lagrangian(
    biped: Biped, functions: PointFunctions, result: PlanResult, motion: Motion, settings: Settings
) -> float:
    """What is minimised plus multipliers times rows, unscaled, of a plan's unknowns in a motion with other numbers.

    Its derivative with respect to these numbers is that of the least objective (the envelope theorem): unknowns and
    multipliers need not be found anew.

    Args:
        biped, functions: of the robot.
        result: a plan that is solved.
        motion: the same phases as in the plan, with nearby numbers.
        settings: as the plan's, before they were sized.
    """
    assert result.gait is not None
    assert result.solution is not None
    sized = settings.sized(biped, motion.transfer, motion.lift)
    used = {"torque_rate": result.gait.bounds["torque_rate"]}
    trans = Transcription(biped, motion, sized.model_copy(update={"bounds": sized.bounds.model_copy(update=used)}))
    imposed = rescaled(result.imposed, result.borders, motion.borders)
    program = make_program(trans, functions, with_times(trans, trans.points(), imposed), imposed)
    z, o = program.evaluate(result.x)
    multipliers = result.solution.multipliers
    count = len(multipliers)
    active = np.where(multipliers > 0.0, program.high[:count], program.low[:count])
    rows = program.constraint(result.x, o)[:count]
    held = np.flatnonzero(multipliers)
    return program.cost(z, o) + float(multipliers[held] @ (rows - active)[held]) / program.scale


def slopes(
    biped: Biped, functions: PointFunctions, result: PlanResult, motions: Sequence[Motion], settings: Settings
) -> Array:
    """(k,) by how much the least objective differs in motions 1 to k from that in motion 0, the plan's own."""
    here, *there = (lagrangian(biped, functions, result, motion, settings) for motion in motions)
    return np.array(there) - here
