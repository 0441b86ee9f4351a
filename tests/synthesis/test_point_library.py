"""Compiled dynamics: whole or not at all, checked on load, and nothing left behind by an interrupt."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import casadi as ca
import pytest

import gaitsmith
from gaitsmith.synthesis.point import expressions as point_expressions
from gaitsmith.synthesis.point.functions import point_functions
from gaitsmith.synthesis.point.layout import KINDS
from gaitsmith.synthesis.point.library import find_compiler

WAIT = 20.0  # s: far more than a process needs to start or to end
needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")


@pytest.fixture
def small(monkeypatch, tmp_path):
    """Three functions that compile in no time, and an empty cache."""
    x = ca.SX.sym("x")
    made = [ca.Function(f"{kind}_right", [x], [x * k]) for k, kind in enumerate(KINDS, start=2)]
    monkeypatch.setattr(point_expressions, "point_expressions", lambda biped: made)
    monkeypatch.setenv("GAITSMITH_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


def _load(biped):
    notices = []
    found = point_functions(biped, notices.append)
    assert float(found.sides[0][0](1.5)) == 3.0
    return found, notices


@needs_compiler
@pytest.mark.parametrize("damage", [lambda b: b"", lambda b: b"junk", lambda b: b[:4000], lambda b: b[:-1] + b"x"])
def test_a_damaged_library_is_built_again(planner, small, damage):
    first, notices = _load(planner.biped)
    assert first.compiled
    assert len(notices) == 1
    assert _load(planner.biped)[1] == []
    (library,) = small.glob("point-*/*.so")
    content = library.read_bytes()
    library.unlink()  # this process has the old one in its memory
    library.write_bytes(damage(content))
    healed, notices = _load(planner.biped)
    assert healed.compiled
    assert "compiling" in notices[0]
    assert [path.suffix for path in small.glob("point-*/*")] == [".so"]


@needs_compiler
@pytest.mark.parametrize("place", ["/proc/nope", f"{__file__}/sub"])
def test_without_a_place_to_keep_it_there_is_one_notice(planner, small, monkeypatch, place):
    monkeypatch.setenv("GAITSMITH_CACHE_DIR", place)
    found, notices = _load(planner.biped)
    assert not found.compiled
    assert len(notices) == 1
    assert "GAITSMITH_CACHE_DIR" in notices[0]


@pytest.mark.parametrize("value", ["/nonexistent", __file__, "gcc -m64"])
def test_a_compiler_that_cannot_be_run_is_named(planner, small, monkeypatch, value):
    monkeypatch.setenv("GAITSMITH_CC", value)
    found, notices = _load(planner.biped)
    assert not found.compiled
    assert "GAITSMITH_CC" in notices[0]
    assert value[:40] in notices[0]


def test_a_compiler_that_fails_is_reported(planner, small, monkeypatch):
    monkeypatch.setenv("GAITSMITH_CC", "false")
    found, notices = _load(planner.biped)
    assert not found.compiled
    assert "exit status 1" in notices[-1]
    assert not list(small.glob("point-*/*"))


def test_an_interrupt_ends_the_compiler_and_its_children(tmp_path):
    compiler, mark = tmp_path / "cc", tmp_path / "child"
    compiler.write_text(f"#!/bin/sh\nsleep 60 &\necho $! > {mark}.part\nmv {mark}.part {mark}\nwait\n")
    compiler.chmod(0o755)
    code = f"import os\nfrom gaitsmith.synthesis.point.library import _run\n_run([{str(compiler)!r}], dict(os.environ))"
    source = str(Path(gaitsmith.__file__).parents[1])
    # A job in the background of a shell ignores Ctrl-C; the tests may be one.
    usual = "import signal\nsignal.signal(signal.SIGINT, signal.default_int_handler)\n"
    process = subprocess.Popen(
        [sys.executable, "-c", usual + code], env=os.environ | {"PYTHONPATH": source}, stderr=subprocess.DEVNULL
    )
    try:
        deadline = time.monotonic() + WAIT
        while not mark.exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        child = int(mark.read_text())
        process.send_signal(signal.SIGINT)
        process.wait(WAIT)
        while _alive(child) and time.monotonic() < deadline:
            time.sleep(0.05)
        assert not _alive(child)
    finally:
        process.kill()
        process.wait()


def _alive(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
