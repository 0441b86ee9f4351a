"""How every figure looks, and how it is written: no display, no global state, a file that is whole or absent."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitsmith.files import write_bytes_atomic
from gaitsmith.robots.sole import Sole
from gaitsmith.view.recording import Recording

# Okabe and Ito's palette: told apart by every kind of colour vision, and in grey.
COMMAND, LEFT, RIGHT, THIRD = "#000000", "#0072B2", "#D55E00", "#009E73"
LIMIT, BAND, GRID = "#999999", "#F1F3F5", "#D9DDE1"
WIDTH, DPI = 10.0, 160  # inches and dots per inch: 1600 pixels wide
_LINE_SOLE = 0.012  # m: half the width a line sole is drawn with
_POINTS = 4000  # samples drawn per curve: more than the pixels across

STYLE: dict[Any, Any] = {
    "font.size": 11.0,
    "axes.titlesize": 12.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.7,
    "lines.linewidth": 1.5,
    "legend.frameon": False,
    "legend.fontsize": 10.0,
    "legend.borderaxespad": 0.2,
    "figure.constrained_layout.use": True,
    "text.parse_math": False,  # names are text
}


@contextmanager
def figure(title: str, height: float) -> Iterator[Figure]:
    """A blank figure 1600 pixels wide and ``height`` inches high, in the common style."""
    with mpl.rc_context(STYLE):
        made = Figure(figsize=(WIDTH, height), dpi=DPI)
        made.suptitle(title, x=0.01, ha="left", fontsize=13.0, fontweight="bold")
        yield made


def save(made: Figure, path: Path) -> Path:
    """Write a PNG.

    Raises:
        BadInput: the folder cannot be written.
    """
    content = io.BytesIO()
    with mpl.rc_context(STYLE):
        made.savefig(content, format="png", dpi=DPI, metadata={"Software": "gaitsmith"})
    write_bytes_atomic(path, content.getvalue())
    return path


def sampled(recording: Recording, span: slice = slice(None)) -> slice:
    """``span`` thinned to what a figure can show."""
    begin, end, _ = span.indices(len(recording.time))
    return slice(begin, end, max(1, (end - begin) // _POINTS))


def mark_stages(axes: Sequence[Axes], recording: Recording) -> None:
    """Shade every second stage of constant command."""
    for index, stage in enumerate(recording.stages()):
        if index % 2:
            for axis in axes:
                axis.axvspan(stage.begin, stage.end, color=BAND, zorder=0, linewidth=0.0)


def above(axis: Axes, columns: int) -> None:
    """Put the legend over the plot, where no curve runs."""
    axis.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=columns, handlelength=1.8, columnspacing=1.2)


def sole_corners(sole: Sole) -> npt.NDArray[np.float64]:
    """(n, 2) corners of a sole in its own frame, m; a line is given a width that can be seen."""
    if sole.half_width > 0.0:
        return sole.corners
    wide = np.array([0.0, _LINE_SOLE])
    return np.concatenate([sole.corners - wide, sole.corners[::-1] + wide])
