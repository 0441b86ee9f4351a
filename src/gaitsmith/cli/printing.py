"""Where tables go: a stream, wide enough for a file, without an opinion on what a closed pipe means."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import NoReturn

from rich.box import SIMPLE_HEAD
from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.table import Table as RichTable

from gaitsmith.cli.dispatch import Styled, Table, printable

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


def print_rich(item: Table | Styled) -> None:
    """Print a table or a styled line on stdout."""
    if isinstance(item, Styled):
        Printer().print(item.line, style=item.style, soft_wrap=True)
        return
    made = RichTable(box=SIMPLE_HEAD, title=item.title or None, title_justify="left")
    for index, heading in enumerate(item.headings):
        made.add_column(heading, justify="left" if index in item.left else "right")
    for row in item.rows:
        made.add_row(*row, style="red" if row[0] in item.red else None)
    Printer().print(made)
