"""Where the solver starts: standing still in a slight squat."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from gaitsmith.synthesis.motions.biped import standing, standing_leans
from gaitsmith.synthesis.program.transcription import Transcription

Array = npt.NDArray[np.float64]


def default_start(trans: Transcription) -> Array:
    """Standing still, the load shared by both feet: the start that every motion is solved from."""
    x = np.zeros(trans.size)
    q0 = standing(trans.biped, slope=trans.motion.slope)
    known = np.concatenate([q0, standing_leans(trans.biped, q0)])
    x[: trans.biped.channels * trans.spline.size] = np.repeat(known, trans.spline.size)
    for index, phase in enumerate(trans.motion.phases):
        if phase.double:
            x[trans.wrench_columns(index)[2]] = 0.5
    return x
