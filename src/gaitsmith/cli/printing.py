"""Where tables go: a stream, wide enough for a file, without an opinion on what a closed pipe means."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable
from typing import NoReturn

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment

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


def figure(value: float | None, form: str) -> str:
    """A number as :func:`format` writes it, or a dash for one that does not exist."""
    return "-" if value is None or not math.isfinite(value) else format(value, form)
