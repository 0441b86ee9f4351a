"""What an experiment hands back: pictures, and a row for every sentence of a paper that states a result."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from gaitsmith.reports.rendering import NoRenderer
from gaitsmith.reports.run import Run
from gaitsmith.reports.strip import strip
from gaitsmith.view.canvas import as_svg, save

Tell = Callable[[str], None]
Motion = tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]
"""Times (n,), s, and places (n, 3), m."""
AGREES, CANNOT = "agrees", "cannot be compared"


class Row(NamedTuple):
    """A statement of a paper: its figure, what it says, what we find, and the verdict with its reason."""

    figure: str
    says: str
    ours: str
    verdict: str


class Picture(NamedTuple):
    """A picture of a figure: content, kind, caption."""

    figure: str
    content: bytes
    kind: str
    caption: str


@dataclass
class Found:
    """Pictures and rows of an experiment, in the order of the paper.

    Attributes:
        folder: where each picture is written too.
    """

    folder: Path
    rows: list[Row] = field(default_factory=list)
    pictures: list[Picture] = field(default_factory=list)

    def draw(self, figure: str, made: Figure, caption: str = "", name: str = "") -> None:
        """Take a figure in; its file has the figure's name unless it has its own."""
        self.pictures.append(Picture(figure, as_svg(made), "image/svg+xml", caption))
        save(made, self.folder / f"{name or figure}.png")

    def frames(self, figure: str, run: Run, begin: float, end: float, ball: Motion | None = None) -> None:
        """Take twelve pictures of a run in, with a ball on its way; say so where they cannot be drawn."""
        times = np.linspace(begin, end, 12)
        balls = None if ball is None else np.stack([np.interp(times, ball[0], way) for way in ball[1].T], axis=1)
        try:
            content = strip(run, times, balls)
        except NoRenderer as error:
            self.pictures.append(Picture(figure, b"", "", f"no frames: {error}"))
            return
        caption = f"frames from {begin:.1f} to {end:.1f} s, {times[1] - times[0]:.2f} s apart"
        self.pictures.append(Picture(figure, content, "image/png", caption))
        (self.folder / f"{figure}-frames.png").write_bytes(content)

    def say(self, figure: str, says: str, ours: str, holds: bool | None, why: str = "") -> None:
        """Take a row in; ``why`` is said unless it agrees, and ``holds`` is None where nothing can be compared."""
        verdict = AGREES if holds else f"{CANNOT if holds is None else 'differs'}: {why}"
        self.rows.append(Row(figure, says, ours, verdict))
