"""The folder a run is written to: refused before the run if it cannot be made, and there only once it is complete."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path

from gaitsmith.errors import BadInput

_NEW = "a folder that does not exist yet"


def check_new_folder(name: str, field: str = "--out") -> Path:
    """Absolute path of a folder that can be created.

    Raises:
        BadInput: something exists there already, or its parent cannot be written.
    """
    folder = Path(os.path.abspath(name))
    try:
        os.lstat(folder)
    except FileNotFoundError:
        pass
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise BadInput(field, name, "a folder that can be created", reason.lower()) from None
    else:
        raise BadInput(field, name, _NEW, "choose another name")
    parent = next(above for above in folder.parents if os.path.lexists(above))
    if not parent.is_dir() or not os.access(parent, os.W_OK | os.X_OK):
        raise BadInput(field, name, "a folder whose parent can be written", f"{parent} cannot be; choose another place")
    try:
        os.rmdir(tempfile.mkdtemp(prefix=".gaitsmith.", dir=parent))  # what modes don't tell, such as /proc
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise BadInput(field, name, "a folder whose parent can be written", f"{parent}: {reason}") from None
    return folder


@contextlib.contextmanager
def new_folder(folder: Path, field: str = "--out") -> Iterator[Path]:
    """A hidden folder to write into; it takes its final name when everything is written.

    Raises:
        BadInput: it cannot be written, or somebody else has taken the name meanwhile.
    """
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        staging = Path(tempfile.mkdtemp(prefix=f".{folder.name[:60]}.", dir=folder.parent))
    except OSError as error:
        raise BadInput(field, str(folder), "a folder that can be created", (error.strerror or "").lower()) from None
    try:
        yield staging
    except BaseException:
        shutil.rmtree(staging, ignore_errors=True)
        raise
    mask = os.umask(0)
    os.umask(mask)
    staging.chmod(0o777 & ~mask)  # the temporary folder was private
    try:
        if os.path.lexists(folder):
            raise FileExistsError
        staging.rename(folder)
    except OSError:
        raise BadInput(field, str(folder), _NEW, f"the run is kept in {staging}") from None


@contextlib.contextmanager
def uninterrupted() -> Iterator[None]:
    """Let Ctrl-C wait while results are written; elsewhere than in the main thread it cannot come anyway."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
