"""The ``kernel`` decorator: numba in nopython mode with a private, source-keyed disk cache.

numba's own key covers one source file, so an edit in a callee of another file would go unnoticed. Here the
folder name hashes the source of a kernel's module and of every project module that it imports, transitively,
together with the versions that decide what machine code comes out.
"""

from __future__ import annotations

import ast
import functools
import hashlib
import os
import platform
import stat
import sys
import warnings
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba.core import config as numba_config

from gaitsmith.errors import CacheRefused

_PACKAGE = "gaitsmith"
_PACKAGE_ROOT = Path(__file__).resolve().parent.parent
_Function = TypeVar("_Function", bound=Callable[..., Any])


def cache_root() -> Path:
    """Folder of compiled kernels: ``$GAITSMITH_CACHE_DIR``, else ``$XDG_CACHE_HOME/gaitsmith``."""
    chosen = os.environ.get("GAITSMITH_CACHE_DIR")
    if chosen:
        return Path(chosen).expanduser()
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / _PACKAGE


def _private_folder(folder: Path) -> Path:
    """Create ``folder`` with mode 0700, or check that an existing one is a folder only we can write.

    Raises:
        CacheRefused: somebody else owns it, others may write to it, or it is a link.
        OSError: it cannot be created.
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    try:
        folder.mkdir(mode=0o700)
    except FileExistsError:
        pass
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


def _module_file(module: str) -> Path | None:
    """Source file of a project module, None when ``module`` is a name inside one or belongs to somebody else."""
    head, *rest = module.split(".")
    if head != _PACKAGE:
        return None
    base = _PACKAGE_ROOT.joinpath(*rest)
    for candidate in (base / "__init__.py", base.with_suffix(".py")):
        if candidate.is_file():
            return candidate
    return None


@functools.cache
def _imports(module: str) -> frozenset[str]:
    """Project modules imported by ``module``, named absolutely."""
    path = _module_file(module)
    if path is None:
        return frozenset()
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            found.add(node.module)
            found.update(f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
    return frozenset(name for name in found if _module_file(name) is not None)


@functools.cache
def source_key(module: str) -> str:
    """Hash of a module's source, of all project modules it reaches by import, and of the compiler's versions."""
    reached: set[str] = set()
    pending = [module]
    while pending:
        name = pending.pop()
        if name not in reached:
            reached.add(name)
            pending.extend(_imports(name))
    digest = hashlib.sha256()
    for part in (sys.version, platform.machine(), version("numba"), version("llvmlite"), version("numpy")):
        digest.update(part.encode())
    for name in sorted(reached):
        path = _module_file(name)
        digest.update(name.encode())
        digest.update(path.read_bytes() if path else b"")
    return digest.hexdigest()[:20]


@functools.cache
def _cache_folder(module: str) -> Path | None:
    """Private folder for one module's kernels; None when the machine offers no place to write one."""
    try:
        root = _private_folder(cache_root())
        return _private_folder(root / f"{module.rpartition('.')[2]}-{source_key(module)}")
    except OSError as error:
        warnings.warn(f"kernels are compiled anew in every process: no cache folder ({error})", stacklevel=4)
        return None


def kernel(function: _Function) -> _Function:
    """Compile ``function`` with numba (nopython, IEEE semantics, no GIL), cached on disk for this user only.

    Raises:
        CacheRefused: the cache folder belongs to somebody else or is writable by others.
    """
    folder = _cache_folder(function.__module__)
    before = numba_config.CACHE_DIR
    try:
        if folder is not None:
            numba_config.CACHE_DIR = str(folder)
        compiled = numba.njit(cache=folder is not None, error_model="numpy", nogil=True)(function)
    finally:
        numba_config.CACHE_DIR = before
    return compiled  # type: ignore[no-any-return]
