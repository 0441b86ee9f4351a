from __future__ import annotations

import os
import signal
import threading
from pathlib import Path

import pytest

from gaitsmith.errors import BadInput
from gaitsmith.files import (
    ENDING,
    deferred,
    lock,
    open_regular,
    read_bounded,
    uninterrupted,
    why_unwritable,
    write_bytes_atomic,
    write_text_atomic,
)


def test_writes_whole_and_leaves_nothing_else(tmp_path: Path) -> None:
    target = tmp_path / "a.txt"
    write_text_atomic(target, "über")
    write_bytes_atomic(target, b"second")
    assert target.read_bytes() == b"second"
    assert os.listdir(tmp_path) == ["a.txt"]


def test_a_reader_never_sees_half(tmp_path: Path) -> None:
    target = tmp_path / "a"
    contents = {bytes([65 + i]) * 200_000 for i in range(3)}
    write_bytes_atomic(target, next(iter(contents)))
    done = threading.Event()
    torn: list[int] = []

    def read() -> None:
        while not done.is_set():
            content = target.read_bytes()
            if content not in contents:
                torn.append(len(content))

    reader = threading.Thread(target=read)
    reader.start()
    for _ in range(10):
        for content in contents:
            write_bytes_atomic(target, content)
    done.set()
    reader.join()
    assert torn == []


def test_a_failed_write_keeps_the_old_file(tmp_path: Path) -> None:
    target = tmp_path / "a"
    target.mkdir()
    with pytest.raises(BadInput):
        write_bytes_atomic(target, b"x")
    assert os.listdir(tmp_path) == ["a"]
    with pytest.raises(BadInput, match="missing/a"):
        write_bytes_atomic(tmp_path / "missing" / "a", b"x")


def test_permissions_follow_the_umask(tmp_path: Path) -> None:
    previous = os.umask(0o027)
    try:
        write_bytes_atomic(tmp_path / "a", b"x")
    finally:
        os.umask(previous)
    assert (tmp_path / "a").stat().st_mode & 0o777 == 0o640


def test_reads_within_bounds(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_bytes(b"12345")
    assert read_bounded(path, 5) == b"12345"
    with pytest.raises(BadInput, match="at most 4 bytes"):
        read_bounded(path, 4)
    os.mkfifo(tmp_path / "pipe")
    for bad in (tmp_path, tmp_path / "none", tmp_path / "pipe", "/dev/zero", "nul\0"):
        with pytest.raises(BadInput):
            read_bounded(bad, 10)


def test_only_files_are_replaced(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "ring").symlink_to("ring")
    for name in ("pipe", "ring", "new/", ".", ".."):
        with pytest.raises(BadInput):
            write_bytes_atomic(f"{tmp_path}/{name}", b"x")
    with pytest.raises(BadInput, match="regular file"):
        write_bytes_atomic("/dev/null", b"x")
    assert not Path("/dev/null").is_file()
    assert sorted(os.listdir(tmp_path)) == ["pipe", "ring"]


def test_a_link_is_followed_and_stays(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    link, real = tmp_path / "link", tmp_path / "folder" / "real"
    link.symlink_to(real)
    for content in (b"first", b"second"):
        write_bytes_atomic(link, content)
        assert real.read_bytes() == content
    assert link.is_symlink()
    assert os.listdir(tmp_path / "folder") == ["real"]


def test_why_nothing_can_be_written(tmp_path: Path) -> None:
    assert why_unwritable(tmp_path) == ""
    assert why_unwritable(tmp_path / "missing")
    assert os.listdir(tmp_path) == []


class Heard(Exception):
    """A signal was heard."""


@pytest.fixture
def heard():
    """All signals that end a run raise, and are put back afterwards."""

    def hear(number, frame):
        raise Heard(number)

    before = {number: signal.signal(number, hear) for number in ENDING}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("number", ENDING)
def test_signals_are_ignored_where_they_would_leave_halves(heard: None, number: int) -> None:
    with uninterrupted():
        signal.raise_signal(number)
    with pytest.raises(Heard):
        signal.raise_signal(number)


@pytest.mark.parametrize("number", ENDING)
def test_signals_wait_for_what_is_done_in_one_piece(heard: None, number: int) -> None:
    done = []

    def piece() -> None:
        with deferred():
            signal.raise_signal(number)
            done.append(True)

    with pytest.raises(Heard):
        piece()
    assert done == [True]
    with deferred():
        pass  # nothing came, so nothing is raised


def test_a_lock_is_seen_by_others_and_goes_with_the_file(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"x")
    with open_regular(tmp_path / "file") as first, open_regular(tmp_path / "file") as second:
        assert lock(first)
        assert not lock(second)
        first.close()
        assert lock(second)
