"""A log comes back as it was written, and anything else is refused in one line."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitsmith.errors import BadInput
from gaitsmith.log.record import Log, Recorder, field_names, read_log

COLUMNS = ("time", "torque.left_knee", "true.torso_x")


def _log(n: int = 50) -> Log:
    rng = np.random.default_rng(0)
    rows = rng.standard_normal((n, 3))
    rows[:, 0] = 0.004 * np.arange(n)
    return Log(COLUMNS, rows, 4, 2, {"scenario": {"seed": 3}})


@pytest.mark.parametrize("n", [0, 1, 50])
def test_what_is_written_is_read(tmp_path, n):
    log = _log(n)
    log.write(tmp_path / "run.mcap")
    back = read_log(tmp_path / "run.mcap")
    np.testing.assert_array_equal(back.rows, log.rows)
    assert (back.columns, back.decimation, back.dropped, back.notes) == (COLUMNS, 4, 2, {"scenario": {"seed": 3}})
    np.testing.assert_array_equal(back.column("true.torso_x"), log.rows[:, 2])
    assert [path.name for path in tmp_path.iterdir()] == ["run.mcap"]


def test_the_file_says_how_to_read_itself(tmp_path):
    from mcap.reader import make_reader

    _log().write(tmp_path / "run.mcap")
    with (tmp_path / "run.mcap").open("rb") as file:
        schema, channel, message = next(iter(make_reader(file).iter_messages()))
    assert (schema.encoding, channel.message_encoding, channel.topic) == ("ros2msg", "cdr", "/gaitsmith")
    assert schema.data.decode().split() == ["float64", "time", "float64", "torque_left_knee", "float64", "true_torso_x"]
    assert len(message.data) == 4 + 8 * 3


@given(st.lists(st.text(max_size=12), max_size=12))
def test_field_names_are_valid_and_distinct(columns):
    names = field_names(tuple(columns))
    assert len(set(names)) == len(columns)
    assert all(name[0].isalpha() and name.isascii() and "__" not in name and name[-1] != "_" for name in names)


@given(st.integers(0, 60), st.integers(1, 20), st.integers(1, 5))
def test_the_ring_keeps_the_latest_rows_in_order(ticks, capacity, decimation):
    telemetry, observed = np.zeros(2), np.zeros(1)
    recorder = Recorder(telemetry, observed, COLUMNS, 1000, decimation, capacity)
    for tick in range(ticks):
        telemetry[:], observed[:] = tick, -tick
        recorder.keep(tick)
    log = recorder.log({})
    expected = list(range(0, ticks, decimation))
    assert log.rows[:, 0].tolist() == expected[-capacity:]
    assert log.rows[:, 2].tolist() == [-tick for tick in expected[-capacity:]]
    assert log.dropped == max(0, len(expected) - capacity)


@given(st.integers(0, 2000), st.binary(max_size=4))
def test_a_damaged_file_is_refused_in_one_line(tmp_path_factory, cut, junk):
    path = tmp_path_factory.mktemp("log") / "run.mcap"
    _log().write(path)
    content = path.read_bytes()
    path.write_bytes(content[: min(cut, len(content) - 1)] + junk)
    with pytest.raises(BadInput) as caught:
        read_log(path)
    assert "\n" not in str(caught.value)


def test_an_unknown_column_names_the_known_ones():
    with pytest.raises(BadInput, match=r"torque\.left_knee"):
        _log().column("speed")


def test_a_folder_that_is_missing_is_refused(tmp_path):
    with pytest.raises(BadInput, match="folder"):
        _log().write(tmp_path / "no" / "run.mcap")
