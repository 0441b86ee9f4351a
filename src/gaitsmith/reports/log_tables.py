"""A run's log as a table that other programs read: CSV, Parquet, NumPy."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

from gaitsmith.errors import GaitsmithError
from gaitsmith.files import open_regular, replacing
from gaitsmith.log.mcap_file import ChunkReader, Event, Head
from gaitsmith.log.table import write_table

Rows = npt.NDArray[np.float64]
Tell = Callable[[float], None]
NOTES = b"gaitsmith"
"""Key of what was run among a Parquet file's metadata, as JSON."""


class LogSource:
    """A log that is read block by block, however long it is.

    Args:
        tell: hears of the time of the last row read, s.

    Attributes:
        rows: read so far.
        complete: after the last block, whether the log was finished.
        events: read so far.

    Raises:
        BadInput: no such file, or not a log.
    """

    def __init__(self, path: Path, tell: Tell) -> None:
        self._path, self._tell, self.rows, self.complete = path, tell, 0, False
        self.events: list[Event] = []
        with open_regular(path) as file:
            self.head: Head = ChunkReader(file, str(path)).head

    def __iter__(self) -> Iterator[Rows]:
        """Blocks (n, m) of rows, none empty."""
        self.rows = 0
        with open_regular(self._path) as file:
            reader = ChunkReader(file, str(self._path))
            for block in reader:
                if len(block):
                    self.rows += len(block)
                    self._tell(float(block[-1, 0]))
                    yield block
            self.complete, self.events = reader.complete, reader.events


def write_csv(source: LogSource, path: Path) -> None:
    """As :func:`gaitsmith.log.table.write_table`."""
    write_table(path, source.head.columns, source)


def write_npz(source: LogSource, path: Path) -> None:
    """A compressed NumPy archive: ``columns``, ``rows`` (n, m), ``notes``, ``events`` as JSON; whole in memory.

    Raises:
        BadInput: the file cannot be written.
    """
    rows = np.concatenate([np.empty((0, len(source.head.columns))), *source])
    texts = {name: json.dumps(value, allow_nan=False) for name, value in _told(source).items()}
    with replacing(path) as file:
        np.savez_compressed(file, columns=np.array(source.head.columns), rows=rows, **texts)  # type: ignore[arg-type]


def write_parquet(source: LogSource, path: Path) -> None:
    """A Parquet file: one column of doubles a name, notes and events as JSON among the metadata.

    Raises:
        BadInput: the file cannot be written.
        GaitsmithError: PyArrow is not installed.
    """
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise GaitsmithError("Parquet needs PyArrow: pip install 'gaitsmith[logs]'") from None
    schema = pyarrow.schema([(name, pyarrow.float64()) for name in source.head.columns])
    with replacing(path) as file, parquet.ParquetWriter(file, schema, compression="zstd") as writer:
        for block in source:
            writer.write_table(pyarrow.table([np.ascontiguousarray(column) for column in block.T], schema=schema))
        writer.add_key_value_metadata({NOTES: json.dumps(_told(source), allow_nan=False)})


def _told(source: LogSource) -> dict[str, object]:
    """What was run and what was told, as plain data."""
    return {"notes": source.head.notes, "events": list(source.events)}
