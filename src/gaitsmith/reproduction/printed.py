"""The stance leg's reference as the paper prints it (Han 2023, eqs. 7 to 9), beside what the controller follows."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from gaitsmith.reports.run import Run
from gaitsmith.splines.quartic_pair import evaluate_pair


def printed_stance(run: Run) -> npt.NDArray[np.float64]:
    """(n, 6) left and right sole relative to the hips in support, heading frame, m; NaN elsewhere.

    x runs from half a step ahead to half a step behind (ζ₀ is L̃/2, as eq. 9 must mean), y stays at ±W, z at -H.
    """
    log, record = run.log, run.recording
    found, out = np.full((len(record.time), 6), np.nan), np.zeros(3)
    told = {name: log.column(f"command.{name}") for name in ("period", "alpha", "height", "width", "speed_x")}
    for side in (0, 1):
        rows = np.flatnonzero(record.walking & (record.stance == side))
        elapsed = log.column("step_time")
        for row in rows:
            period, alpha, height, width, speed = (float(values[row]) for values in told.values())
            half = 0.5 * period * speed
            evaluate_pair(float(elapsed[row]), alpha * period, period, half, 0.0, 0.0, 0.0, -half, 0.0, 0.0, out)
            found[row, 3 * side : 3 * side + 3] = out[0], width * (1.0, -1.0)[side], -height
    return found
