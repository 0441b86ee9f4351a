"""Where the solver starts: standing still in a slight squat."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from gaitsmith.synthesis.motions.biped import standing
from gaitsmith.synthesis.program.transcription import Transcription

Array = npt.NDArray[np.float64]


def default_start(trans: Transcription) -> Array:
    """Standing still, the load shared by both feet: the start that every motion is solved from."""
    x = np.zeros(trans.size)
    q0 = standing(trans.biped)
    n = trans.biped.joints
    x[: n * trans.spline.size] = np.repeat(q0, trans.spline.size)
    for index, phase in enumerate(trans.motion.phases):
        if phase.double:
            x[trans.wrench_columns(index)[2]] = 0.5
    return x
