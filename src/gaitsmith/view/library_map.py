"""The grid of a library: which gaits there are, and what they cost."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from gaitsmith.library.folder import Record
from gaitsmith.library.spec import AXES, Spec, key_of
from gaitsmith.view.canvas import BAD, LIMIT, figure

_UNITS = {"speed": "speed, m/s", "step_height": "step height, m", "period": "period, s"}
_WRITTEN = 14  # columns in which a number still has room


def draw_library(spec: Spec, records: Mapping[str, Record]) -> Figure:
    """A cell a gait: its colour is J a metre, written in it where there is room; a cross where there is none.

    A panel for every step height.

    Args:
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
    kinds = [("x", BAD, "no gait: library show says why", failed), (".", LIMIT, "not planned yet", missing)]
    known = [value for panel in panels for value in panel[np.isfinite(panel)]]
    low, high = (min(known), max(known)) if known else (1.0, 10.0)
    high = max(high, 1.01 * low)
    scale = LogNorm(low, high)
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
                norm=scale,
                edgecolors="white",
                linewidth=1.5,
            )
            for (k, i), value in np.ndenumerate(values if len(speeds) <= _WRITTEN else values[:0]):
                if np.isfinite(value):
                    dark = scale(value) > 0.5
                    axis.text(i, k, f"{value:.0f}", ha="center", va="center", color="white" if dark else "black")
            for mark, colour, _, cells in kinds:
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
        bar = made.colorbar(image, ax=list(axes), label="J a metre, N²·m·s", format="%.0f")
        bar.set_ticks(np.geomspace(low, high, 3).tolist())
        bar.minorticks_off()
        if failed or missing:
            marks = [
                Line2D([], [], marker=mark, color=colour, linestyle="none", ms=9.0, mew=2.0, label=label)
                for mark, colour, label, cells in kinds
                if cells
            ]
            made.legend(handles=marks, loc="outside lower right", ncols=2)
    return made
