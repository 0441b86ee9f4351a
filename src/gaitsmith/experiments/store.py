"""Finished episodes on disk, one line each, so that an experiment goes on where it stopped."""

from __future__ import annotations

import contextlib
import json
import os
from pathlib import Path

from pydantic import ValidationError

from gaitsmith.errors import BadInput
from gaitsmith.files import read_bounded, reason
from gaitsmith.simulation.scenario import Scenario
from gaitsmith.simulation.summary import Summary

FILE = "episodes.jsonl"
_MAX_BYTES = 2**30


class Store:
    """Summaries of finished episodes by key, in ``episodes.jsonl`` of a folder.

    A line is appended in one write, so a crash can only leave a last line without its end; that line and any other
    that cannot be read are passed over and counted. Lines with keys that nobody asks for do no harm.

    Args:
        folder: created if it is not there.

    Attributes:
        path: of the file.
        damaged: lines that could not be read.

    Raises:
        BadInput: the folder cannot be created or written, or the file is not one or is over 1 GiB.
    """

    def __init__(self, folder: str | Path) -> None:
        given = Path(folder)
        try:
            given.mkdir(parents=True, exist_ok=True)
        except (OSError, ValueError) as error:
            raise BadInput("--out", str(folder), "a folder that can be created", reason(error)) from None
        self.path = given.resolve() / FILE
        if not os.access(self.path if self.path.exists() else given, os.W_OK):
            raise BadInput("--out", str(folder), "a folder that can be written", "choose another place")
        self.damaged = 0
        self._found: dict[str, Summary] = {}
        content = read_bounded(self.path, _MAX_BYTES) if os.path.lexists(self.path) else b""
        self._open_ended = bool(content) and not content.endswith(b"\n")
        for line in content.split(b"\n"):
            if line.strip():
                self._take(line)

    def _take(self, line: bytes) -> None:
        """Keep one line's summary, or count the line as damaged."""
        try:
            record = json.loads(line)
            self._found[str(record["key"])] = Summary.model_validate_json(json.dumps(record["summary"]))
        except (ValueError, TypeError, KeyError, RecursionError, ValidationError):
            self.damaged += 1

    def __len__(self) -> int:
        return len(self._found)

    def get(self, key: str) -> Summary | None:
        """Summary of the episode with this key, None if it has not been run."""
        return self._found.get(key)

    def add(self, key: str, scenario: Scenario, summary: Summary) -> None:
        """Append one finished episode; it is on disk when this returns.

        Raises:
            BadInput: the file cannot be written.
        """
        record = {"key": key, "scenario": scenario.model_dump(mode="json"), "summary": summary.model_dump(mode="json")}
        line = json.dumps(record, allow_nan=False, separators=(",", ":")).encode() + b"\n"
        try:
            handle = os.open(self.path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o666)
            try:
                self._write(handle, (b"\n" if self._open_ended else b"") + line)
            finally:
                os.close(handle)
        except OSError as error:
            raise BadInput(str(self.path), reason(error), "a file that can be written") from None
        self._open_ended = False
        self._found[key] = summary

    def _write(self, handle: int, line: bytes) -> None:
        """One write; if the disk takes only a part, the rest of the line is given up as damaged."""
        self._open_ended = True  # true of every moment until the whole line is there
        if os.write(handle, line) != len(line):
            raise OSError(0, "the disk is full")
        with contextlib.suppress(OSError):
            os.fsync(handle)
