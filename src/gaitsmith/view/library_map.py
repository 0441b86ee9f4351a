"""The grid of a library: which gaits there are, and what they cost."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from gaitsmith.library.folder import Record
from gaitsmith.library.spec import AXES, Spec, key_of
from gaitsmith.view.canvas import BAD, LIMIT, figure

_WRITTEN = 14  # cells across in which a number still has room
_STACKED = 3  # panels below each other; more stand side by side
_ALIKE = 1.001  # costs of which the largest is no more than so many times the least have no scale
_Place = tuple[int, int, int]  # panel, column, row


def draw_library(spec: Spec, records: Mapping[str, Record]) -> Figure:
    """A cell a gait: its colour is J a metre, written in it where there is room; a cross where there is none.

    Speed lies along x, the axis with the most values besides along y; a panel for every place along the others.

    Args:
        records: what became of its points, by key.
    """
    across, others = spec.speed, [name for name in spec.names if name != "speed"]
    up = max(others, key=lambda name: (len(getattr(spec, name)), name == "period"), default="")
    panels = [name for name in others if name != up]
    places = [*itertools.product(*(getattr(spec, name) for name in panels))]
    rows: tuple[float, ...] = getattr(spec, up) if up else (0.0,)
    costs = [np.full((len(rows), len(across)), np.nan) for _ in places]
    failed, missing = list[_Place](), list[_Place]()
    for point in spec.points:
        at, record = spec.place(point), records.get(key_of(point))
        panel = places.index(tuple(at[name] for name in panels))
        i, k = point[0], rows.index(at[up]) if up else 0
        if record is None:
            missing.append((panel, i, k))
        elif record.certified:
            costs[panel][k, i] = record.objective / record.parameters["length"]
        else:
            failed.append((panel, i, k))
    kinds = [("x", BAD, "no gait: library show says why", failed), (".", LIMIT, "not planned yet", missing)]
    known = [float(value) for panel in costs for value in panel[np.isfinite(panel)]]
    low, high = (min(known), max(known)) if known else (1.0, 1.0)
    alike = high <= _ALIKE * low
    scale = LogNorm(low / 2.0, high * 2.0) if alike else LogNorm(low, high)
    columns = 1 if len(places) <= _STACKED else 2
    lines = -(-len(places) // columns)
    title = f"{spec.robot}: {len(known)} of {len(spec.points)} gaits certified"
    with figure(title, max(1.6 + (0.35 + 0.45 * len(rows)) * lines, 2.6)) as made:
        axes = made.subplots(lines, columns, squeeze=False, sharex=True, sharey=True).ravel()
        for axis in axes[len(places) :]:
            axis.set_visible(False)
        written = alike or len(across) * columns <= _WRITTEN
        for panel, axis in enumerate(axes[: len(places)]):
            image = _cells(axis, costs[panel], scale, written)
            for mark, colour, _, cells in kinds:
                here = [(i, k) for where, i, k in cells if where == panel]
                if here:
                    axis.plot(*np.array(here).T, mark, color=colour, ms=9.0, mew=2.0)
            told = [
                f"{_worded(name)} {value:g} {AXES[name]}" for name, value in zip(panels, places[panel], strict=True)
            ]
            axis.set_title(", ".join(told))
            axis.set_yticks(range(len(rows)) if up else [], [f"{value:g}" for value in rows] if up else [])
            if up and panel % columns == 0:
                axis.set_ylabel(f"{_worded(up)}, {AXES[up]}")
            axis.set_xticks(range(len(across)), [f"{value:g}" for value in across])
            if panel + columns >= len(places):
                axis.set_xlabel(f"speed, {AXES['speed']}")
                axis.tick_params(labelbottom=True)
        if not alike:
            bar = made.colorbar(image, ax=list(axes), label="J a metre, N²·m·s", format="%.0f")
            bar.set_ticks(np.geomspace(low, high, 3).tolist())
            bar.minorticks_off()
        marks = [
            Line2D([], [], marker=mark, color=colour, linestyle="none", ms=9.0, mew=2.0, label=label)
            for mark, colour, label, cells in kinds
            if cells
        ]
        if alike and known:
            marks.append(Line2D([], [], linestyle="none", label="in the cells: J a metre, N²·m·s"))
        if marks:
            made.legend(handles=marks, loc="outside lower right", ncols=len(marks))
    return made


def _worded(name: str) -> str:
    return name.replace("_", " ")


def _cells(axis: Axes, costs: npt.NDArray[np.float64], scale: LogNorm, written: bool) -> QuadMesh:
    """Colours of one panel, with their numbers."""
    rows, across = costs.shape
    edges = np.arange(across + 1) - 0.5, np.arange(rows + 1) - 0.5
    image = axis.pcolormesh(*edges, costs, cmap="viridis_r", norm=scale, edgecolors="white", linewidth=1.5)
    for (k, i), value in np.ndenumerate(costs):
        if written and np.isfinite(value):
            colour = "white" if scale(value) > 0.5 else "black"
            axis.text(i, k, f"{value:.0f}", ha="center", va="center", color=colour)
    axis.grid(visible=False)
    return image
