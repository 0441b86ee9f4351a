"""Reading with a bound, writing whole or not at all, and keeping signals out of what must not stop half-way."""

from __future__ import annotations

import contextlib
import fcntl
import os
import secrets
import signal
import stat
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

from gaitsmith.errors import BadInput

UNFINISHED = ".part"
"""How files end that are not whole yet; their names begin with a dot."""
ENDING = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
"""Signals that ask a run to end: Ctrl-C, the end of a session or of a batch job, a terminal that closes."""


def reason(error: OSError | ValueError) -> str:
    """Why a file cannot be used, in words."""
    return str(getattr(error, "strerror", None) or error).lower()


def open_regular(path: str | Path) -> BinaryIO:
    """A regular file, open for reading.

    Raises:
        BadInput: the file is missing, unreadable, or not a regular file (a pipe is never waited for).
    """
    try:
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
    except (OSError, ValueError) as error:
        raise BadInput(str(path), reason(error), "a readable file") from None
    if not stat.S_ISREG(os.fstat(handle).st_mode):
        os.close(handle)
        raise BadInput(str(path), "something else", "a regular file")
    return os.fdopen(handle, "rb")


def lock(file: BinaryIO | int) -> bool:
    """Lock an open file, or a folder by its number, against other processes until it is closed.

    Returns:
        False if another one has locked it.
    """
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks
        return True
    return True


def read_bounded(path: str | Path, limit: int) -> bytes:
    """Content of a regular file of at most `limit` bytes.

    Raises:
        BadInput: as :func:`open_regular`, or the file is too large.
    """
    try:
        with open_regular(path) as file:
            content = file.read(limit + 1)
    except OSError as error:
        raise BadInput(str(path), reason(error), "a readable file") from None
    if len(content) > limit:
        raise BadInput(str(path), f"more than {limit} bytes", f"at most {limit} bytes")
    return content


@contextlib.contextmanager
def replacing(path: str | Path) -> Iterator[BinaryIO]:
    """A file to fill that then takes a path whole: a reader sees the old content or the new, also after a crash.

    Raises:
        BadInput: the folder is missing or cannot be written, or :func:`regular_target` refuses the path.
    """
    target = regular_target(path)
    temporary = target.with_name(f".{target.name[:100]}.{secrets.token_hex(6)}{UNFINISHED}")
    try:
        handle = os.open(temporary, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)
        try:
            with os.fdopen(handle, "w+b", buffering=0) as file:
                yield file
                os.fsync(file.fileno())
            os.replace(temporary, target)
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(temporary)
            raise
        _sync_folder(target.parent)
    except OSError as error:
        raise BadInput(str(path), reason(error), "a file in a folder that can be written") from None


def write_bytes_atomic(path: str | Path, content: bytes) -> None:
    """Write a file as :func:`replacing` does."""
    with replacing(path) as file:
        left = memoryview(content)
        while left:
            left = left[file.write(left) :]


def write_text_atomic(path: str | Path, text: str) -> None:
    """As :func:`write_bytes_atomic`, for text in UTF-8."""
    write_bytes_atomic(path, text.encode("utf-8"))


def regular_target(path: str | Path) -> Path:
    """Absolute path of the file that writing replaces or creates; a link is followed to the file that it names.

    Raises:
        BadInput: the path ends without a file name, or a folder, a device, a pipe or a broken ring of links is there.
    """
    shown = str(path)
    if os.path.basename(shown) in ("", ".", ".."):
        raise BadInput(shown, "a folder", "the name of a file")
    try:
        target = Path(os.path.realpath(shown))
        mode = os.lstat(target).st_mode
    except FileNotFoundError:
        return target
    except (OSError, ValueError) as error:
        raise BadInput(shown, reason(error), "a file that can be written") from None
    if not stat.S_ISREG(mode):
        found = "a folder" if stat.S_ISDIR(mode) else "something that is no file"
        raise BadInput(shown, found, "a regular file, or a name that is free")
    return target


def why_unwritable(folder: Path) -> str:
    """Why nothing can be created in a folder, in words; empty where something can."""
    probe = folder / f".gaitsmith.{secrets.token_hex(6)}"
    try:
        os.mkdir(probe)  # modes don't tell of /proc, of read-only disks, of full ones
        os.rmdir(probe)
    except (OSError, ValueError) as error:
        return reason(error)
    return ""


@contextlib.contextmanager
def _handling(handler: Any) -> Iterator[None]:
    """Handle :data:`ENDING` in another way; only the main thread is ever told of them."""
    ours = ENDING if threading.current_thread() is threading.main_thread() else ()
    before = {number: signal.signal(number, handler) for number in ours}
    try:
        yield
    finally:
        for number, own in before.items():
            signal.signal(number, own)


def uninterrupted() -> contextlib.AbstractContextManager[None]:
    """Ignore :data:`ENDING`, here and in processes started meanwhile."""
    return _handling(signal.SIG_IGN)


@contextlib.contextmanager
def deferred() -> Iterator[None]:
    """Let :data:`ENDING` wait until what must be done in one piece is done; they come at its end."""
    came: list[int] = []
    try:
        with _handling(lambda number, _: came.append(number)):
            yield
    finally:
        for number in came:
            signal.raise_signal(number)


def _sync_folder(folder: Path) -> None:
    """Make a rename durable where folders can be opened."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
