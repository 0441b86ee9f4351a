"""Plain results on disk by key, one JSON line each, so that an experiment goes on where it stopped."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from gaitsmith.errors import BadInput
from gaitsmith.files import read_bounded, reason

_MAX_BYTES = 2**30


class Lines:
    """Results by key, in a file of a folder.

    Args:
        folder: created if it is not there.
        name: of the file.

    Attributes:
        path: of the file.
        damaged: lines that could not be read.

    Raises:
        BadInput: the folder cannot be created, or the file cannot be read.
    """

    def __init__(self, folder: str | Path, name: str) -> None:
        try:
            Path(folder).mkdir(parents=True, exist_ok=True)
        except (OSError, ValueError) as error:
            raise BadInput("--out", str(folder), "a folder that can be created", reason(error)) from None
        self.path, self.damaged = Path(folder).resolve() / name, 0
        self._found: dict[str, Any] = {}
        for line in (read_bounded(self.path, _MAX_BYTES) if self.path.exists() else b"").splitlines():
            try:
                record = json.loads(line)
                self._found[str(record["key"])] = record["value"]
            except (ValueError, TypeError, KeyError, RecursionError):
                self.damaged += 1

    def __contains__(self, key: str) -> bool:
        return key in self._found

    def __getitem__(self, key: str) -> Any:
        return self._found[key]

    def add(self, key: str, value: Any) -> None:
        """Append one result.

        Raises:
            BadInput: the file cannot be written.
        """
        line = json.dumps({"key": key, "value": value}, allow_nan=False).encode() + b"\n"
        try:
            with open(self.path, "ab") as file:
                file.write(line)
                os.fsync(file.fileno())
        except OSError as error:
            raise BadInput(str(self.path), reason(error), "a file that can be written") from None
        self._found[key] = value
