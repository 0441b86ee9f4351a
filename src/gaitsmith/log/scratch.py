"""Where a log is written: a file with a name, or one that goes with its last user."""

from __future__ import annotations

import io
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

from gaitsmith.errors import BadInput
from gaitsmith.log.record import Log, read_log, read_stream


class Scratch(io.FileIO):
    """A file without a name that goes with its last user."""

    def __del__(self) -> None:
        self.close()


def new_file(record: bool | str | Path | Callable[[], BinaryIO]) -> BinaryIO:
    """A file for the log, readable too."""
    if callable(record):
        return record()
    try:
        if record is True:
            handle, name = tempfile.mkstemp(prefix="gaitsmith.")
            os.unlink(name)
            return Scratch(handle, "r+b")
        return open(record, "x+b", buffering=0)
    except OSError as error:
        raise BadInput(
            str(record), (error.strerror or "").lower(), "a new file in a folder that can be written"
        ) from None


def read_back(file: BinaryIO) -> Log:
    """The rows in a file that is closed and has a name, or stays open for more to come."""
    if file.closed:
        return read_log(file.name)
    place = file.tell()
    file.seek(0)
    try:
        return read_stream(file, "log")
    finally:
        file.seek(place)
