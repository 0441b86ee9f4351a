"""Finished work on disk, one line each, so that an experiment goes on where it stopped."""

from __future__ import annotations

import contextlib
import json
import os
from pathlib import Path
from typing import Any

from gaitsmith.errors import BadInput
from gaitsmith.files import read_bounded, reason
from gaitsmith.simulation.scenario import Scenario
from gaitsmith.simulation.summary import Summary

FILE = "episodes.jsonl"
_MAX_BYTES = 2**30


class Lines(dict[str, Any]):
    """Results by key, in a file of a folder.

    A line is appended in one write, so a crash can only leave a last line without its end; that line and any other
    that cannot be read are passed over and counted. Lines with keys that nobody asks for do no harm.

    Args:
        folder: created if it is not there.

    Attributes:
        damaged: lines that could not be read.

    Raises:
        BadInput: the folder cannot be created or written, or the file is not one or is over 1 GiB.
    """

    def __init__(self, folder: str | Path, name: str) -> None:
        super().__init__()
        given = Path(folder)
        try:
            given.mkdir(parents=True, exist_ok=True)
        except (OSError, ValueError) as error:
            raise BadInput("--out", str(folder), "a folder that can be created", reason(error)) from None
        self.path = given.resolve() / name
        if not os.access(self.path if self.path.exists() else given, os.W_OK):
            raise BadInput("--out", str(folder), "a folder that can be written", "choose another place")
        content = read_bounded(self.path, _MAX_BYTES) if os.path.lexists(self.path) else b""
        self.damaged, self._open_ended = 0, bool(content) and not content.endswith(b"\n")
        for line in filter(bytes.strip, content.split(b"\n")):
            try:
                record = json.loads(line)
                self[str(record["key"])] = self._value(record)
            except (ValueError, TypeError, KeyError, RecursionError):  # pydantic's is a ValueError
                self.damaged += 1

    def _value(self, record: dict[str, Any]) -> Any:
        return record["value"]

    def keep(self, key: str, value: Any) -> None:
        """Append one plain result; it is on disk when this returns.

        Raises:
            BadInput: the file cannot be written.
        """
        self._append(key, {"value": value})
        self[key] = value

    def _append(self, key: str, fields: dict[str, Any]) -> None:
        line = json.dumps({"key": key, **fields}, allow_nan=False, separators=(",", ":")).encode() + b"\n"
        try:
            handle = os.open(self.path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o666)
            try:
                self._write(handle, (b"\n" if self._open_ended else b"") + line)
            finally:
                os.close(handle)
        except OSError as error:
            raise BadInput(str(self.path), reason(error), "a file that can be written") from None
        self._open_ended = False

    def _write(self, handle: int, line: bytes) -> None:
        """One write; if the disk takes only a part, the rest of the line is given up as damaged."""
        self._open_ended = True  # true of every moment until the whole line is there
        if os.write(handle, line) != len(line):
            raise OSError(0, "the disk is full")
        with contextlib.suppress(OSError):
            os.fsync(handle)


class Store(Lines):
    """Summaries of finished episodes by key, in ``episodes.jsonl`` of a folder; see :class:`Lines`."""

    def __init__(self, folder: str | Path) -> None:
        super().__init__(folder, FILE)

    def _value(self, record: dict[str, Any]) -> Summary:
        return Summary.model_validate_json(json.dumps(record["summary"]))

    def add(self, key: str, scenario: Scenario, summary: Summary) -> None:
        """Append one finished episode, as :meth:`keep` does."""
        fields = {"scenario": scenario.model_dump(mode="json"), "summary": summary.model_dump(mode="json")}
        self._append(key, fields)
        self[key] = summary
