"""Writes a log, chunk by chunk; after every call the file can be read up to there."""

from __future__ import annotations

import json
import struct
import zlib
from array import array
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, BinaryIO, NamedTuple

import numpy as np
import numpy.typing as npt
import zstandard
from mcap import records as mcap
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode

from gaitsmith.log.mcap_file import (
    EVENTS,
    FORMAT,
    HEAD,
    MAGIC,
    MESSAGE,
    NOTES,
    ROWS,
    TOLD,
    TOPIC,
    Event,
    Head,
    field_names,
    message_rows,
)

_SCHEMA, _OBJECT = "gaitsmith/msg/Tick", "gaitsmith.Object"
_LEVEL = -1  # of compression: twice as fast as 1, and the file a fiftieth larger
Index = npt.NDArray[np.uint64]


class Topic(NamedTuple):
    """Where further messages go.

    Attributes:
        schema: name of the messages' schema; empty for JSON.
        descriptor: the schema, a set of Protocol Buffers' file descriptors.
    """

    name: str
    schema: str = ""
    descriptor: bytes = b""


class Messages(NamedTuple):
    """Messages of one size for a topic.

    Attributes:
        topic: its number among the topics.
        stamps: (n,) log times, ns.
        content: (n, size).
    """

    topic: int
    stamps: npt.NDArray[np.uint64]
    content: npt.NDArray[np.uint8]


class ChunkWriter:
    """Writes a log.

    Args:
        file: unbuffered, at its beginning.
        head: written at once.

    Attributes:
        rows: written so far.
    """

    def __init__(self, file: BinaryIO, head: Head, topics: Sequence[Topic] = ()) -> None:
        self._file, self._at, self.rows = file, 0, 0
        self._compressor = zstandard.ZstdCompressor(level=_LEVEL)
        self._chunks, self._spans = bytearray(), array("Q")  # index records; first and last time of every chunk
        self._counts: dict[int, int] = {ROWS: 0, TOLD: 0}
        self._named: dict[bytes, None] = {}  # schemas and channels
        self._attached: list[mcap.AttachmentIndex] = []
        notes = {"format": FORMAT, **head._asdict()}
        metadata = mcap.Metadata(name=NOTES, metadata={name: json.dumps(value) for name, value in notes.items()})
        start = MAGIC + _packed(mcap.Header(profile="", library="gaitsmith"))
        self._notes = mcap.MetadataIndex(offset=len(start), length=len(packed := _packed(metadata)), name=NOTES)
        self._put(start + packed)
        self._first = b"".join(_names(head, topics))  # the first chunk names the channels

    def attach(self, attachment: mcap.Attachment) -> None:
        """Put a file into the log."""
        record = _packed(attachment)
        self._attached.append(
            mcap.AttachmentIndex(
                offset=self._at,
                length=len(record),
                log_time=attachment.log_time,
                create_time=attachment.create_time,
                data_size=len(attachment.data),
                name=attachment.name,
                media_type=attachment.media_type,
            )
        )
        self._put(record)

    def write(self, rows: npt.NDArray[Any], events: Sequence[Event] = (), others: Sequence[Messages] = ()) -> None:
        """Write one chunk.

        Args:
            rows: (n,) from :func:`message_rows`, with the rows filled.
            events: each with its ``time``, s.
            others: for the further topics.

        Raises:
            OSError: the file takes no more; it ends with the chunk before.
        """
        if not len(rows) and not events:
            return
        stamps = np.round(rows["row"][:, 0] * 1e9).clip(min=0).astype(np.uint64)
        rows["stamp"] = rows["published"] = stamps
        rows["sequence"] = np.arange(self._counts[ROWS], self._counts[ROWS] + len(rows)) % 2**32
        before, index = self._first, dict[int, Index]()
        if events:
            told, index[TOLD] = self._told(events, len(before))
            before += told
        for messages in others:
            channel = TOLD + 1 + messages.topic
            framed = self._framed(channel, messages)
            index[channel] = _spaced(messages.stamps, len(before), framed.dtype.itemsize)
            before += framed.tobytes()
        index[ROWS] = _spaced(stamps, len(before), rows.dtype.itemsize)
        self._chunk(before + rows.tobytes() if before else rows.view(np.uint8), index)
        if self._first:
            self._named.update(dict.fromkeys(_named_in(self._first)))
        self._first = b""

    def write_rows(self, rows: npt.NDArray[np.float64], events: Sequence[Event] = ()) -> None:
        """As :meth:`write`, for (n, m) rows."""
        messages = message_rows(rows.shape[1], len(rows))
        messages["row"] = rows
        self.write(messages, events)

    def copy(self, content: bytes) -> None:
        """Write one chunk of another log as it is.

        Raises:
            OSError: the file takes no more; it ends with the chunk before.
        """
        self._first = b""
        places: dict[int, list[tuple[int, int]]] = {}
        for opcode, start, _ in _records_in(content):
            if opcode == Opcode.MESSAGE:
                channel, _, stamp, _ = MESSAGE.unpack_from(content, start)
                places.setdefault(channel, []).append((stamp, start - HEAD.size))
        self._named.update(dict.fromkeys(_named_in(content)))
        if places:
            self._chunk(content, {channel: np.array(found, "<u8") for channel, found in places.items()})

    def finish(self) -> None:
        """Write what lets other programs find their way in the file: it is complete then."""
        end = _packed(mcap.DataEnd(data_section_crc=0))
        named = list(self._named) or _named_in(self._first)
        found = mcap.Statistics(
            attachment_count=len(self._attached),
            channel_count=sum(record[0] == Opcode.CHANNEL for record in named),
            channel_message_counts=self._counts,
            chunk_count=len(self._spans) // 2,
            message_count=sum(self._counts.values()),
            metadata_count=1,
            message_start_time=min(self._spans, default=0),
            message_end_time=max(self._spans, default=0),
            schema_count=sum(record[0] == Opcode.SCHEMA for record in named),
        )
        summary = b"".join(named) + _packed(found) + self._chunks + _packed(*self._attached, self._notes)
        places = {"summary_start": self._at + len(end), "summary_offset_start": 0}
        opening = struct.pack("<BQQQ", Opcode.FOOTER, 20, *places.values())
        footer = mcap.Footer(**places, summary_crc=zlib.crc32(opening, zlib.crc32(summary)))
        self._put(end + summary + _packed(footer) + MAGIC)

    def _chunk(self, content: Any, index: Mapping[int, Index]) -> None:
        """Write one chunk, and the (n, 2) times and places of every channel's messages in it."""
        times = [(int(rows[:, 0].min()), int(rows[:, 0].max())) for rows in index.values() if len(rows)]
        first, last = min(time for time, _ in times), max(time for _, time in times)
        packed = self._compressor.compress(content)
        chunk = mcap.Chunk(
            compression="zstd",
            data=packed,
            message_start_time=first,
            message_end_time=last,
            uncompressed_crc=zlib.crc32(content),
            uncompressed_size=len(content),
        )
        record, place = _packed(chunk), self._at
        listed = {channel: _index_record(channel, rows) for channel, rows in sorted(index.items())}
        offsets, at = dict[int, int](), place + len(record)
        for channel, text in listed.items():
            offsets[channel] = at
            at += len(text)
        self._put(record + b"".join(listed.values()))
        found = mcap.ChunkIndex(
            message_start_time=first,
            message_end_time=last,
            chunk_start_offset=place,
            chunk_length=len(record),
            message_index_offsets=offsets,
            message_index_length=at - place - len(record),
            compression=chunk.compression,
            compressed_size=len(packed),
            uncompressed_size=len(content),
        )
        self._chunks += _packed(found)
        self._spans.extend((first, last))
        for channel, rows in index.items():
            self._counts[channel] = self._counts.get(channel, 0) + len(rows)
        self.rows += len(index.get(ROWS, ()))

    def _framed(self, channel: int, messages: Messages) -> npt.NDArray[Any]:
        """Messages as records."""
        count, size = messages.content.shape
        fields = [("opcode", "u1"), ("length", "<u8"), ("channel", "<u2"), ("sequence", "<u4"), ("stamp", "<u8")]
        made = np.zeros(count, [*fields, ("published", "<u8"), ("content", "u1", (size,))])
        made["opcode"], made["length"], made["channel"] = Opcode.MESSAGE, made.dtype.itemsize - HEAD.size, channel
        begun = self._counts.get(channel, 0)
        made["sequence"] = np.arange(begun, begun + count) % 2**32
        made["stamp"] = made["published"] = messages.stamps
        made["content"] = messages.content
        return made

    def _told(self, events: Sequence[Event], begin: int) -> tuple[bytes, Index]:
        """Messages of the events' channel, and their (n, 2) times and places in the chunk."""
        content, index = b"", np.empty((len(events), 2), "<u8")
        for k, event in enumerate(events):
            stamp = max(round(event["time"] * 1e9), 0)
            index[k] = stamp, begin + len(content)
            data = MESSAGE.pack(TOLD, (self._counts[TOLD] + k) % 2**32, stamp, stamp) + json.dumps(event).encode()
            content += HEAD.pack(Opcode.MESSAGE, len(data)) + data
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


def _names(head: Head, topics: Sequence[Topic]) -> Iterable[bytes]:
    """Records of the schemas and the channels."""
    text = "".join(f"float64 {name}\n" for name in field_names(head.columns))
    yield _packed(mcap.Schema(id=1, name=_SCHEMA, encoding="ros2msg", data=text.encode()))
    yield _packed(mcap.Schema(id=2, name=_OBJECT, encoding="jsonschema", data=b'{"type": "object"}'))
    yield _packed(mcap.Channel(id=ROWS, topic=TOPIC, message_encoding="cdr", schema_id=1, metadata={}))
    yield _packed(mcap.Channel(id=TOLD, topic=EVENTS, message_encoding="json", schema_id=2, metadata={}))
    known: dict[str, int] = {"": 2}
    for channel, topic in enumerate(topics, TOLD + 1):
        if topic.schema not in known:
            known[topic.schema] = schema = 2 + len(known)
            yield _packed(mcap.Schema(id=schema, name=topic.schema, encoding="protobuf", data=topic.descriptor))
        schema, encoding = known[topic.schema], "protobuf" if topic.schema else "json"
        yield _packed(
            mcap.Channel(id=channel, topic=topic.name, message_encoding=encoding, schema_id=schema, metadata={})
        )


def _named_in(content: bytes) -> list[bytes]:
    """Records of schemas and channels among others."""
    named = (Opcode.SCHEMA, Opcode.CHANNEL)
    return [content[start - HEAD.size : end] for opcode, start, end in _records_in(content) if opcode in named]


def _records_in(content: bytes) -> Iterator[tuple[int, int, int]]:
    """Opcode, and where the content begins and ends, of every record in a chunk."""
    at = 0
    while at < len(content):
        opcode, length = HEAD.unpack_from(content, at)
        at += HEAD.size
        yield opcode, at, at + length
        at += length


def _spaced(stamps: npt.NDArray[np.uint64], begin: int, size: int) -> Index:
    """(n, 2) times and places of messages of one size."""
    index = np.empty((len(stamps), 2), "<u8")
    index[:, 0], index[:, 1] = stamps, begin + size * np.arange(len(stamps))
    return index


def _packed(*records: mcap.McapRecord) -> bytes:
    """Records as bytes."""
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    packed: bytes = builder.end()
    return packed


def _index_record(channel: int, index: Index) -> bytes:
    """The record that lists the (n, 2) times and places of a channel's messages in a chunk."""
    content = struct.pack("<HI", channel, 16 * len(index)) + index.tobytes()
    return HEAD.pack(Opcode.MESSAGE_INDEX, len(content)) + content
