"""Where tables go: stdout, wide enough for a file, and without an opinion on what a closed pipe means."""

from __future__ import annotations

import sys
from typing import NoReturn

from rich.console import Console

_WIDE = 140  # columns when the output is no terminal


class Printer(Console):
    """A console on stdout."""

    def __init__(self) -> None:
        super().__init__(file=sys.stdout, highlight=False, markup=False, soft_wrap=False)
        if not self.is_terminal:
            self.width = _WIDE

    def on_broken_pipe(self) -> NoReturn:
        """Leave the exit code to the command; the base class would exit with 1, which means a fall here."""
        raise BrokenPipeError
