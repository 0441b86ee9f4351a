"""A log comes back as it was written, up to wherever it was cut, and anything else is refused in one line."""

from __future__ import annotations

import errno
import io
import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitsmith.errors import BadInput
from gaitsmith.log.mcap_file import EVENTS, TOPIC, field_names
from gaitsmith.log.record import Log, Recorder, read_log, read_stream

COLUMNS = ("time", "torque.left_knee", "true.torso_x")
NOTES = {"scenario": {"seed": 3}}


def _log(n: int = 50) -> Log:
    rng = np.random.default_rng(0)
    rows = rng.standard_normal((n, 3))
    rows[:, 0] = 0.004 * np.arange(n)
    return Log(COLUMNS, rows, 4, 2, NOTES, ({"time": 0.1, "walk": True},))


def _streamed(rows: int, every: int, events: bool = False) -> tuple[bytes, list[int]]:
    """A streamed log that was never closed, and its sizes after every flush."""
    file, row = io.BytesIO(), np.zeros(3)
    recorder = Recorder(file, (row[:2], row[2:]), COLUMNS, NOTES, 1)
    sizes = [len(file.getvalue())]
    for tick in range(rows):
        row[:] = 0.001 * tick, tick, -tick
        if events and tick % 3 == 0:
            recorder.hear({"time": 0.001 * tick, "n": tick})
        recorder.observe(tick)
        if (tick + 1) % every == 0:
            recorder.flush()
            sizes.append(len(file.getvalue()))
    return file.getvalue(), sizes


@pytest.mark.parametrize("n", [0, 1, 50, 5000])
def test_what_is_written_is_read(tmp_path, n):
    log = _log(n)
    log.write(tmp_path / "run.mcap")
    back = read_log(tmp_path / "run.mcap")
    np.testing.assert_array_equal(back.rows, log.rows)
    assert (back.columns, back.decimation, back.dropped, back.notes) == (COLUMNS, 4, 2, NOTES)
    assert back.events == log.events
    assert back.complete
    np.testing.assert_array_equal(back.column("true.torso_x"), log.rows[:, 2])
    assert [path.name for path in tmp_path.iterdir()] == ["run.mcap"]


def test_other_programs_read_the_file(tmp_path):
    from mcap.reader import make_reader
    from mcap.stream_reader import StreamReader

    _log().write(tmp_path / "run.mcap")
    with (tmp_path / "run.mcap").open("rb") as file:
        reader = make_reader(file)
        found = list(reader.iter_messages(topics=TOPIC))
        told = list(reader.iter_messages(topics=EVENTS))
        summary = reader.get_summary()
    schema, channel, message = found[0]
    assert (schema.encoding, channel.message_encoding) == ("ros2msg", "cdr")
    assert schema.data.decode().split() == ["float64", "time", "float64", "torque_left_knee", "float64", "true_torso_x"]
    assert len(message.data) == 4 + 8 * 3
    np.testing.assert_array_equal([np.frombuffer(message.data[4:], "<f8") for _, _, message in found], _log().rows)
    assert [message.log_time for _, _, message in found] == [4_000_000 * k for k in range(50)]
    assert json.loads(told[0][2].data) == {"time": 0.1, "walk": True}
    assert summary.statistics.message_count == 51
    with (tmp_path / "run.mcap").open("rb") as file:
        kinds = {type(record).__name__ for record in StreamReader(file, validate_crcs=True).records}
    assert {"Header", "Metadata", "Message", "MessageIndex", "ChunkIndex", "Statistics", "Footer"} <= kinds


def test_a_log_of_the_first_format_is_read(tmp_path):
    from mcap.writer import CompressionType, Writer

    with (tmp_path / "old.mcap").open("wb") as file:
        writer = Writer(file, compression=CompressionType.ZSTD, chunk_size=100)
        writer.start(profile="", library="gaitsmith")
        schema = writer.register_schema(name="gaitsmith/msg/Tick", encoding="ros2msg", data=b"float64 time\n")
        channel = writer.register_channel(topic=TOPIC, message_encoding="cdr", schema_id=schema)
        for k, row in enumerate(_log().rows):
            writer.add_message(channel, k, b"\x00\x01\x00\x00" + row.tobytes(), k, k)
        notes = {"decimation": 4, "dropped": 2, "columns": COLUMNS, "notes": NOTES}
        writer.add_metadata("gaitsmith", {name: json.dumps(value) for name, value in notes.items()})
        writer.finish()
    log = read_log(tmp_path / "old.mcap")
    np.testing.assert_array_equal(log.rows, _log().rows)
    assert (log.columns, log.decimation, log.dropped, log.notes, log.complete) == (COLUMNS, 4, 2, NOTES, True)


@given(st.lists(st.text(max_size=12), max_size=12))
def test_field_names_are_valid_and_distinct(columns):
    names = field_names(tuple(columns))
    assert len(set(names)) == len(columns)
    assert all(name[0].isalpha() and name.isascii() and "__" not in name and name[-1] != "_" for name in names)


@given(st.integers(0, 60), st.integers(1, 5))
def test_rows_come_in_order_with_their_decimation(ticks, decimation):
    row, file = np.zeros(3), io.BytesIO()
    recorder = Recorder(file, (row[:2], row[2:]), COLUMNS, {}, decimation)
    for tick in range(ticks):
        row[:] = tick, tick, -tick
        recorder.observe(tick)
    recorder.close()
    log = read_stream(io.BytesIO(file.getvalue()), "file")
    assert log.rows[:, 0].tolist() == list(range(0, ticks, decimation))
    assert log.rows[:, 2].tolist() == [-tick for tick in range(0, ticks, decimation)]
    assert (log.dropped, recorder.dropped, recorder.rows, log.complete) == (0, 0, len(log.rows), True)


@given(st.integers(0, 10**6), st.binary(max_size=40), st.booleans())
def test_a_log_cut_at_any_byte_gives_its_whole_chunks(cut, junk, events):
    content, sizes = _streamed(40, 7, events)
    cut %= len(content) + 1
    spoilt = content[:cut] + junk
    if cut < sizes[0]:
        with pytest.raises(BadInput) as caught:
            read_stream(io.BytesIO(spoilt), "run.mcap")
        assert "\n" not in str(caught.value)
        return
    log = read_stream(io.BytesIO(spoilt), "run.mcap")
    whole = 7 * sum(size <= cut for size in sizes[1:])
    # Behind its rows a chunk has an index, which the rows do not need.
    assert log.rows[:, 1].tolist() in (list(range(whole)), list(range(min(whole + 7, 40))))
    assert not log.complete


def test_a_changed_byte_ends_the_log_before_its_chunk():
    content, sizes = _streamed(40, 10)
    spoilt = bytearray(content)
    spoilt[sizes[2] + 100] ^= 0xFF
    log = read_stream(io.BytesIO(bytes(spoilt)), "run.mcap")
    assert log.rows[:, 1].tolist() == list(range(20))
    assert not log.complete
    assert log.damaged  # a cut leaves nothing behind it


@pytest.mark.parametrize("place", [0.0, 0.3, 0.6])
def test_damage_to_a_finished_log_is_no_cut(place, tmp_path):
    log = _log(5000)
    log.write(tmp_path / "run.mcap")
    content = bytearray((tmp_path / "run.mcap").read_bytes())
    assert not read_stream(io.BytesIO(bytes(content[:-30])), "run.mcap").damaged
    content[content.find(b"zstd", int(place * len(content))) + 200] ^= 0xFF  # in the next chunk
    found = read_stream(io.BytesIO(bytes(content)), "run.mcap")
    assert (found.complete, found.damaged) == (False, True)
    assert len(found.rows) < 5000


@settings(max_examples=300)
@given(st.integers(0, 10**6), st.integers(1, 255))
def test_any_changed_byte_leaves_a_beginning_or_one_line(place, change):
    content = bytearray(_streamed(40, 10, True)[0])
    content[place % len(content)] ^= change
    try:
        log = read_stream(io.BytesIO(bytes(content)), "run.mcap")
    except BadInput as error:
        assert "\n" not in str(error)
    else:
        assert log.rows[:, 1].tolist() == list(range(len(log.rows)))


def test_what_is_old_enough_is_on_disk():
    clock = [0.0]
    file, row = io.BytesIO(), np.zeros(3)
    recorder = Recorder(file, (row,), COLUMNS, {}, 1, clock=lambda: clock[0])
    for tick in range(1000):
        clock[0] = row[0] = 0.01 * tick
        recorder.observe(tick)
        log = read_stream(io.BytesIO(file.getvalue()), "file")
        assert clock[0] - (log.time[-1] if len(log.rows) else 0.0) < 0.51


def test_a_full_disk_is_told_and_keeps_what_is_written():
    class Full(io.BytesIO):
        room = 3000

        def write(self, content):
            if self.tell() + len(content) > self.room:
                super().write(content[: self.room - self.tell()])
                raise OSError(errno.ENOSPC, "No space left on device")
            return super().write(content)

    file, row = Full(), np.zeros(3)
    recorder = Recorder(file, (row,), COLUMNS, {}, 1)
    rng = np.random.default_rng(1)

    def record() -> None:
        for tick in range(1000):
            row[:] = 0.001 * tick, *rng.standard_normal(2)
            recorder.observe(tick)
            if tick % 20 == 0:
                recorder.flush()

    with pytest.raises(BadInput, match=r"no space left.*kept up to [0-9.]+ s"):
        record()
    log = read_stream(io.BytesIO(file.getvalue()), "file")
    assert len(log.rows) % 20 == 1
    assert len(log.rows) > 20


def test_a_newer_format_is_refused_in_one_line():
    content, _ = _streamed(10, 5)
    newer = content.replace(b"format\x01\x00\x00\x003", b"format\x01\x00\x00\x009")
    assert newer != content
    with pytest.raises(BadInput, match=r"run\.mcap: got 'format 9', expected at most format 3; update gaitsmith"):
        read_stream(io.BytesIO(newer), "run.mcap")


def test_the_latest_rows_alone_can_be_read(tmp_path):
    _log(5000).write(tmp_path / "run.mcap")
    np.testing.assert_array_equal(read_log(tmp_path / "run.mcap", last=60).rows, _log(5000).rows[-60:])
    assert len(read_log(tmp_path / "run.mcap", last=10**6).rows) == 5000


def test_rows_after_the_end_are_counted():
    row = np.zeros(3)
    recorder = Recorder(io.BytesIO(), (row,), COLUMNS, {}, 1)
    recorder.close()
    recorder.observe(0)
    assert (recorder.rows, recorder.dropped) == (0, 1)


def test_an_unknown_column_names_the_known_ones():
    with pytest.raises(BadInput, match=r"torque\.left_knee"):
        _log().column("speed")


def test_a_folder_that_is_missing_is_refused(tmp_path):
    with pytest.raises(BadInput, match="folder"):
        _log().write(tmp_path / "no" / "run.mcap")
