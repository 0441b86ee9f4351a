"""The grid of a library: which gaits there are, and what they cost."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from gaitsmith.library.folder import Record
from gaitsmith.library.spec import AXES, Spec, key_of
from gaitsmith.view.canvas import BAD, LIMIT, figure

_UNITS = {"speed": "speed, m/s", "step_height": "step height, m", "period": "period, s"}


def draw_library(spec: Spec, records: Mapping[str, Record]) -> Figure:
    """A cell a gait: its colour is J a metre; a cross where there is none. A panel for every step height.

    Args:
        spec: the grid.
        records: what became of its points, by key.
    """
    speeds, heights, periods = spec.axes
    panels = [np.full((len(periods), len(speeds)), np.nan) for _ in heights]
    failed, missing = [], []
    for point in spec.points:
        record, (i, panel, k) = records.get(key_of(point)), point
        if record is None:
            missing.append((panel, i, k))
        elif record.certified:
            panels[panel][k, i] = record.objective / record.parameters["length"]
        else:
            failed.append((panel, i, k))
    known = [value for panel in panels for value in panel[np.isfinite(panel)]]
    low, high = (min(known), max(known)) if known else (0.0, 1.0)
    rows = 1.6 + 0.45 * len(periods) * len(heights)
    certified = len(known)
    with figure(f"{spec.robot}: {certified} of {len(spec.points)} gaits certified", max(rows, 2.6)) as made:
        axes = made.subplots(len(heights), 1, squeeze=False, sharex=True)[:, 0]
        for panel, (axis, values) in enumerate(zip(axes, panels, strict=True)):
            image = axis.pcolormesh(
                np.arange(len(speeds) + 1) - 0.5,
                np.arange(len(periods) + 1) - 0.5,
                values,
                cmap="viridis_r",
                vmin=low,
                vmax=high if high > low else low + 1.0,
                edgecolors="white",
                linewidth=1.5,
            )
            for mark, cells, colour in (("x", failed, BAD), (".", missing, LIMIT)):
                here = [(i, k) for where, i, k in cells if where == panel]
                if here:
                    axis.plot(*np.array(here).T, mark, color=colour, ms=9.0, mew=2.0)
            axis.grid(visible=False)
            axis.set_yticks(range(len(periods)), [f"{value:g}" if np.isfinite(value) else "own" for value in periods])
            axis.set_ylabel(_UNITS["period"])
            if np.isfinite(heights[panel]):
                axis.set_title(f"{AXES[1].replace('_', ' ')} {heights[panel]:g} m")
        axes[-1].set_xticks(range(len(speeds)), [f"{value:g}" for value in speeds])
        axes[-1].set_xlabel(_UNITS["speed"])
        made.colorbar(image, ax=list(axes), label="J a metre, N²·m·s")
        marks = [Patch(facecolor=BAD, label="× no gait: library show says why")] if failed else []
        marks += [Patch(facecolor=LIMIT, label="· not planned yet")] if missing else []
        if marks:
            made.legend(handles=marks, loc="outside lower right", ncols=2)
    return made
