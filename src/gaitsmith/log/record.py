"""The log of a run: rows written to disk while it goes, and the way back."""

from __future__ import annotations

import contextlib
import io
import os
import tempfile
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO, Protocol

import numpy as np
import numpy.typing as npt
from mcap.records import Attachment

from gaitsmith.errors import BadInput
from gaitsmith.files import deferred, open_regular, reason, replacing
from gaitsmith.log.mcap_file import ChunkReader, Event, Head, message_rows
from gaitsmith.log.mcap_writer import ChunkWriter, Messages, Topic

DECIMATION = 4
"""Control ticks per row."""
_EVERY = 0.5  # s of wall time after which rows go to disk
_CAPACITY = 2048  # rows after which they do in any case


@dataclass(frozen=True)
class Log:
    """Rows of a run, oldest first.

    Attributes:
        columns: names; the first is ``time``, s. What the plant knows to be true begins with ``true.``.
        rows: (n, m).
        decimation: control ticks per row.
        dropped: rows that are missing.
        notes: what was run, as plain data: the scenario, the robot.
        events: what was told to the controller, and pushes, each with its ``time``, s.
        complete: whether the file was finished; a run that was killed leaves one that was not.
        damaged: whether more rows follow that cannot be read, because the file has changed.
    """

    columns: tuple[str, ...]
    rows: npt.NDArray[np.float64]
    decimation: int = 1
    dropped: int = 0
    notes: dict[str, Any] = field(default_factory=dict)
    events: tuple[Event, ...] = ()
    complete: bool = True
    damaged: bool = False

    @property
    def time(self) -> npt.NDArray[np.float64]:
        """(n,) s since the beginning of the run."""
        return self.rows[:, 0]

    def column(self, name: str) -> npt.NDArray[np.float64]:
        """(n,) values of one column.

        Raises:
            BadInput: no such column.
        """
        if name not in self.columns:
            raise BadInput("column", name, "one of " + ", ".join(self.columns))
        return self.rows[:, self.columns.index(name)]

    def write(self, path: str | Path) -> None:
        """Write the log as MCAP; the file appears whole or not at all.

        Raises:
            BadInput: the file cannot be written.
        """
        with replacing(path) as file:
            writer = ChunkWriter(file, Head(self.columns, self.decimation, self.dropped, self.notes))
            writer.write_rows(self.rows[:0], self.events)
            for first in range(0, len(self.rows), _CAPACITY):
                writer.write_rows(self.rows[first : first + _CAPACITY])
            writer.finish()


class Scene(Protocol):
    """What other programs draw of a run, made from its rows."""

    @property
    def topics(self) -> Sequence[Topic]:
        """That it fills."""
        ...

    @property
    def attachment(self) -> Attachment | None:
        """File that goes with the log; None without one."""
        ...

    def begin(self) -> Sequence[Messages]:
        """What does not change, once."""
        ...

    def show(self, rows: npt.NDArray[np.float64]) -> Sequence[Messages]:
        """What is seen in (n, m) rows, n not 0."""
        ...


class Recorder:
    """Writes rows while a run goes: what is older than half a second of wall time is on disk.

    Args:
        file: unbuffered, at its beginning; stays the caller's to close.
        sources: buffers that hold a row's numbers, one after the other; the first number is the time, s.
        notes: what is run, as plain data.
        decimation: control ticks per row.
        scene: what other programs draw; nothing without one.
        clock: monotonic, s.

    Attributes:
        dropped: rows that came after :meth:`close`.
        closed: whether the file is complete.

    Raises:
        BadInput: the disk is full.
    """

    def __init__(
        self,
        file: BinaryIO,
        sources: Sequence[npt.NDArray[np.float64]],
        columns: tuple[str, ...],
        notes: dict[str, Any],
        decimation: int = DECIMATION,
        scene: Scene | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.decimation, self.dropped, self.closed, self._clock = decimation, 0, False, clock
        self._messages = message_rows(len(columns), _CAPACITY)
        self._rows = np.zeros((_CAPACITY, len(columns)))
        ends = np.cumsum([len(source) for source in sources]).tolist()
        self._sources = [(slice(end - len(source), end), source) for end, source in zip(ends, sources, strict=True)]
        self._count, self._events = 0, list[Event]()
        self._written_until, self._flushed = 0.0, clock()
        self._scene, self._others = scene, [] if scene is None else list(scene.begin())
        with self._disk():
            self._writer = ChunkWriter(file, Head(columns, decimation, 0, notes), () if scene is None else scene.topics)
            if scene is not None and scene.attachment is not None:
                self._writer.attach(scene.attachment)

    @property
    def rows(self) -> int:
        """Rows kept so far."""
        return self._writer.rows + self._count

    def observe(self, tick: int) -> bool:
        """Take the present row if its turn has come; never ends the run.

        Raises:
            BadInput: the disk is full; what was written before can be read.
        """
        if tick % self.decimation:
            return False
        if self.closed:
            self.dropped += 1
            return False
        row = self._rows[self._count]
        for place, source in self._sources:
            row[place] = source
        self._count += 1
        if self._count == _CAPACITY or self._clock() - self._flushed >= _EVERY:
            self.flush()
        return False

    def hear(self, event: Mapping[str, Any]) -> None:
        """Keep something that happened once; ``event`` has its ``time``, s."""
        if not self.closed:
            self._events.append(dict(event))

    def flush(self) -> None:
        """Write what has been kept.

        Raises:
            BadInput: the disk is full; what was written before can be read.
        """
        with self._disk():
            kept = self._messages[: self._count]
            kept["row"] = self._rows[: self._count]
            if self._scene is not None and self._count:
                self._others += self._scene.show(self._rows[: self._count])
            if self._count or self._events:
                self._writer.write(kept, self._events, self._others)
                self._others = []
            if self._count:
                self._written_until = float(self._rows[self._count - 1, 0])
            self._count, self._events, self._flushed = 0, [], self._clock()

    def close(self) -> None:
        """Write the rest and finish the file.

        Raises:
            BadInput: the disk is full.
        """
        if self.closed:
            return
        self.flush()
        with self._disk():
            self._writer.finish()
            self.closed = True

    @contextlib.contextmanager
    def _disk(self) -> Iterator[None]:
        """Writing in one piece, to a file that may take no more."""
        try:
            with deferred():
                yield
        except OSError as error:
            kept = f"the log is kept up to {self._written_until:.3f} s"
            raise BadInput("log", reason(error), "a disk with room for it", kept) from None


def read_log(path: str | Path, last: int | None = None) -> Log:
    """Log that a run or :meth:`Log.write` wrote, as far as it is whole; :attr:`Log.complete` says whether it is.

    Args:
        last: most rows to keep in memory, the latest ones; None keeps all.

    Raises:
        BadInput: no such file, not a log, one cut before its first row, or one from a newer version.
    """
    with open_regular(path) as file:
        return read_stream(file, str(path), last)


def read_stream(file: BinaryIO, source: str, last: int | None = None) -> Log:
    """As :func:`read_log`, from a file that is open, at its beginning."""
    reader = ChunkReader(file, source)
    blocks: deque[npt.NDArray[np.float64]] = deque()
    count = 0
    for block in reader:
        blocks.append(block)
        count += len(block)
        while last is not None and count - len(blocks[0]) >= last:
            count -= len(blocks.popleft())
    columns, decimation, dropped, notes = reader.head
    rows = np.concatenate([np.empty((0, len(columns))), *blocks])
    rows = rows if last is None else rows[max(0, len(rows) - last) :]
    return Log(columns, rows, decimation, dropped, notes, tuple(reader.events), reader.complete, reader.damaged)


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
        raise BadInput(str(record), reason(error), "a new file in a folder that can be written") from None


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
