"""Without a terminal a notice is one line; with one, nothing of the progress is cut off."""

import io
import sys

import pytest

from gaitsmith.cli.display import Display
from gaitsmith.synthesis.solution.ipopt import Progress

LAST = Progress(123, 123456.0, 0.01, "right_ankle_pitch torque", "N·m", 80.0)


def test_a_notice_is_one_line_without_a_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    with Display() as display:
        display.slow("compiling, once (about a minute)")
        display.iteration("cyclic", 12, LAST)
    captured = capsys.readouterr()
    assert captured.err == "gaitsmith: compiling, once (about a minute)\n"
    assert captured.out == ""


def test_eighty_columns_show_the_violation_and_the_time(monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    shown = Terminal()
    monkeypatch.setattr(sys, "stderr", shown)
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("TERM", "xterm")
    with Display() as display:
        display.iteration("cyclic", 12, LAST)
        display._progress.refresh()
        words = " ".join(shown.getvalue().split())
        for part in ("planning cyclic, refinement 12", "right_ankle_pitch", "0.8 N·m", "0:00:0"):
            assert part in words
