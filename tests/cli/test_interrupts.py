"""Ctrl-C is one line and code 130, whenever and however often it comes."""

import contextlib
import ctypes
import os
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import pytest

from gaitsmith.cli.interrupts import Interrupts, stop_if_heard
from gaitsmith.files import ENDING

# Sent by the program itself as soon as the first of its modules is imported: before anything heavy, then again.
EARLY = """
import signal, sys

class Finder:
    def find_spec(self, name, path=None, target=None):
        if name in {names}:
            signal.raise_signal(signal.SIGINT)

sys.meta_path.insert(0, Finder())
from gaitsmith.cli import main
code = main()
signal.raise_signal(signal.SIGINT)
sys.exit(code)
"""


@pytest.mark.parametrize(
    "names",
    [
        ("gaitsmith.cli.interrupts",),
        ("gaitsmith.cli.dispatch",),
        ("gaitsmith.cli.dispatch", "gaitsmith.cli.plan"),
        ("gaitsmith.cli.plan", "gaitsmith.synthesis"),
        ("numpy", "mujoco"),
    ],
)
def test_while_modules_are_loaded(names: tuple[str, ...]) -> None:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    words = [sys.executable, "-c", EARLY.format(names=names), "plan", "cyclic", "--speed", "0.4"]
    done = subprocess.run(words, capture_output=True, text=True, env=environment, timeout=60, check=False)
    assert done.returncode == 130
    assert done.stderr == "gaitsmith: interrupted: nothing was recorded yet\n"
    assert done.stdout == ""


def test_pressed_again_at_once_is_the_same_wish() -> None:
    with Interrupts() as interrupts:
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
        assert interrupts.seen
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_an_ignored_ctrl_c_stays_ignored() -> None:
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with Interrupts(ending=True):
            signal.raise_signal(signal.SIGINT)
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)


def test_a_signal_that_a_library_swallows_is_heard_all_the_same() -> None:
    before = signal.signal(signal.SIGTERM, signal.SIG_DFL)
    with Interrupts():
        stop_if_heard()
        with contextlib.suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)
        with pytest.raises(KeyboardInterrupt):
            stop_if_heard()
    with Interrupts():
        stop_if_heard()
    signal.signal(signal.SIGTERM, before)


def test_a_wish_that_a_compilers_callback_swallows_is_raised_again_and_shows_nothing(
    capsys: pytest.CaptureFixture[str],
) -> None:
    callback = ctypes.CFUNCTYPE(None)(lambda: signal.raise_signal(signal.SIGINT))
    with Interrupts() as interrupts, pytest.raises(KeyboardInterrupt):  # noqa: PT012
        callback()
        assert interrupts.seen
        time.sleep(10.0)
    assert capsys.readouterr().err == ""


def test_every_signal_waits_for_the_end_of_an_iteration_of_the_optimiser() -> None:
    from gaitsmith.synthesis.solution.ipopt import _signals_kept

    for number in ENDING:
        watch = SimpleNamespace(interrupted=None)
        with Interrupts():
            with _signals_kept(watch):  # type: ignore[arg-type]
                signal.raise_signal(number)
                assert isinstance(watch.interrupted, KeyboardInterrupt)
            with pytest.raises(KeyboardInterrupt):
                signal.raise_signal(number)
