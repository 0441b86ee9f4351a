"""The functions of a point as machine code: compiled once a robot, kept in the owner's cache, checked on load."""

from __future__ import annotations

import contextlib
import ctypes
import hashlib
import os
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi as ca

from gaitsmith.cache_folder import cache_root, private_folder
from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.point.layout import KINDS, layout_of, sides_of

_OPTIONS = ("-O1", "-fPIC", "-shared", "-fno-math-errno")
_HERE = Path(__file__).resolve().parent
_DYNAMICS = _HERE.parents[1] / "dynamics"
_NAMES = ("symbolic.py", "symbolic_root.py", "rotation.py")
_SOURCES = (_HERE / "expressions.py", _HERE / "layout.py", *(_DYNAMICS / name for name in _NAMES))
"""What decides the expressions; they are imported only to be compiled, and numba with them."""
_SLOWER = "about four times slower, with the same answers"


def find_compiler() -> str | None:
    """Path of a C compiler; ``GAITSMITH_CC`` names another one, and ``none`` asks for none."""
    chosen = os.environ.get("GAITSMITH_CC")
    if chosen == "none":
        return None
    return shutil.which(chosen) if chosen else shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")


def point_library(biped: Biped, tell: Callable[[str], None]) -> tuple[list[Any] | None, float]:
    """The functions of a point from the cache or the compiler, and the time spent compiling, s.

    None without a compiler, if it fails, or if its output cannot be kept; `tell` is called with the reason.

    Raises:
        CacheRefused: the cache folder is not the owner's alone.
    """
    compiler = find_compiler()
    if compiler is None:
        tell(f"{_no_compiler()}: going on without one, {_SLOWER}")
        return None, 0.0
    begin = time.perf_counter()
    try:
        folder = private_folder(private_folder(cache_root()) / f"point-{_key(biped, compiler)}")
        library = _kept(folder)
        if library is not None:
            return _loaded(library, biped), 0.0
        with tempfile.TemporaryDirectory(dir=folder, prefix="build-", ignore_cleanup_errors=True) as scratch:
            tell("compiling the robot's dynamics, once (about a minute)")
            from gaitsmith.synthesis.point.expressions import point_expressions

            library = _compiled(point_expressions(biped), compiler, Path(scratch))
            digest = hashlib.sha256(library.read_bytes()).hexdigest()
            library = library.replace(folder / f"{digest}.so")
        return _loaded(library, biped), time.perf_counter() - begin
    except OSError as error:
        where = f"{error.filename}: {error.strerror}; set GAITSMITH_CACHE_DIR to a folder of your own"
        tell(f"no place to keep compiled dynamics ({where}): going on without, {_SLOWER}")
    except (subprocess.CalledProcessError, RuntimeError) as error:
        tell(f"the C compiler {compiler} failed ({_reason(error)}): going on without it, {_SLOWER}")
    return None, 0.0


def _no_compiler() -> str:
    chosen = os.environ.get("GAITSMITH_CC")
    if chosen in (None, "", "none"):
        return "no C compiler found" if chosen != "none" else "GAITSMITH_CC asks for no C compiler"
    return f"GAITSMITH_CC is {chosen[:80]!r}, which cannot be run (one program, without options)"


def _key(biped: Biped, compiler: str) -> str:
    """Hash of everything that decides the machine code."""
    layout = layout_of(biped)
    digest = hashlib.sha256(biped.dynamics_hash.encode())
    sizes = f"{layout.inputs} {layout.outputs} {layout.wrench}"
    for part in (str(ca.CasadiMeta.version()), compiler, " ".join(_OPTIONS), os.uname().machine, sizes):
        digest.update(part.encode())
    for source in _SOURCES:
        digest.update(source.read_bytes())
    return digest.hexdigest()[:20]


def _kept(folder: Path) -> Path | None:
    """The library in a cache folder; what is not whole, by the hash that is its name, is removed."""
    for path in sorted(folder.glob("*.so")):
        if hashlib.sha256(path.read_bytes()).hexdigest() == path.stem:
            return path
        path.unlink(missing_ok=True)
    return None


def _loaded(library: Path, biped: Biped) -> list[Any]:
    return [ca.external(f"{kind}_{side}", str(library)) for side in sides_of(biped) for kind in KINDS]


def _compiled(functions: list[Any], compiler: str, scratch: Path) -> Path:
    """A library made of C code generated for the functions; all that it takes lies in `scratch`."""
    generator = ca.CodeGenerator("point.c")
    for function in functions:
        generator.add(function)
    generator.generate(f"{scratch}{os.sep}")
    built = scratch / "point.so"
    command = [compiler, *_OPTIONS, str(scratch / "point.c"), "-o", str(built), "-lm"]
    _run(command, os.environ | {"TMPDIR": str(scratch)})
    try:
        ctypes.CDLL(str(built))
    except OSError as error:
        raise RuntimeError(f"its library cannot be loaded: {error}") from None
    return built


def _run(command: list[str], environment: dict[str, str]) -> None:
    """Run a compiler; an interrupt ends it and all that it started."""
    silent = subprocess.DEVNULL
    try:
        process = subprocess.Popen(
            command, env=environment, stdin=silent, stdout=silent, stderr=subprocess.PIPE, start_new_session=True
        )
    except OSError as error:
        raise RuntimeError(f"it cannot be run: {error.strerror}") from None
    with process:
        try:
            _, heard = process.communicate()
        except BaseException:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            raise
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, command, stderr=heard)


def _reason(error: subprocess.CalledProcessError | RuntimeError) -> str:
    """What a compiler said, in one line."""
    if isinstance(error, RuntimeError):
        return str(error)[:200]
    lines = (error.stderr or b"").decode(errors="replace").splitlines()
    said = [line for line in lines if "error" in line.lower()] or lines
    return f"exit status {error.returncode}" + (f": {said[0][:160]}" if said else "")
