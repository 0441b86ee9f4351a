"""A converted log says the same as the log, to readers that others wrote."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

from gaitsmith import load_robot, read_log
from gaitsmith.cli import main
from gaitsmith.log import Log


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("convert") / "run"
    words = ["walk", "--duration", "1.6", "--rest-before", "0.4", "--push", "1,0,5,0", "--no-figures"]
    assert main([*words, "--out", str(folder)]) == 0
    return folder


@pytest.fixture(scope="module")
def log(run: Path) -> Log:
    return read_log(run / "log.mcap")


def converted(run: Path, to: str, path: Path, *words: str) -> Path:
    assert main(["log", "convert", str(run), "--to", to, "--out", str(path), *words]) == 0
    return path


def test_csv_reads_back_to_the_last_bit(run: Path, log: Log, tmp_path: Path) -> None:
    with converted(run, "csv", tmp_path / "log.csv").open(newline="") as file:
        names, *rows = csv.reader(file)
    assert tuple(names) == log.columns
    assert np.array_equal(np.array(rows, dtype=float), log.rows, equal_nan=True)


def test_npz_holds_rows_notes_and_events(run: Path, log: Log, tmp_path: Path) -> None:
    with np.load(converted(run, "npz", tmp_path / "log.npz")) as found:
        assert tuple(found["columns"]) == log.columns
        assert np.array_equal(found["rows"], log.rows, equal_nan=True)
        assert json.loads(str(found["notes"])) == log.notes
        assert json.loads(str(found["events"])) == list(log.events)


def test_parquet_holds_rows_notes_and_events(run: Path, log: Log, tmp_path: Path) -> None:
    from pyarrow import parquet

    path = converted(run, "parquet", tmp_path / "log.parquet")
    table = parquet.read_table(path)
    assert tuple(table.column_names) == log.columns
    assert all(np.array_equal(table[name].to_numpy(), log.column(name), equal_nan=True) for name in log.columns)
    told = json.loads(parquet.read_metadata(path).metadata[b"gaitsmith"])
    assert told == {"notes": log.notes, "events": list(log.events)}


def test_a_ros_2_bag_holds_every_row(run: Path, log: Log, tmp_path: Path) -> None:
    store = get_typestore(Stores.ROS2_HUMBLE)
    rows, angles = [], []
    with Reader(converted(run, "ros2bag", tmp_path / "bag")) as reader:
        for connection, _, content in reader.messages():
            message = store.deserialize_cdr(content, connection.msgtype)
            if connection.topic == "/gaitsmith":
                assert message.layout.dim[0].label == ",".join(log.columns)  # type: ignore[attr-defined]
                rows.append(message.data)  # type: ignore[attr-defined]
            if connection.topic == "/joint_states":
                angles.append(message.position)  # type: ignore[attr-defined]
    assert np.array_equal(np.array(rows), log.rows, equal_nan=True)
    first = load_robot("bhr_b2").joint_names[0]
    assert np.array_equal(np.array(angles)[:, 0], log.column(f"joint_position.{first}"))


def test_a_cut_log_is_converted_as_far_as_it_is_whole(
    run: Path, log: Log, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    content = (run / "log.mcap").read_bytes()
    (tmp_path / "log.mcap").write_bytes(content[: len(content) - 200])
    assert main(["log", "convert", str(tmp_path), "--json"]) == 0
    told = capsys.readouterr()
    document = json.loads(told.out)
    assert not document["complete"]
    assert 0 < document["rows"] <= len(log.rows)
    assert "was cut" in told.err


@pytest.mark.parametrize(
    "words",
    [("--to", "xlsx"), ("--to", "csv", "--rate", "10"), ("--out", "/proc/x.csv")],
)
def test_what_cannot_be_is_refused(run: Path, words: tuple[str, ...]) -> None:
    assert main(["log", "convert", str(run), *words]) == 2
