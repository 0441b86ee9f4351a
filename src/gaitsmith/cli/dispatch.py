"""The command ``gaitsmith``: finds the command, and turns every outcome into an exit code and what is printed.

Only the chosen command's module is imported, and it imports the engine only when it runs, or when its help shows the
engine's own defaults: other help stays fast.

Exit codes: 0 done; 1 the robot fell, or a gait file is not right; 2 bad input; 3 not solved or not certified; 70 an
error of the package itself (EX_SOFTWARE); 130 Ctrl-C, SIGTERM or SIGHUP.
"""

from __future__ import annotations

import contextlib
import io
import json
import logging
import math
import os
import sys
import traceback
import warnings
from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any, NamedTuple, TextIO

import gaitsmith
from gaitsmith.cache_folder import cache_root
from gaitsmith.cli.interrupts import Interrupts
from gaitsmith.errors import BadInput, GaitsmithError
from gaitsmith.files import reason
from gaitsmith.lazy import put_off

DONE, FELL, BAD_INPUT, NOT_SOLVED, INTERNAL, INTERRUPTED = 0, 1, 2, 3, 70, 130


@dataclass(frozen=True)
class Table:
    """A table of words; the columns numbered in ``left`` hold words, the others numbers; rows named in ``red`` are."""

    headings: Sequence[str]
    rows: Iterable[Sequence[str]]
    left: Container[int] = (0,)
    title: str = ""
    red: Container[str] = ()


class Styled(NamedTuple):
    """A line, and how a terminal shows it."""

    line: str
    style: str


Text = str | Styled | Table


@dataclass(frozen=True)
class Outcome:
    """What a command hands back.

    Attributes:
        document: what ``--json`` prints.
        text: the same for people; not asked for with ``--json``.
    """

    code: int
    document: dict[str, Any]
    text: Iterable[Text]


@dataclass(frozen=True)
class Command:
    """One leaf of the command tree: where its ``run(words, program) -> Outcome`` lives.

    It raises BadInput for a command line, a robot, a file or a folder that cannot be used.
    """

    module: str
    function: str
    summary: str


COMMANDS: dict[tuple[str, ...], Command] = {
    ("demo",): Command("gaitsmith.cli.demo", "demo", "both papers' robots walk, and a page shows it"),
    ("walk",): Command("gaitsmith.cli.walk", "walk", "walk a robot through a scenario in closed loop with physics"),
    ("reproduce",): Command("gaitsmith.cli.reproduce", "reproduce", "both papers' figures made again and compared"),
    ("report",): Command("gaitsmith.cli.show", "report", "a run as one HTML page that opens anywhere"),
    ("plot",): Command("gaitsmith.cli.show", "plot", "figures of a run, PNG and SVG"),
    ("video",): Command("gaitsmith.cli.show", "video", "a run as a film"),
    ("why",): Command("gaitsmith.cli.why", "why", "why a robot fell: the run again, without what may have caused it"),
    ("adopt",): Command("gaitsmith.cli.adopt", "adopt", "a card for a robot from its model alone, tested"),
    ("tune",): Command("gaitsmith.cli.tune", "tune", "gains found by search, and what they gain"),
    ("live",): Command("gaitsmith.cli.live", "live", "a page to watch and steer a walk, or to replay a recorded run"),
    ("plan",): Command(
        "gaitsmith.cli.plan", "plan", "plan a gait: cyclic, start, stop, walk, kick, jump, sweep, or a file"
    ),
    ("library", "build"): Command("gaitsmith.cli.library", "build", "a grid of gaits planned into a folder"),
    ("library", "show"): Command("gaitsmith.cli.library", "show", "what a library of gaits holds"),
    ("verify",): Command("gaitsmith.cli.verify", "verify", "check a gait file against physics"),
    ("export",): Command("gaitsmith.cli.export", "export", "a gait file as CSV or MCAP"),
    ("log", "check"): Command("gaitsmith.cli.log_check", "check", "what a run recorded; mends what a killed one left"),
    ("log", "convert"): Command(
        "gaitsmith.cli.log_convert", "convert", "a log as CSV, Parquet, NumPy, Foxglove, ROS bag"
    ),
    ("robots", "list"): Command("gaitsmith.cli.robots", "list_robots", "the robots that come with the package"),
    ("robots", "show"): Command("gaitsmith.cli.robots", "show", "a robot's joints, legs, limits and assumptions"),
    ("robots", "check"): Command("gaitsmith.cli.robots", "check", "check a card and the model it names"),
    ("bench", "tick"): Command("gaitsmith.cli.bench", "bench", "time of one control tick"),
    ("bench", "push"): Command("gaitsmith.cli.bench", "bench", "pushes in all directions and phases"),
    ("bench", "battery"): Command("gaitsmith.cli.bench", "bench", "speeds, heights, slopes, boxes, noise"),
    ("bench", "falls"): Command(
        "gaitsmith.cli.bench", "bench", "falls of known cause, and whether the report names it"
    ),
    ("bench", "faults"): Command("gaitsmith.cli.bench", "bench", "sensors, motors and ticks that fail"),
    ("bench", "crash"): Command("gaitsmith.cli.bench", "bench", "what fells a controller, on one sheet"),
    ("bench", "tour"): Command("gaitsmith.cli.bench", "bench", "the public teleoperation test: waypoints and punches"),
}


def run(words: list[str], interrupts: Interrupts) -> int:
    """Run one command line, and turn its end into an exit code and what is printed."""
    _settle_libraries()
    logging.getLogger("matplotlib").setLevel(logging.ERROR)  # it tells of fonts on stderr
    wants_json = "--json" in words and not {"-h", "--help"} & set(words)
    with _streams() as out, warnings.catch_warnings():
        warnings.showwarning = _warned
        return _guarded(words, wants_json, out, interrupts)


def _settle_libraries() -> None:
    """Variables that libraries read when they are imported: a value that one dislikes stops its import.

    Pictures ask for their graphics library by name and need no window; kernels are compiled with settings of their own;
    what other packages would add to the checks of data stays out.
    """
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    os.environ |= {"MUJOCO_GL": "off", "MPLBACKEND": "agg", "PYDANTIC_DISABLE_PLUGINS": "__all__"}
    for name in [name for name in os.environ if name.startswith("NUMBA_")]:
        del os.environ[name]
    put_off("numpy.f2py", "numpy.testing")  # SciPy copies all names of NumPy, and these load what nobody needs


@contextlib.contextmanager
def _streams() -> Iterator[TextIO]:
    """Standard output as it is given: a closed one swallows everything, and a poor encoding shows question marks."""
    with contextlib.ExitStack() as opened:
        for name, redirect in (("stdout", contextlib.redirect_stdout), ("stderr", contextlib.redirect_stderr)):
            stream = getattr(sys, name)
            if stream is None:
                opened.enter_context(redirect(opened.enter_context(open(os.devnull, "w", encoding="utf-8"))))
            elif isinstance(stream, io.TextIOWrapper):
                stream.reconfigure(errors="replace")
        yield sys.stdout


def _guarded(words: list[str], wants_json: bool, out: TextIO, interrupts: Interrupts) -> int:
    """Run the command, and turn every exception into an exit code and a line."""
    outcome, document = None, out if wants_json else None
    try:
        with contextlib.redirect_stdout(sys.stderr) if wants_json else contextlib.nullcontext():
            outcome = _run(words)
        if wants_json:
            _print_json(outcome.document, out)
        else:
            _print(outcome.text)
        out.flush()
        return outcome.code
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else DONE
    except BrokenPipeError:
        _discard(out)
        return DONE if outcome is None else outcome.code
    except (KeyboardInterrupt, Exception) as error:
        if outcome is not None and isinstance(error, OSError):
            _discard(out)
            return _failed(
                BAD_INPUT, f"standard output: got {reason(error)!r}, expected a stream that can be written", None
            )
        if not isinstance(error, KeyboardInterrupt) and not interrupts.seen:
            return _explained(error, document)
        interrupts.over = True  # a command records what it has only when it is done, or says what it has kept
        if outcome is not None:
            return _failed(INTERRUPTED, "interrupted while printing the result", None)
        return _failed(INTERRUPTED, "interrupted: nothing was recorded yet", document, kind="interrupted")


def _explained(error: Exception, document: TextIO | None) -> int:
    """One line for an error, and its exit code."""
    if isinstance(error, FileNotFoundError) and not _working_folder():
        error = BadInput("working folder", None, "a folder that has not been removed", "change to another one")
    elif isinstance(error, OSError) and isinstance(error.filename, str | os.PathLike):
        error = BadInput(str(error.filename), reason(error), "a path that can be used")
    if isinstance(error, BadInput):
        details = {name: getattr(error, name) for name in ("field", "valid", "remedy", "value")}
        return _failed(BAD_INPUT, str(error), document, kind="bad input", **details)
    if isinstance(error, GaitsmithError):
        return _failed(BAD_INPUT, str(error), document, kind=type(error).__name__)
    if os.environ.get("GAITSMITH_DEBUG"):
        traceback.print_exception(error)
    text = f"internal error: {type(error).__name__}: {error}; set GAITSMITH_DEBUG=1 to see where"
    return _failed(INTERNAL, text, document, kind="internal error")


def _working_folder() -> str:
    """Path of the working folder; empty if somebody removed it."""
    try:
        return os.getcwd()
    except OSError:
        return ""


def _run(words: list[str]) -> Outcome:
    """Find the command and run it."""
    for depth in (1, 2):
        command = COMMANDS.get(tuple(words[:depth]))
        if command is not None:
            cache_root()  # refuses a folder in the home of a user who has none
            run = getattr(import_module(command.module), command.function)
            outcome: Outcome = run(words[depth:], " ".join(["gaitsmith", *words[:depth]]))
            return outcome
    if words[:1] == ["--version"]:
        return Outcome(DONE, {"version": gaitsmith.__version__}, [f"gaitsmith {gaitsmith.__version__}"])
    group = words[0] if words and any(path[0] == words[0] for path in COMMANDS) else None
    members = [path for path in COMMANDS if group in (None, path[0])]
    rest = words[1:] if group else words
    if not rest or rest[0] in ("-h", "--help"):
        return Outcome(DONE, {"commands": [" ".join(path) for path in members]}, [_help(group, members)])
    valid = ", ".join(dict.fromkeys(path[1] if group else path[0] for path in members))
    field = f"gaitsmith {group}: command" if group else "command"
    raise BadInput(field, rest[0], f"one of {valid}", f"see gaitsmith {group or ''} --help")


def _help(group: str | None, members: list[tuple[str, ...]]) -> str:
    """The list of commands."""
    rows = "".join(f"  {' '.join(path):<16}{COMMANDS[path].summary}\n" for path in members)
    head = f"usage: gaitsmith {group or 'COMMAND'}{' COMMAND' if group else ''} [OPTIONS]\n\n"
    tail = "\nEvery command has --help and --json. gaitsmith --version prints the version.\n"
    codes = "Exit codes: 0 done, 1 the robot fell or verify failed, 2 bad input, 3 not solved or not certified,\n"
    return head + rows + tail + codes + "70 internal error, 130 interrupted."


def _warned(message: Warning | str, *_: Any, **__: Any) -> None:
    """A library's or our own warning as one line, without the place in the source."""
    with contextlib.suppress(OSError):
        sys.stderr.write(f"gaitsmith: {printable(' '.join(str(message).split()))}\n")


def _failed(code: int, text: str, document: TextIO | None, **details: Any) -> int:
    """One line on stderr, and the same as a document."""
    line = printable(" ".join(text.split()))
    with contextlib.suppress(OSError):
        sys.stderr.write(f"gaitsmith: {line}\n")
        sys.stderr.flush()
    if document is not None:
        try:
            _print_json({"error": {**details, "message": line}}, document)
            document.flush()
        except OSError:
            _discard(document)
    return code


def printable(text: str) -> str:
    """The text with question marks for what a terminal would take as a command; names come from people's files."""
    return text if text.isprintable() else "".join(c if c.isprintable() or c == "\n" else "?" for c in text)


def _print(text: Iterable[Text]) -> None:
    """Plain lines as they are, the rest through the terminal's library."""
    for item in text:
        if isinstance(item, str):
            sys.stdout.write(printable(item) + "\n")
        else:
            from gaitsmith.cli.printing import print_rich

            print_rich(item)


def _print_json(document: dict[str, Any], out: TextIO) -> None:
    out.write(json.dumps(_plain(document), indent=2, allow_nan=False) + "\n")


def _plain(value: Any) -> Any:
    """The same value in JSON's own types; what is not a finite number becomes null."""
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value if value is None or isinstance(value, (bool, int, float, str)) else str(value)


def _discard(out: TextIO) -> None:
    """The reader is gone: let the interpreter's last flush go nowhere."""
    with contextlib.suppress(OSError, ValueError):
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, out.fileno())
        os.close(null)
