"""The log of a run: a ring of rows in the loop, an MCAP file on disk, and the way back.

The file has one channel, ``/gaitsmith``, with one message per row: CDR-encoded 64-bit floats under a ``ros2msg``
schema, which Foxglove and the ROS 2 tools read. Log time is simulated time in ns.
"""

from __future__ import annotations

import io
import json
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.files import read_bounded, write_bytes_atomic

TOPIC = "/gaitsmith"
_SCHEMA = "gaitsmith/msg/Tick"
_NOTES = "gaitsmith"
_CDR_LITTLE_ENDIAN = b"\x00\x01\x00\x00"
_LARGEST = 2_000_000_000  # bytes of a log file that is read back


@dataclass(frozen=True)
class Log:
    """Rows of a run, oldest first.

    Attributes:
        columns: names; the first is ``time``, s. What the plant knows to be true begins with ``true.``.
        rows: (n, m).
        decimation: control ticks per row.
        dropped: rows that the ring had to give up because the run was longer than it.
        notes: what was run, as plain data: the scenario, the version.
    """

    columns: tuple[str, ...]
    rows: npt.NDArray[np.float64]
    decimation: int = 1
    dropped: int = 0
    notes: dict[str, Any] = field(default_factory=dict)

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
        write_bytes_atomic(path, _encode(self))


class Recorder:
    """Keeps rows during a run in memory that is allocated once.

    Args:
        telemetry: (a,) buffer that holds the controller's numbers, the time first.
        observed: (b,) buffer that holds the plant's.
        columns: names of all a + b numbers.
        ticks: length of the run in control ticks.
        decimation: control ticks per row.
        capacity: most rows kept; a longer run keeps the latest ones.
    """

    def __init__(
        self,
        telemetry: npt.NDArray[np.float64],
        observed: npt.NDArray[np.float64],
        columns: tuple[str, ...],
        ticks: int,
        decimation: int = 4,
        capacity: int = 150_000,
    ) -> None:
        self._telemetry, self._observed = telemetry, observed
        self._split = len(telemetry)
        self._columns = columns
        self.decimation = decimation
        self._ring = np.empty((max(1, min(capacity, ticks // decimation + 1)), len(columns)))
        self._count = 0

    def keep(self, tick: int) -> None:
        """Copy the present row if its turn has come."""
        if tick % self.decimation:
            return
        row = self._ring[self._count % len(self._ring)]
        row[: self._split] = self._telemetry
        row[self._split :] = self._observed
        self._count += 1

    def log(self, notes: dict[str, Any]) -> Log:
        """What has been kept so far."""
        size = len(self._ring)
        first = max(0, self._count - size)
        rows = self._ring[np.arange(first, self._count) % size]
        return Log(self._columns, rows, self.decimation, first, notes)


def field_names(columns: tuple[str, ...]) -> list[str]:
    """Columns as field names of a message: lower case, digits and single underscores, no two alike."""
    names: list[str] = []
    for column in columns:
        base = re.sub(r"[^a-z0-9]+", "_", column.lower()).strip("_") or "field"
        base = base if base[0].isalpha() else "f_" + base
        name, k = base, 2
        while name in names:
            name, k = f"{base}_{k}", k + 1
        names.append(name)
    return names


def _encode(log: Log) -> bytes:
    """A log as the bytes of an MCAP file."""
    from mcap.writer import CompressionType, Writer

    file = io.BytesIO()
    writer = Writer(file, compression=CompressionType.ZSTD, chunk_size=4 << 20)
    writer.start(profile="", library="gaitsmith")
    text = "".join(f"float64 {name}\n" for name in field_names(log.columns))
    schema = writer.register_schema(name=_SCHEMA, encoding="ros2msg", data=text.encode())
    channel = writer.register_channel(topic=TOPIC, message_encoding="cdr", schema_id=schema)
    stamps = np.round(log.time * 1e9).astype(np.int64).clip(min=0).tolist()
    content = np.ascontiguousarray(log.rows, dtype="<f8")
    for k, stamp in enumerate(stamps):
        writer.add_message(channel, stamp, _CDR_LITTLE_ENDIAN + content[k].tobytes(), stamp, k)
    notes = {"decimation": log.decimation, "dropped": log.dropped, "columns": log.columns, "notes": log.notes}
    writer.add_metadata(_NOTES, {name: json.dumps(value) for name, value in notes.items()})
    writer.finish()
    return file.getvalue()


def read_log(path: str | Path) -> Log:
    """Log that :meth:`Log.write` wrote.

    Raises:
        BadInput: no such file, or not a whole log of this project.
    """
    from mcap.reader import make_reader

    content = read_bounded(path, _LARGEST)
    valid = "a whole MCAP file written by gaitsmith"
    try:
        reader = make_reader(io.BytesIO(content))
        found = {record.name: record.metadata for record in reader.iter_metadata()}
        notes = {name: json.loads(value) for name, value in found[_NOTES].items()}
        columns = tuple(notes["columns"])
        head, size = len(_CDR_LITTLE_ENDIAN), 8 * len(columns)
        parts = [message.data[head : head + size] for _, _, message in reader.iter_messages(topics=TOPIC)]
        rows = np.frombuffer(b"".join(parts), dtype="<f8").reshape(len(parts), len(columns)).astype(np.float64)
        return Log(columns, rows, int(notes["decimation"]), int(notes["dropped"]), dict(notes["notes"]))
    except Exception as error:  # what a damaged file raises depends on where the damage is
        raise BadInput(str(path), type(error).__name__, valid) from None
