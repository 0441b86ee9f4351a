"""Every outcome of a command becomes an exit code, at most one line on stderr, at most one document on stdout."""

import ast
import io
import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from gaitsmith.cli import dispatch, main
from gaitsmith.cli.dispatch import Command, Outcome, Table
from gaitsmith.errors import BadInput, CacheRefused
from gaitsmith.robots import load_robot
from gaitsmith.synthesis import Planner

LEAVES = sorted(dispatch.COMMANDS)


@pytest.fixture
def trial(monkeypatch: pytest.MonkeyPatch) -> Callable[[Callable[[], Outcome]], None]:
    """Put a command named ``trial`` in place that does what the test wants."""

    def install(body: Callable[[], Outcome]) -> None:
        monkeypatch.setitem(dispatch.COMMANDS, ("trial",), Command(dispatch.__name__, "run_trial", "for this test"))
        monkeypatch.setattr(dispatch, "run_trial", lambda words, program: body(), raising=False)

    return install


def outcome(code: int = 0, document: dict[str, Any] | None = None) -> Outcome:
    return Outcome(code, {"value": 1.0} if document is None else document, ["a table"])


def test_people_get_the_table_and_programs_the_document(trial: Any, capsys: pytest.CaptureFixture[str]) -> None:
    trial(lambda: outcome(1))
    assert main(["trial"]) == 1
    assert capsys.readouterr().out == "a table\n"
    assert main(["trial", "--json"]) == 1
    assert json.loads(capsys.readouterr().out) == {"value": 1.0}


def test_what_a_command_prints_stays_off_the_document(trial: Any, capsys: pytest.CaptureFixture[str]) -> None:
    def chatty() -> Outcome:
        print("progress")
        return outcome()

    trial(chatty)
    main(["trial", "--json"])
    captured = capsys.readouterr()
    assert json.loads(captured.out) == {"value": 1.0}
    assert captured.err == "progress\n"


def test_what_is_not_finite_is_null(trial: Any, capsys: pytest.CaptureFixture[str]) -> None:
    trial(lambda: outcome(document={"a": [float("nan"), float("inf"), 1.5], "b": (None, True)}))
    main(["trial", "--json"])
    assert json.loads(capsys.readouterr().out) == {"a": [None, None, 1.5], "b": [None, True]}


@pytest.mark.parametrize(
    ("error", "code", "part"),
    [
        (BadInput("--height", 3, "0.4 to 0.72 m", "lower it"), 2, "--height: got 3, expected 0.4 to 0.72 m; lower it"),
        (CacheRefused("cache folder x: owned by user 7"), 2, "owned by user 7"),
        (ValueError("two\nlines"), 70, "GAITSMITH_DEBUG=1"),
        (KeyboardInterrupt(), 130, "interrupted"),
    ],
)
@pytest.mark.parametrize("as_json", [False, True])
def test_failures_are_one_line(
    error: BaseException, code: int, part: str, as_json: bool, trial: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail() -> Outcome:
        raise error

    trial(fail)
    assert main(["trial", "--json"] if as_json else ["trial"]) == code
    captured = capsys.readouterr()
    assert len(captured.err.splitlines()) == 1
    assert part in captured.err
    if as_json:
        assert part in json.loads(captured.out)["error"]["message"]
    else:
        assert captured.out == ""


def test_a_path_that_no_file_system_takes_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    for words in (["log", "check"], ["why"], ["library", "show"]):
        assert main([*words, "a" * 300]) == 2
        assert capsys.readouterr().err.count("\n") == 1


def test_an_interrupted_import_is_an_interrupt(trial: Any, capsys: pytest.CaptureFixture[str]) -> None:
    """A library that turns Ctrl-C into an ImportError does not make it an error of the package."""

    def importing() -> Outcome:
        try:
            signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt as error:
            raise ImportError("half imported") from error
        raise AssertionError

    trial(importing)
    assert main(["trial"]) == dispatch.INTERRUPTED
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.parametrize("words", [["fly"], ["--fly"], ["robots", "fly"], ["bench", ""], ["robots", "--verbose"]])
def test_unknown_commands_are_refused(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(words) == 2
    assert "expected one of" in capsys.readouterr().err


@pytest.mark.parametrize("words", [[], ["--help"], ["robots"], ["bench", "-h"], ["--version"]])
def test_overviews(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(words) == 0
    captured = capsys.readouterr()
    assert captured.out
    assert not captured.err


@pytest.mark.parametrize("path", LEAVES)
def test_every_command_has_help(path: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*path, "--help"]) == 0
    assert "--json" in capsys.readouterr().out


def test_a_reader_that_leaves_changes_no_exit_code(trial: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    class Closed(io.StringIO):
        def write(self, text: str) -> int:
            raise BrokenPipeError

    monkeypatch.setattr(sys, "stdout", Closed())
    for item in ("a line", Table(("a", "table"), [])):
        trial(lambda item=item: Outcome(1, {}, [item]))
        assert main(["trial"]) == 1
        assert main(["trial", "--json"]) == 1


@pytest.mark.parametrize("words", [["robots", "show"], ["robots", "show", "--json"]])
def test_a_full_disk_behind_stdout_is_one_line(
    words: list[str], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    if not os.path.exists("/dev/full"):
        pytest.skip("needs /dev/full")
    with open("/dev/full", "w", encoding="utf-8") as full:
        monkeypatch.setattr(sys, "stdout", full)
        assert main(words) == 2
        monkeypatch.undo()
    told = capfd.readouterr().err
    assert told.count("\n") == 1
    assert told.startswith("gaitsmith: standard output: got 'no space left on device'")


@pytest.mark.parametrize("words", [["robots", "list"], ["robots", "list", "--json"], ["robots", "show", "nobody"]])
def test_closed_streams_change_no_exit_code(words: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdout", None)
    monkeypatch.setattr(sys, "stderr", None)
    assert main(words) == (2 if "nobody" in words else 0)


def test_an_encoding_without_our_letters_shows_question_marks(trial: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    shown = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr(sys, "stdout", shown)
    trial(lambda: Outcome(0, {}, ["40 N·m"]))
    assert main(["trial"]) == 0
    assert shown.buffer.getvalue() == b"40 N?m\n"


def _loaded(code: str, heavy: set[str]) -> list[str]:
    """Which of these modules a fresh process has read after this code."""
    lazy = "type(module).__name__ != '_LazyModule'"
    told = (
        f"print(sorted(name for name, module in sys.modules.items() if name in {heavy!r} and {lazy}), file=sys.stderr)"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    words = [sys.executable, "-c", f"import sys; from gaitsmith.cli import main; {code}; {told}"]
    done = subprocess.run(words, capture_output=True, text=True, env=environment, check=True, timeout=120)
    return list(ast.literal_eval(done.stderr.splitlines()[-1]))


def test_help_loads_no_engine() -> None:
    code = f"[main([*words, '--help']) for words in {LEAVES!r}]"
    assert _loaded(code, {"numba", "mujoco", "scipy", "casadi", "matplotlib", "mcap", "rich"}) == []


def test_planning_loads_nothing_that_it_does_not_use() -> None:
    assert Planner(load_robot("thbip_ii")).functions.compiled  # compiling them takes numba
    others = {"numba", "matplotlib", "mcap", "numpy.f2py", "numpy.f2py.f2py2e", "numpy.testing", "unittest", "trimesh"}
    assert _loaded("main(['plan', 'cyclic', '--max-iterations', '1'])", others | {"scipy.linalg"}) == ["scipy.linalg"]


def test_a_process_that_ends_looks_for_no_garbage() -> None:
    code = "import gc, sys; from gaitsmith.cli import main; sys.argv[1:] = ['--version']; main(); {}"
    for before, frozen in (("", True), ("gc.unfreeze(); main(['--version']);", False)):
        words = [sys.executable, "-c", code.format(f"{before} print(gc.get_freeze_count() > 0)")]
        done = subprocess.run(words, capture_output=True, text=True, check=True, timeout=60)
        assert done.stdout.splitlines()[-1] == str(frozen)


def test_no_variable_of_a_library_stops_a_command() -> None:
    code = (
        "import sys; from gaitsmith.cli import main; code = main(['robots', 'list']); import matplotlib.figure, mujoco;"
        "from numba.core import config; sys.exit(code or config.DISABLE_JIT)"
    )
    environment = {**os.environ, "MUJOCO_GL": "no such library", "MPLBACKEND": "no such backend"}
    environment |= {"NUMBA_NUM_THREADS": "0", "NUMBA_DISABLE_JIT": "1", "NUMBA_OPT": "no such level"}
    environment |= {"PYTHONPATH": os.pathsep.join(sys.path)}
    words = [sys.executable, "-c", code]
    done = subprocess.run(words, env=environment, capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_a_working_folder_that_is_gone_is_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    assert main(["walk", "--out", "run"]) == 2
    assert capsys.readouterr().err.startswith("gaitsmith: working folder: got nothing, expected a folder that has not")


def test_a_cache_folder_in_nobodys_home_is_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("GAITSMITH_CACHE_DIR", "~no-such-user/cache")
    assert main(["robots", "list"]) == 2
    assert capsys.readouterr().err.startswith("gaitsmith: GAITSMITH_CACHE_DIR: got '~no-such-user/cache', expected")
