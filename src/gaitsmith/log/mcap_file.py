"""The format of a log on disk: MCAP, written chunk by chunk and read up to where it was cut.

``/gaitsmith`` has one message per row: CDR-encoded 64-bit floats under a ``ros2msg`` schema, which Foxglove and the
ROS 2 tools read. ``/gaitsmith/events`` has one JSON message for everything that was told to the loop or that happened
in it once. Further topics hold what other programs draw; nothing is read back from them. Log time is simulated time in
ns. Columns and notes stand in a metadata record before the first chunk, so that a file that ends anywhere behind it can
be read.
"""

from __future__ import annotations

import io
import json
import re
import struct
import zlib
from collections.abc import Iterator
from typing import Any, BinaryIO, NamedTuple

import numpy as np
import numpy.typing as npt
import zstandard
from mcap import records as mcap
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode

from gaitsmith.errors import BadInput

FORMAT = 3
"""Version of the format: 1 had its columns and notes at the end, 2 had no further topics."""
TOPIC, EVENTS = "/gaitsmith", "/gaitsmith/events"
MAGIC = b"\x89MCAP0\r\n"
NOTES = "gaitsmith"
"""Name of the metadata record."""
ROWS, TOLD = 1, 2
"""Channels; others follow."""
HEAD = struct.Struct("<BQ")  # opcode and length, before every record
MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time
_CDR_LITTLE_ENDIAN = b"\x00\x01\x00\x00"
_LARGEST = 1 << 28  # bytes of a record, packed or unpacked, that is read back
_DAMAGE = (
    AttributeError,
    KeyError,
    TypeError,
    ValueError,
    RecursionError,
    struct.error,
    McapError,
    zstandard.ZstdError,
)
Event = dict[str, Any]


class Head(NamedTuple):
    """What stands before the first row.

    Attributes:
        columns: names of a row's numbers; the first is the time, s.
        decimation: control ticks per row.
        dropped: rows that are missing.
        notes: what was run, as plain data.
    """

    columns: tuple[str, ...]
    decimation: int = 1
    dropped: int = 0
    notes: dict[str, Any] = {}  # noqa: RUF012


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


def message_rows(columns: int, count: int) -> npt.NDArray[Any]:
    """(count,) messages of the rows' channel, whose field ``row`` (columns,) can be filled in place."""
    fields = [("opcode", "u1"), ("length", "<u8"), ("channel", "<u2"), ("sequence", "<u4"), ("stamp", "<u8")]
    made = np.zeros(count, [*fields, ("published", "<u8"), ("kind", "V4"), ("row", "<f8", (columns,))])
    made["opcode"], made["channel"] = Opcode.MESSAGE, ROWS
    made["length"] = made.dtype.itemsize - HEAD.size
    made["kind"] = np.void(_CDR_LITTLE_ENDIAN)
    return made


class ChunkReader:
    """Reads a log from its beginning, a chunk at a time; iterating gives (n, m) rows.

    Args:
        file: at its beginning.
        source: its name in errors.

    Attributes:
        head: columns and notes.
        events: what has been told so far.
        attachments: files in the log that have been met so far.
        complete: after the last row, whether the file was finished; else it was cut or damaged behind that row.
        damaged: after the last row, whether there is more behind it that cannot be reached; a cut leaves nothing there.

    Raises:
        BadInput: not a log, cut before its first row, or from a newer version.
    """

    def __init__(self, file: BinaryIO, source: str) -> None:
        self._file, self.events, self.complete, self.damaged = file, list[Event](), False, False
        self.attachments: list[mcap.Attachment] = []
        valid = "a log written by gaitsmith"
        if file.read(len(MAGIC)) != MAGIC:
            raise BadInput(source, "something else", valid)
        try:
            notes = next(found for opcode, content in _records(file) if (found := _notes(opcode, content)))
            if notes.get("format", 1) > FORMAT:
                remedy = "update gaitsmith to read it"
                raise BadInput(source, f"format {notes['format']}", f"at most format {FORMAT}", remedy)
            columns = tuple(map(str, notes["columns"]))
            self.head = Head(columns, int(notes["decimation"]), int(notes["dropped"]), dict(notes["notes"]))
        except StopIteration:
            raise BadInput(source, "a file without columns", valid, "it was cut before its first row") from None
        except _DAMAGE as error:
            raise BadInput(source, type(error).__name__, valid) from None

    def __iter__(self) -> Iterator[npt.NDArray[np.float64]]:
        """Blocks of rows up to the last whole chunk."""
        for _, rows in self.chunks():
            yield from rows

    def chunks(self) -> Iterator[tuple[bytes, list[npt.NDArray[np.float64]]]]:
        """Content and blocks of rows of every chunk, up to the last whole one."""
        yield from self._whole_chunks()
        self.damaged = not self.complete and self._goes_on()

    def _goes_on(self) -> bool:
        """Whether chunks, or the end of a finished file, follow what cannot be read."""
        if any(opcode == Opcode.CHUNK for opcode, _ in _records(self._file)):
            return True
        self._file.seek(max(0, self._file.seek(0, io.SEEK_END) - len(MAGIC)))
        return self._file.read() == MAGIC

    def _whole_chunks(self) -> Iterator[tuple[bytes, list[npt.NDArray[np.float64]]]]:
        self._file.seek(len(MAGIC))
        pattern = message_rows(len(self.head.columns), 1)[0]
        indexed = {ROWS}  # channels whose index has been met since the last chunk
        for opcode, content in _records(self._file):
            if opcode == Opcode.MESSAGE_INDEX:
                channel = int.from_bytes(content[:2], "little")
                if channel in indexed:  # the chunk before it was not known as one
                    return
                indexed.add(channel)
            elif opcode == Opcode.CHUNK:
                indexed.clear()
                try:
                    unpacked = _unpacked(content)
                    rows = [part for part in _messages(unpacked, pattern, self.events) if len(part)]
                except _DAMAGE:
                    return
                yield unpacked, rows
            elif opcode == Opcode.ATTACHMENT:
                try:
                    self.attachments.append(mcap.Attachment.read(ReadDataStream(io.BytesIO(content))))
                except _DAMAGE:
                    return
            elif opcode == Opcode.FOOTER:
                self.complete = self._file.read() == MAGIC


def _records(file: BinaryIO) -> Iterator[tuple[int, bytes]]:
    """Opcode and content of every whole record."""
    while len(start := file.read(HEAD.size)) == HEAD.size:
        opcode, length = HEAD.unpack(start)
        if length > _LARGEST or len(content := file.read(length)) < length:
            return
        yield opcode, content


def _notes(opcode: int, content: bytes) -> dict[str, Any]:
    """This package's metadata, if the record is that."""
    if opcode != Opcode.METADATA:
        return {}
    found = mcap.Metadata.read(ReadDataStream(io.BytesIO(content)))
    return {name: json.loads(value) for name, value in found.metadata.items()} if found.name == NOTES else {}


def _unpacked(content: bytes) -> bytes:
    """What a chunk holds.

    Raises:
        ValueError: it is damaged.
    """
    chunk = mcap.Chunk.read(ReadDataStream(io.BytesIO(content)))
    if chunk.uncompressed_size > _LARGEST or chunk.compression != "zstd":
        raise ValueError(chunk.compression)
    unpacked = zstandard.ZstdDecompressor().decompress(chunk.data, max_output_size=chunk.uncompressed_size)
    if zlib.crc32(unpacked) != chunk.uncompressed_crc:
        raise ValueError("checksum")
    return unpacked


def _messages(content: bytes, pattern: Any, events: list[Event]) -> Iterator[npt.NDArray[np.float64]]:
    """Stretches of rows in a chunk; what else was told goes to ``events``."""
    at, size = 0, pattern.dtype.itemsize
    while at < len(content):
        opcode, length = HEAD.unpack_from(content, at)
        end = at + HEAD.size + length
        if end > len(content):
            raise ValueError("a message beyond its chunk")
        channel = MESSAGE.unpack_from(content, at + HEAD.size)[0] if opcode == Opcode.MESSAGE else 0
        if channel == ROWS:
            if length != pattern["length"]:
                raise ValueError("a row of another length")
            found = np.frombuffer(content, pattern.dtype, (len(content) - at) // size, at)
            alike = np.ones(len(found), bool)
            for name in ("opcode", "length", "channel"):
                alike &= found[name] == pattern[name]
            count = len(found) if alike.all() else int(np.argmin(alike))
            yield np.asarray(found["row"][:count], dtype=np.float64)
            end = at + count * size
        elif channel == TOLD:
            events.append(dict(json.loads(content[at + HEAD.size + MESSAGE.size : end])))
        at = end
