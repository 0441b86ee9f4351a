"""The ``kernel`` decorator: numba in nopython mode with a private, source-keyed disk cache.

numba's own key covers one source file, so an edit in a callee of another file would go unnoticed. Here the
folder name hashes the source of a kernel's module and of every project module that it imports, transitively,
together with the versions that decide what machine code comes out.
"""

from __future__ import annotations

import ast
import functools
import hashlib
import platform
import sys
import warnings
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba.core import config as numba_config
from numba.core import types
from numba.extending import typeof_impl

from gaitsmith.cache_folder import cache_root, private_folder

_PACKAGE = "gaitsmith"
_PACKAGE_ROOT = Path(__file__).resolve().parent.parent
_Function = TypeVar("_Function", bound=Callable[..., Any])


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


def _source_file(module: str) -> Path | None:
    """Source file of a project module, or of somebody else's that is loaded; None where there is none to read."""
    found = getattr(sys.modules.get(module), "__file__", None) or ""
    return _module_file(module) or (Path(found) if found.endswith(".py") and Path(found).is_file() else None)


@functools.cache
def _imports(module: str) -> frozenset[str]:
    """Project modules imported by ``module``, named absolutely."""
    path = _source_file(module)
    if path is None:
        return frozenset()
    found: set[str] = set()
    pending: list[ast.AST] = [ast.parse(path.read_bytes())]
    while pending:
        node = pending.pop()
        if isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING":
            continue  # names for the type checker never reach a kernel
        pending.extend(ast.iter_child_nodes(node))
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
        path = _source_file(name)
        digest.update(name.encode())
        digest.update(path.read_bytes() if path else b"")
    return digest.hexdigest()[:20]


@functools.cache
def _usable_root() -> Path | None:
    """The folder of compiled kernels; None, and one warning, when the machine offers no place to write one."""
    try:
        return private_folder(cache_root())
    except OSError as error:
        text = (
            f"kernels are compiled anew in every process, for want of a cache folder ({error}); set GAITSMITH_CACHE_DIR"
        )
        warnings.warn(text, stacklevel=2)
        return None


@functools.cache
def _cache_folder(module: str, convention: str) -> Path | None:
    """Private folder for one module's kernels, None without a usable root."""
    root = _usable_root()
    if root is None:
        return None
    return private_folder(root / f"{module.rpartition('.')[2]}-{convention}-{source_key(module)}")


class Kernel:
    """A function compiled by numba, callable from other kernels and from Python.

    Python's calling convention (unboxing a hundred arrays) is most of a kernel's compile time, so it is compiled only
    for kernels that Python really calls. Kernels have no reference counting and cannot create arrays.

    Attributes:
        function: the Python function.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        functools.update_wrapper(self, function)
        self.function = function
        self.inner = _compile(function, "inner", no_cpython_wrapper=True, no_cfunc_wrapper=True)
        _compile_once_and_lightly(self.inner)

    @functools.cached_property
    def entry(self) -> Any:
        """The dispatcher that Python calls; call it directly where the last 0.1 µs counts."""
        return _compile(self.function, "entry", no_cfunc_wrapper=True)

    @property
    def signatures(self) -> list[Any]:
        """Argument types compiled or loaded so far for calls from Python."""
        return list(self.entry.signatures)

    def __call__(self, *arguments: Any) -> Any:
        """Call from Python."""
        return self.entry(*arguments)


def _compile_once_and_lightly(dispatcher: Any) -> None:
    """One machine code for every constant argument, and the heavy passes left to the entry.

    numba would compile a callee anew for each literal; and what is linked into another kernel is optimised there.
    """
    look_up, compile_fully = dispatcher.get_call_template, dispatcher.compile

    def look_up_general(arguments: Any, keywords: Any) -> Any:
        general = tuple(types.unliteral(argument) for argument in arguments)
        return look_up(general, {name: types.unliteral(argument) for name, argument in keywords.items()})

    def compile_lightly(signature: Any) -> Any:
        before = numba_config.OPT
        numba_config.OPT = type(before)(1)
        try:
            return compile_fully(signature)
        finally:
            numba_config.OPT = before

    dispatcher.get_call_template = look_up_general
    dispatcher.compile = compile_lightly


@typeof_impl.register(Kernel)
def _typeof_kernel(value: Kernel, context: object) -> Any:
    """Inside another kernel a kernel is its inner dispatcher."""
    return types.Dispatcher(value.inner)


def _compile(function: Callable[..., Any], convention: str, **options: Any) -> Any:
    folder = _cache_folder(function.__module__, convention)
    before, disabled = numba_config.CACHE_DIR, numba_config.DISABLE_JIT
    numba_config.DISABLE_JIT = 0  # NUMBA_DISABLE_JIT is for functions that also run uncompiled: kernels do not
    try:
        if folder is not None:
            numba_config.CACHE_DIR = str(folder)
        return numba.njit(cache=folder is not None, error_model="numpy", nogil=True, _nrt=False, **options)(function)
    finally:
        numba_config.CACHE_DIR, numba_config.DISABLE_JIT = before, disabled


def kernel(function: _Function) -> _Function:
    """Compile ``function`` with numba (nopython, IEEE semantics, no GIL), cached on disk for this user only.

    Raises:
        CacheRefused: the cache folder belongs to somebody else or is writable by others.
    """
    return Kernel(function)  # type: ignore[return-value]
