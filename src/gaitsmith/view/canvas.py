"""How every figure looks, and how it is written: no display, no global state, a file that is whole or absent."""

from __future__ import annotations

import io
import textwrap
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from PIL import Image

from gaitsmith.files import write_bytes_atomic
from gaitsmith.robots.sole import Sole
from gaitsmith.view.recording import Recording

# Okabe and Ito's palette: told apart by every kind of colour vision, and in grey.
COMMAND, LEFT, RIGHT, THIRD = "#000000", "#0072B2", "#D55E00", "#009E73"
LIMIT, BAND, GRID = "#999999", "#F1F3F5", "#D9DDE1"
_LINE_LENGTH = 120  # characters
_ROW = 0.05  # s: a fall may come between the last row of a log and the next
WIDTH, DPI = 10.0, 160  # inches and dots per inch: 1600 pixels wide
_LINE_SOLE = 0.012  # m: half the width a line sole is drawn with
_COLOURS = 64  # of a PNG
_POINTS = 2000  # samples drawn per curve: more than the pixels across
BAD = "#C1121F"  # falls, limits that are hit
PUSH, FAULT = "#CC79A7", "#A6761D"
_NAMED = 12  # pushes and faults that are named; more would cover each other

# Begins with the library's own defaults: a file matplotlibrc in the working folder changes no figure.
_OWN = {name: value for name, value in mpl.rcParamsDefault.items() if not name.startswith(("backend", "interactive"))}
STYLE: dict[Any, Any] = _OWN | {
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
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "gaitsmith",  # the same picture, the same file
}


@contextmanager
def figure(title: str, height: float, conditions: str = "") -> Iterator[Figure]:
    """A blank figure 1600 pixels wide and ``height`` inches high, in the common style.

    Args:
        title: what it shows, of which robot.
        height: inches.
        conditions: a second line under the title, such as the parameters of the walk.
    """
    lines = textwrap.wrap(conditions, _LINE_LENGTH)
    with mpl.rc_context(STYLE):
        made = Figure(figsize=(WIDTH, height), dpi=DPI)
        made.text(0.01, 1.0 - 0.07 / height, title, va="top", ha="left", fontsize=13.0, fontweight="bold")
        for number, line in enumerate(lines):
            made.text(0.01, 1.0 - (0.31 + 0.19 * number) / height, line, va="top", ha="left", fontsize=10.0)
        engine = made.get_layout_engine()
        assert isinstance(engine, ConstrainedLayoutEngine)
        engine.set(rect=(0.0, 0.0, 1.0, 1.0 - (0.36 + 0.19 * len(lines)) / height))
        yield made


def save(made: Figure, path: Path) -> Path:
    """Write a PNG, and the same as SVG beside it.

    Raises:
        BadInput: the folder cannot be written.
    """
    write_bytes_atomic(path.with_suffix(".svg"), as_svg(made))
    made.set_layout_engine("none")  # it is laid out: once is enough
    content = io.BytesIO()
    with mpl.rc_context(STYLE):
        made.savefig(content, format="png", dpi=DPI)
    write_bytes_atomic(path, _small(content))
    return path


def _small(content: io.BytesIO) -> bytes:
    """A PNG with a palette: a third of the size; colours of few pixels, such as a cross, stay what they are."""
    few = Image.open(content).convert("RGB").quantize(_COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    out = io.BytesIO()
    few.save(out, format="png", optimize=True)
    return out.getvalue()


def as_svg(made: Figure) -> bytes:
    """A figure as SVG: curves are curves, text is text, and nothing tells of when it was drawn."""
    content = io.BytesIO()
    with mpl.rc_context(STYLE):
        made.savefig(content, format="svg", metadata={"Date": None, "Creator": "gaitsmith"})
    return content.getvalue()


def sampled(recording: Recording, span: slice = slice(None)) -> slice:
    """``span`` thinned to what a figure can show."""
    begin, end, _ = span.indices(len(recording.time))
    return slice(begin, end, max(1, (end - begin) // _POINTS))


def mark_stages(axes: Sequence[Axes], recording: Recording) -> None:
    """Shade every second stage of constant command where there are several, and mark pushes, faults and the fall."""
    stages = recording.stages()
    for index, stage in enumerate(stages):
        if index % 2 and len(stages) > 2:
            for axis in axes:
                axis.axvspan(stage.begin, stage.end, color=BAND, zorder=0, linewidth=0.0)
    mark_events(axes, recording)


def mark_events(axes: Sequence[Axes], recording: Recording) -> None:
    """Pushes and faults as bands, the fall as a line, named in the first panel; faults one line lower."""
    low, high = float(recording.time[0]), float(recording.time[-1])
    marks = [(push.begin, push.end, f"push {push.words}", PUSH, -3.0) for push in recording.pushes]
    marks += [(fault.begin, min(fault.end, high), fault.words, FAULT, -15.0) for fault in recording.faults]
    for number, axis in enumerate(axes):
        for begin, end, words, colour, below in marks:
            if low <= begin <= high:
                axis.axvspan(begin, end, color=colour, alpha=0.4, zorder=1, linewidth=0.0)
                if number == 0 and len(marks) <= _NAMED:
                    axis.annotate(
                        words, (end, 1.0), xycoords=("data", "axes fraction"),
                        xytext=(3.0, below), textcoords="offset points", va="top", fontsize=9.0, color=colour,
                    )  # fmt: skip
        if recording.fell is not None and low <= recording.fell <= high + _ROW:
            axis.axvline(recording.fell, color=BAD, linewidth=1.5, zorder=4)
            if number == 0:
                axis.annotate(
                    "fell", (recording.fell, 0.0), xycoords=("data", "axes fraction"),
                    xytext=(-3.0, 3.0), textcoords="offset points", ha="right", va="bottom", fontsize=9.0, color=BAD,
                )  # fmt: skip


def above(axis: Axes, columns: int) -> None:
    """Put the legend over the plot, where no curve runs."""
    axis.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=columns, handlelength=1.8, columnspacing=1.2)


def in_words(name: str) -> str:
    """A name of a model's file as it is read: without underscores."""
    return name.replace("_", " ")


def sole_corners(sole: Sole) -> npt.NDArray[np.float64]:
    """(n, 2) corners of a sole in its own frame, m; a line is given a width that can be seen."""
    if sole.half_width > 0.0:
        return sole.corners
    wide = np.array([0.0, _LINE_SOLE])
    return np.concatenate([sole.corners - wide, sole.corners[::-1] + wide])
