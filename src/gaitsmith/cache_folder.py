"""Where compiled code is kept: a folder that is the owner's alone."""

from __future__ import annotations

import contextlib
import os
import stat
from pathlib import Path

from gaitsmith.errors import BadInput, CacheRefused

_NAME = "gaitsmith"


def cache_root() -> Path:
    """Folder of compiled kernels: ``$GAITSMITH_CACHE_DIR``, else ``$XDG_CACHE_HOME/gaitsmith``.

    Raises:
        BadInput: it is in the home of a user who has none.
    """
    chosen = os.environ.get("GAITSMITH_CACHE_DIR")
    base = os.environ.get("XDG_CACHE_HOME")
    try:
        if chosen:
            return Path(chosen).expanduser()
        return (Path(base) if base else Path.home() / ".cache") / _NAME
    except RuntimeError:  # pathlib's
        raise BadInput("GAITSMITH_CACHE_DIR", chosen, "a folder", "this user has no home: set it") from None


def private_folder(folder: Path) -> Path:
    """Create ``folder`` with mode 0700, or check that an existing one is a folder only we can write.

    Raises:
        CacheRefused: somebody else owns it, others may write to it, or it is a link.
        OSError: it cannot be created.
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    with contextlib.suppress(FileExistsError):
        folder.mkdir(mode=0o700)
    found = folder.lstat()
    if not stat.S_ISDIR(found.st_mode):
        raise CacheRefused(
            f"cache folder {folder}: not a plain folder; remove it or set GAITSMITH_CACHE_DIR to a folder of your own"
        )
    if hasattr(os, "getuid") and found.st_uid != os.getuid():
        raise CacheRefused(
            f"cache folder {folder}: owned by user {found.st_uid}, expected {os.getuid()}; "
            "set GAITSMITH_CACHE_DIR to a folder of your own"
        )
    if found.st_mode & 0o077:
        if found.st_mode & 0o022:
            raise CacheRefused(
                f"cache folder {folder}: mode {stat.S_IMODE(found.st_mode):04o} lets others write, expected 0700; "
                f"remove the folder, its content cannot be trusted"
            )
        folder.chmod(0o700)
    return folder
