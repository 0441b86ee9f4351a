"""The kernel cache belongs to its owner alone, and its key follows every source that a kernel reaches."""

from __future__ import annotations

import os
import stat
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from numba.core import config as numba_config

from gaitsmith.cache_folder import cache_root, private_folder
from gaitsmith.compiled import cache, kernel
from gaitsmith.compiled.cache import source_key
from gaitsmith.control.tick import tick
from gaitsmith.errors import BadInput, CacheRefused


def test_a_new_folder_is_the_owners_alone(tmp_path: Path) -> None:
    folder = private_folder(tmp_path / "kernels")
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


def test_a_readable_folder_is_closed(tmp_path: Path) -> None:
    folder = tmp_path / "kernels"
    folder.mkdir(mode=0o755)
    folder.chmod(0o755)
    assert stat.S_IMODE(private_folder(folder).stat().st_mode) == 0o700


@pytest.mark.parametrize("mode", [0o777, 0o720, 0o702])
def test_a_folder_that_others_can_write_is_refused(tmp_path: Path, mode: int) -> None:
    folder = tmp_path / "kernels"
    folder.mkdir()
    folder.chmod(mode)
    with pytest.raises(CacheRefused, match="lets others write"):
        private_folder(folder)


def test_a_link_is_refused(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir(mode=0o700)
    (tmp_path / "link").symlink_to(tmp_path / "real")
    with pytest.raises(CacheRefused, match="not a plain folder"):
        private_folder(tmp_path / "link")


def test_somebody_elses_folder_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = private_folder(tmp_path / "kernels")
    monkeypatch.setattr(os, "getuid", lambda: folder.stat().st_uid + 1)
    with pytest.raises(CacheRefused, match="owned by user"):
        private_folder(folder)


@pytest.mark.parametrize("variable", ["GAITSMITH_CACHE_DIR", "XDG_CACHE_HOME"])
def test_a_home_that_nobody_has_is_refused(variable: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("GAITSMITH_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    if variable == "GAITSMITH_CACHE_DIR":
        monkeypatch.setenv(variable, "~nobody-of-this-name/kernels")
    else:
        monkeypatch.setattr(Path, "home", lambda: Path("~nobody-of-this-name").expanduser())
    with pytest.raises(BadInput, match="GAITSMITH_CACHE_DIR"):
        cache_root()


def test_kernels_are_compiled_whatever_numba_was_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(numba_config, "DISABLE_JIT", 1)
    assert kernel(_doubled)(3.0) == 6.0
    assert numba_config.DISABLE_JIT == 1


def _doubled(x: float) -> float:
    return 2.0 * x


def test_the_key_follows_what_a_module_reaches() -> None:
    """The tick reaches the splines through the template, but no robot and no plant."""
    reached: set[str] = set()
    pending = [tick.__module__]
    while pending:
        name = pending.pop()
        if name not in reached:
            reached.add(name)
            pending.extend(cache._imports(name))
    assert "gaitsmith.splines.quartic_pair" in reached
    assert not [name for name in reached if name.startswith(("gaitsmith.robots", "gaitsmith.simulation"))]


def test_the_key_changes_with_the_source_of_a_callee(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    module, callee = "gaitsmith.template.trajectory", "gaitsmith.splines.quartic_pair"
    before = source_key(module)
    edited = tmp_path / "edited.py"
    found = cache._module_file(callee)
    assert found is not None
    edited.write_bytes(found.read_bytes() + b"\n# edited\n")
    real = cache._module_file
    monkeypatch.setattr(cache, "_module_file", lambda name: edited if name == callee else real(name))
    assert source_key.__wrapped__(module) != before


def test_a_kernel_outside_the_package_follows_what_it_imports(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A user's own kernel, like those of the tests, must not be stale after the package has changed."""
    own = tmp_path / "own_loop.py"
    own.write_text("from gaitsmith.template.trajectory import swing_foot\n")
    monkeypatch.setitem(sys.modules, "own_loop", SimpleNamespace(__file__=str(own)))
    before = source_key.__wrapped__("own_loop")
    callee = "gaitsmith.splines.quartic_pair"  # of the callee
    edited, real = tmp_path / "edited.py", cache._module_file
    edited.write_text("# edited\n")
    monkeypatch.setattr(cache, "_module_file", lambda name: edited if name == callee else real(name))
    assert source_key.__wrapped__("own_loop") != before


def test_kernels_call_kernels_and_python_calls_them() -> None:
    @kernel
    def double(values: np.ndarray, at: int) -> float:
        return float(2.0 * values[at])

    @kernel
    def quadruple(values: np.ndarray) -> float:
        return float(2.0 * double(values, 0))

    assert quadruple(np.array([1.5, 0.0])) == 6.0
    assert double(np.array([0.0, 2.0]), 1) == 4.0
