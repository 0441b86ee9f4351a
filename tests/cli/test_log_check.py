"""Whatever ends a run, what it had done stays: kill -9, signals that can be heard, a full disk."""

from __future__ import annotations

import errno
import json
import os
import signal
import subprocess
import sys
import time
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from tests.cli.test_walk import SHORT, run

from gaitsmith.log import read_log

LATE = 1.0  # s of wall time that a killed run may lose
WALK = ["walk", "--duration", "100000", "--rest-before", "0.1", "--no-figures", "--out"]


@cache
def _compiled() -> None:
    """Once, so that no process has to wait for it."""
    run("walk", *SHORT)


def _begun(folder: Path) -> subprocess.Popen[str]:
    """A run in a process of its own that has begun its log."""
    _compiled()
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    words = [sys.executable, "-m", "gaitsmith", *WALK, str(folder), "--json"]
    process = subprocess.Popen(words, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    until = time.monotonic() + 120.0
    while not (folder / "log.mcap").exists() and process.poll() is None and time.monotonic() < until:
        time.sleep(0.02)
    return process


def test_a_killed_run_loses_less_than_a_second(tmp_path: Path) -> None:
    process = _begun(tmp_path / "run")
    try:
        time.sleep(float(np.random.default_rng().uniform(0.8, 2.5)))
        code, out, _ = run("log", "check", str(tmp_path / "run"), "--json")
        assert (code, json.loads(out)["running"], json.loads(out)["repaired"]) == (0, True, False)
    finally:
        process.kill()
        killed = time.time()
        process.communicate()
    path = tmp_path / "run" / "log.mcap"
    assert killed - path.stat().st_mtime < LATE
    log = read_log(path)
    assert not log.complete
    assert len(log.rows) > 0
    assert np.diff(log.time) == pytest.approx(4e-3, abs=1e-9)
    code, out, _ = run("log", "check", str(tmp_path / "run"), "--json")
    found = json.loads(out)
    assert (code, found["rows"], found["complete"], found["repaired"]) == (0, len(log.rows), False, True)
    assert found["last_time"] == log.time[-1]
    assert {entry.name for entry in path.parent.iterdir()} == {"log.mcap", "scenario.toml", "summary.json"}
    summary = json.loads((path.parent / "summary.json").read_text())
    assert summary["interrupted"]
    assert summary["duration"] == pytest.approx(log.time[-1])
    code, out, _ = run("log", "check", str(path.parent), "--json")
    assert (json.loads(out)["complete"], json.loads(out)["repaired"]) == (True, False)
    np.testing.assert_array_equal(read_log(path).rows, log.rows)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_a_run_in_order(number: signal.Signals, tmp_path: Path) -> None:
    process = _begun(tmp_path / "run")
    try:
        time.sleep(0.7)
        process.send_signal(number)
        out, err = process.communicate(timeout=300)
    finally:
        process.kill()
    assert (process.returncode, err) == (130, "")
    assert json.loads(out)["interrupted"] is True
    log = read_log(tmp_path / "run" / "log.mcap")
    assert log.complete
    assert json.loads((tmp_path / "run" / "summary.json").read_text())["log"]["rows"] == len(log.rows)


def test_a_figure_that_finds_no_room_takes_nothing_with_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("gaitsmith.view.write_figures", full)
    code, _, err = run("walk", *SHORT, "--out", str(tmp_path / "run"), "--json")
    assert code == 0
    assert "No space left on device" in err
    assert {entry.name for entry in (tmp_path / "run").iterdir()} == {"log.mcap", "scenario.toml", "summary.json"}


def test_a_full_disk_ends_a_run_in_one_line_and_keeps_what_is_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from gaitsmith.log import record
    from gaitsmith.log.mcap_writer import ChunkWriter

    write, chunks = ChunkWriter.write, []

    def full(self: ChunkWriter, *given: object) -> None:
        if len(chunks) == 2:
            raise OSError(errno.ENOSPC, "No space left on device")
        chunks.append(given)
        write(self, *given)  # type: ignore[arg-type]

    monkeypatch.setattr(ChunkWriter, "write", full)
    monkeypatch.setattr(record, "_EVERY", 0.0)
    code, out, err = run("walk", *SHORT, "--out", str(tmp_path / "run"), "--json")
    assert code == 2
    assert len(err.splitlines()) == 1
    assert "no space left on device" in json.loads(out)["error"]["message"]
    assert len(read_log(tmp_path / "run" / "log.mcap").rows) == 2


def test_what_is_no_log_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"\x89MCAP0\r\nsomething else")
    for name in ("absent", "file", "."):
        code, _, err = run("log", "check", str(tmp_path / name))
        assert code == 2
        assert len(err.splitlines()) == 1


def test_a_damaged_log_stays_as_it_is(tmp_path: Path) -> None:
    run("walk", *SHORT, "--out", str(tmp_path / "run"), "--no-figures")
    path = tmp_path / "run" / "log.mcap"
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 0xFF
    path.write_bytes(content)
    code, out, err = run("log", "check", str(tmp_path / "run"), "--json")
    assert (code, json.loads(out)["damaged"], json.loads(out)["written"]) == (0, True, [])
    assert "is damaged, and stays as it is" in err
    assert path.read_bytes() == content


def test_looking_only_changes_nothing(tmp_path: Path) -> None:
    run("walk", *SHORT, "--out", str(tmp_path / "run"), "--no-figures")
    path = tmp_path / "run" / "log.mcap"
    (tmp_path / "run" / "summary.json").unlink()
    path.write_bytes(path.read_bytes()[:-100])
    code, out, _ = run("log", "check", str(path), "--no-repair")
    assert (code, "cut short" in out) == (0, True)
    assert not (tmp_path / "run" / "summary.json").exists()
    code, out, _ = run("log", "check", str(path))
    assert "written anew: log.mcap, summary.json" in out
