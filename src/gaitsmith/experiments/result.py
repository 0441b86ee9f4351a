"""What every experiment returns: plain data for programs, words for people."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gaitsmith.files import write_text_atomic

Progress = Callable[[int, int, str], None]
"""Told of the number done, the total, and what is being done."""


def silent(done: int, total: int, what: str) -> None:
    """Progress that nobody watches."""


@dataclass(frozen=True)
class Result:
    """An experiment's outcome.

    Attributes:
        rows: of the table, in words.
        interrupted: whether Ctrl-C cut it short; what was finished is kept and reported.
    """

    document: dict[str, Any]
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    notes: tuple[str, ...] = ()
    interrupted: bool = False

    def write(self, path: Path) -> None:
        """Write the document as JSON.

        Raises:
            BadInput: the folder cannot be written.
        """
        write_text_atomic(path, json.dumps(self.document, indent=2, allow_nan=False, ensure_ascii=False) + "\n")
