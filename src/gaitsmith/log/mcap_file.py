"""The format of a log on disk: MCAP, written chunk by chunk and read up to where it was cut.

The file has two channels. ``/gaitsmith`` has one message per row: CDR-encoded 64-bit floats under a ``ros2msg``
schema, which Foxglove and the ROS 2 tools read. ``/gaitsmith/events`` has one JSON message for everything that was
told to the loop or that happened in it once. Log time is simulated time in ns. Columns and notes stand in a metadata
record before the first chunk, so that a file that ends anywhere behind it can be read.
"""

from __future__ import annotations

import io
import json
import re
import struct
import zlib
from array import array
from collections.abc import Iterator, Sequence
from typing import Any, BinaryIO, NamedTuple

import numpy as np
import numpy.typing as npt
import zstandard
from mcap import records as mcap
from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.exceptions import McapError
from mcap.opcode import Opcode

from gaitsmith.errors import BadInput

FORMAT = 2
"""Version of the format: 1 had its columns and notes at the end."""
TOPIC, EVENTS = "/gaitsmith", "/gaitsmith/events"
_MAGIC = b"\x89MCAP0\r\n"
_SCHEMA = "gaitsmith/msg/Tick"
_NOTES = "gaitsmith"
_ROWS, _TOLD = 1, 2  # channels
_HEAD = struct.Struct("<BQ")  # opcode and length, before every record
_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time
_CDR_LITTLE_ENDIAN = b"\x00\x01\x00\x00"
_LEVEL = -1  # of compression: twice as fast as 1, and the file a fiftieth larger
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
    made["opcode"], made["channel"] = Opcode.MESSAGE, _ROWS
    made["length"] = made.dtype.itemsize - _HEAD.size
    made["kind"] = np.void(_CDR_LITTLE_ENDIAN)
    return made


class ChunkWriter:
    """Writes a log; after every call the file can be read up to there.

    Args:
        file: unbuffered, at its beginning.
        head: written at once.

    Attributes:
        rows: written so far.
    """

    def __init__(self, file: BinaryIO, head: Head) -> None:
        self._file, self._at, self.rows = file, 0, 0
        self._compressor = zstandard.ZstdCompressor(level=_LEVEL)
        text = "".join(f"float64 {name}\n" for name in field_names(head.columns))
        self._schemas = [mcap.Schema(id=1, name=_SCHEMA, encoding="ros2msg", data=text.encode())]
        self._channels = [
            mcap.Channel(id=_ROWS, topic=TOPIC, message_encoding="cdr", schema_id=1, metadata={}),
            mcap.Channel(id=_TOLD, topic=EVENTS, message_encoding="json", schema_id=0, metadata={}),
        ]
        self._chunks, self._spans = bytearray(), array("Q")  # index records; first and last time of every chunk
        self._counts = {_ROWS: 0, _TOLD: 0}
        notes = {"format": FORMAT, **head._asdict()}
        metadata = mcap.Metadata(name=_NOTES, metadata={name: json.dumps(value) for name, value in notes.items()})
        start = _MAGIC + _packed(mcap.Header(profile="", library="gaitsmith"))
        self._notes = mcap.MetadataIndex(offset=len(start), length=len(packed := _packed(metadata)), name=_NOTES)
        self._put(start + packed)
        self._first = _packed(*self._schemas, *self._channels)  # the first chunk names the channels

    def write(self, messages: npt.NDArray[Any], events: Sequence[Event] = ()) -> None:
        """Write one chunk.

        Args:
            messages: (n,) from :func:`message_rows`, with the rows filled.
            events: each with its ``time``, s.

        Raises:
            OSError: the file takes no more; it ends with the chunk before.
        """
        n = len(messages)
        if not n and not events:
            return
        stamps = np.round(messages["row"][:, 0] * 1e9).clip(min=0).astype(np.uint64)
        messages["stamp"] = messages["published"] = stamps
        messages["sequence"] = np.arange(self._counts[_ROWS], self._counts[_ROWS] + n) % 2**32
        told, told_index = self._told(events, len(self._first))
        before = self._first + told
        content: Any = before + messages.tobytes() if before else messages.view(np.uint8)
        index = np.empty((n, 2), "<u8")
        index[:, 0], index[:, 1] = stamps, len(before) + messages.dtype.itemsize * np.arange(n)
        both = np.concatenate([index, told_index])
        packed = self._compressor.compress(content)
        chunk = mcap.Chunk(
            compression="zstd",
            data=packed,
            message_start_time=int(both[:, 0].min()),
            message_end_time=int(both[:, 0].max()),
            uncompressed_crc=zlib.crc32(content),
            uncompressed_size=len(content),
        )
        record, place = _packed(chunk), self._at
        indices = [_index_record(channel, rows) for channel, rows in ((_ROWS, index), (_TOLD, told_index))]
        self._put(record + b"".join(indices))
        first, last = chunk.message_start_time, chunk.message_end_time
        found = mcap.ChunkIndex(
            message_start_time=first,
            message_end_time=last,
            chunk_start_offset=place,
            chunk_length=len(record),
            message_index_offsets={_ROWS: place + len(record), _TOLD: place + len(record) + len(indices[0])},
            message_index_length=sum(map(len, indices)),
            compression=chunk.compression,
            compressed_size=len(packed),
            uncompressed_size=len(content),
        )
        self._chunks += _packed(found)
        self._spans.extend((first, last))
        self._counts[_ROWS] += n
        self._counts[_TOLD] += len(events)
        self.rows, self._first = self.rows + n, b""

    def write_rows(self, rows: npt.NDArray[np.float64], events: Sequence[Event] = ()) -> None:
        """As :meth:`write`, for (n, m) rows."""
        messages = message_rows(rows.shape[1], len(rows))
        messages["row"] = rows
        self.write(messages, events)

    def finish(self) -> None:
        """Write what lets other programs find their way in the file: it is complete then."""
        end = _packed(mcap.DataEnd(data_section_crc=0))
        found = mcap.Statistics(
            attachment_count=0,
            channel_count=len(self._channels),
            channel_message_counts=self._counts,
            chunk_count=len(self._spans) // 2,
            message_count=sum(self._counts.values()),
            metadata_count=1,
            message_start_time=min(self._spans, default=0),
            message_end_time=max(self._spans, default=0),
            schema_count=len(self._schemas),
        )
        summary = _packed(*self._schemas, *self._channels, found) + self._chunks + _packed(self._notes)
        places = {"summary_start": self._at + len(end), "summary_offset_start": 0}
        opening = struct.pack("<BQQQ", Opcode.FOOTER, 20, *places.values())
        footer = mcap.Footer(**places, summary_crc=zlib.crc32(opening, zlib.crc32(summary)))
        self._put(end + summary + _packed(footer) + _MAGIC)

    def _told(self, events: Sequence[Event], begin: int) -> tuple[bytes, npt.NDArray[np.uint64]]:
        """Messages of the events' channel, and their (n, 2) times and places in the chunk."""
        content, index = b"", np.empty((len(events), 2), "<u8")
        for k, event in enumerate(events):
            stamp = max(round(event["time"] * 1e9), 0)
            index[k] = stamp, begin + len(content)
            data = _MESSAGE.pack(_TOLD, (self._counts[_TOLD] + k) % 2**32, stamp, stamp) + json.dumps(event).encode()
            content += _HEAD.pack(Opcode.MESSAGE, len(data)) + data
        return content, index

    def _put(self, content: bytes) -> None:
        """Write all of it or, where the disk is full, nothing."""
        left = memoryview(content)
        try:
            while left:
                left = left[self._file.write(left) :]
        except OSError:
            self._file.truncate(self._at)
            self._file.seek(self._at)
            raise
        self._at += len(content)


class ChunkReader:
    """Reads a log from its beginning, a chunk at a time; iterating gives (n, m) rows.

    Args:
        file: at its beginning.
        source: its name in errors.

    Attributes:
        head: columns and notes.
        events: what has been told so far.
        complete: after the last row, whether the file was finished; else it was cut or damaged behind that row.

    Raises:
        BadInput: not a log, cut before its first row, or from a newer version.
    """

    def __init__(self, file: BinaryIO, source: str) -> None:
        self._file, self.events, self.complete = file, list[Event](), False
        valid = "a log written by gaitsmith"
        if file.read(len(_MAGIC)) != _MAGIC:
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
        self._file.seek(len(_MAGIC))
        pattern = message_rows(len(self.head.columns), 1)[0]
        indexed = {_ROWS}  # channels whose index has been met since the last chunk
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
                yield from rows
            elif opcode == Opcode.FOOTER:
                self.complete = self._file.read() == _MAGIC


def _packed(*records: mcap.McapRecord) -> bytes:
    """Records as bytes."""
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    packed: bytes = builder.end()
    return packed


def _index_record(channel: int, index: npt.NDArray[np.uint64]) -> bytes:
    """The record that lists the (n, 2) times and places of a channel's messages in a chunk."""
    content = struct.pack("<HI", channel, 16 * len(index)) + index.tobytes()
    return _HEAD.pack(Opcode.MESSAGE_INDEX, len(content)) + content


def _records(file: BinaryIO) -> Iterator[tuple[int, bytes]]:
    """Opcode and content of every whole record."""
    while len(start := file.read(_HEAD.size)) == _HEAD.size:
        opcode, length = _HEAD.unpack(start)
        if length > _LARGEST or len(content := file.read(length)) < length:
            return
        yield opcode, content


def _notes(opcode: int, content: bytes) -> dict[str, Any]:
    """This package's metadata, if the record is that."""
    if opcode != Opcode.METADATA:
        return {}
    found = mcap.Metadata.read(ReadDataStream(io.BytesIO(content)))
    return {name: json.loads(value) for name, value in found.metadata.items()} if found.name == _NOTES else {}


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
        opcode, length = _HEAD.unpack_from(content, at)
        end = at + _HEAD.size + length
        if end > len(content):
            raise ValueError("a message beyond its chunk")
        if opcode == Opcode.MESSAGE:
            channel = _MESSAGE.unpack_from(content, at + _HEAD.size)[0]
            if channel == _ROWS:
                if length != pattern["length"]:
                    raise ValueError("a row of another length")
                found = np.frombuffer(content, pattern.dtype, (len(content) - at) // size, at)
                alike = np.ones(len(found), bool)
                for name in ("opcode", "length", "channel"):
                    alike &= found[name] == pattern[name]
                count = len(found) if alike.all() else int(np.argmin(alike))
                yield np.asarray(found["row"][:count], dtype=np.float64)
                end = at + count * size
            else:
                events.append(dict(json.loads(content[at + _HEAD.size + _MESSAGE.size : end])))
        at = end
