"""``gaitsmith why`` confirms a cause, tells the run's summary, and refuses a run that stands."""

from __future__ import annotations

import contextlib
import io
import json
from pathlib import Path

import pytest

from gaitsmith.cli import main


def run(*words: str) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of one command line."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main(words)
    return code, out.getvalue(), err.getvalue()


def test_a_push_is_confirmed(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    walk = ["walk", "--duration", "4", "--push", "2,0,90,0", "--out", str(folder), "--no-figures"]
    code, text, _ = run(*walk)
    assert code == 1
    assert "likeliest cause: push of 90.0 N·s" in text
    code, text, _ = run("why", str(folder), "--json")
    document = json.loads(text)
    assert (code, document["kind"], document["cause"]["confirmed"]) == (0, "push", True)
    assert document["trials"][-1]["relaxed"] == "no push"
    fall = json.loads((folder / "summary.json").read_text())["fall"]
    assert fall["cause"] == document["cause"]
    code, text, _ = run("why", str(folder / "log.mcap"))  # a run's log stands for its folder
    assert "cause: push of 90.0 N·s at 2.000 s, confirmed" in " ".join(text.split())
    (folder / "summary.json").write_text("{}")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("gaitsmith.simulation.replay.why", lambda *_: pytest.fail("refused before the work"))
        code, _, error = run("why", str(folder))
    assert (code, error.count("\n")) == (2, 1)
    assert "use --no-summary" in error


def test_a_run_that_stands_is_one_line(tmp_path: Path) -> None:
    scenario = tmp_path / "stands.toml"
    scenario.write_text("duration = 1.2\n", encoding="utf-8")
    code, _, error = run("why", str(scenario))
    assert code == 2
    assert error.count("\n") == 1
    assert "a run that ends in a fall" in error


def test_a_fault_that_does_not_exist_is_one_line() -> None:
    code, _, error = run("walk", "--fault", "nose:nan@1s,1s")
    assert code == 2
    assert error.startswith("gaitsmith: --fault component: got 'nose'")
    assert error.count("\n") == 1


def test_a_folder_without_a_run_is_named_as_such(tmp_path: Path) -> None:
    code, _, error = run("why", str(tmp_path))
    assert code == 2
    assert error.startswith("gaitsmith: RUN: got ")
    assert error.count("\n") == 1
