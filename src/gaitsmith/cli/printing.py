"""Where tables go: a stream, wide enough for a file, without an opinion on what a closed pipe means."""

from __future__ import annotations

import math
import sys
from collections.abc import Container, Iterable, Sequence
from typing import NoReturn

from rich.box import SIMPLE_HEAD
from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.table import Table

from gaitsmith.cli.dispatch import printable

_WIDE = 140  # columns when the output is no terminal


class Printer(Console):
    """A console on stdout, or on stderr; control characters in what is printed become question marks."""

    def __init__(self, stderr: bool = False) -> None:
        stream = sys.stderr if stderr else sys.stdout
        super().__init__(file=stream, highlight=False, markup=False, soft_wrap=False)
        if not self.is_terminal:
            self.width = _WIDE

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        """Everything printed comes through here, the cells of tables included."""
        for segment in super().render(renderable, options):
            yield segment if segment.control else Segment(printable(segment.text), segment.style)

    def on_broken_pipe(self) -> NoReturn:
        """Leave the exit code to the command; the base class would exit with 1, which means a fall here."""
        raise BrokenPipeError


def table(
    headings: Sequence[str],
    rows: Iterable[Sequence[str]],
    left: Sequence[int] = (0,),
    title: str = "",
    red: Container[str] = (),
) -> Table:
    """A table of words; the columns numbered in ``left`` hold words, the others numbers; rows named in ``red`` are."""
    made = Table(box=SIMPLE_HEAD, title=title or None, title_justify="left")
    for index, heading in enumerate(headings):
        made.add_column(heading, justify="left" if index in left else "right")
    for row in rows:
        made.add_row(*row, style="red" if row[0] in red else None)
    return made


def figure(value: float | None, form: str) -> str:
    """A number as :func:`format` writes it, or a dash for one that does not exist."""
    return "-" if value is None or not math.isfinite(value) else format(value, form)
