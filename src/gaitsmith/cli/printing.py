"""Where tables go: a stream, wide enough for a file, without an opinion on what a closed pipe means."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from typing import Literal, NoReturn

from rich.box import SIMPLE_HEAD
from rich.console import Console, ConsoleOptions, RenderableType
from rich.measure import Measurement
from rich.segment import Segment
from rich.table import Table as RichTable

from gaitsmith.cli.dispatch import Styled, Table, printable

_WIDE = 140  # columns when the output is no terminal
_FREE = 100_000  # columns of a table that nothing narrows


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
    """Print a table or a styled line on stdout.

    What is wider than the terminal goes below, under the first column once more: no number is cut.
    """
    printer = Printer()
    if isinstance(item, Styled):
        printer.print(item.line, style=item.style, soft_wrap=True)
        return
    rows, parts, free = list(item.rows), [[0]], printer.options.update(max_width=_FREE)
    for index in range(1, len(item.headings)):
        wider = _made(item, rows, [*parts[-1], index])
        if len(parts[-1]) > 1 and Measurement.get(printer, free, wider).maximum > printer.width:
            parts.append([0, index])
        else:
            parts[-1].append(index)
    for number, part in enumerate(parts):
        printer.print(_made(item, rows, part, "" if number else item.title))


def _made(item: Table, rows: Sequence[Sequence[str]], columns: Sequence[int], title: str = "") -> RichTable:
    """Some columns of a table."""
    made = RichTable(box=SIMPLE_HEAD, title=title or None, title_justify="left")
    for index in columns:
        justify: Literal["left", "right"] = "left" if index in item.left else "right"
        made.add_column(item.headings[index], justify=justify, overflow="fold")
    for row in rows:
        made.add_row(*(row[index] for index in columns), style="red" if row[0] in item.red else None)
    return made
