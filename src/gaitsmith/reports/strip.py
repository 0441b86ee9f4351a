"""Pictures of a run side by side, as a paper prints frames of a video."""

from __future__ import annotations

import io

import numpy as np
import numpy.typing as npt
from matplotlib.image import imsave

from gaitsmith.reports.rendering import Renderer
from gaitsmith.reports.run import Run
from gaitsmith.simulation.props import Ball
from gaitsmith.simulation.scene_log import positions

_SIZE = (240, 320)  # pixels of one picture
_GAP = 6  # pixels


def strip(run: Run, times: npt.ArrayLike, balls: npt.NDArray[np.float64] | None = None, columns: int = 6) -> bytes:
    """PNG with one picture for each time, s, from left to right, then down; ``balls``: (n, 3) of a ball then, m.

    Raises:
        NoRenderer: this machine cannot draw without a display.
    """
    wanted, log = np.asarray(times, dtype=float), run.log
    where = positions(log, run.robot)[np.clip(np.searchsorted(log.time, wanted), 0, len(log.time) - 1)]
    renderer = Renderer(run.robot, _SIZE, ball=None if balls is None else Ball((0.0, 0.0, 0.0)))
    try:
        pictures = [renderer.draw(position, None if balls is None else balls[k]) for k, position in enumerate(where)]
    finally:
        renderer.close()
    rows = -(-len(pictures) // columns)
    sheet = np.full((rows * (_SIZE[1] + _GAP) - _GAP, columns * (_SIZE[0] + _GAP) - _GAP, 3), 255, dtype=np.uint8)
    for number, picture in enumerate(pictures):
        down, right = divmod(number, columns)
        top, left = down * (_SIZE[1] + _GAP), right * (_SIZE[0] + _GAP)
        sheet[top : top + _SIZE[1], left : left + _SIZE[0]] = picture
    content = io.BytesIO()
    imsave(content, sheet, format="png")
    return content.getvalue()
