"""Command lines read into frozen dataclasses: the only file that knows tyro.

Whatever is wrong with a command line ends in one :class:`~gaitsmith.errors.BadInput`, never in tyro's own report.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable, Sequence
from dataclasses import fields
from typing import Any, NoReturn, TypeVar, cast

import tyro
from tyro import _errors as events  # the only way to get at what was wrong; the lock pins the version
from tyro.conf import Positional as Positional
from tyro.conf import UseAppendAction as Repeatable
from tyro.constructors import PrimitiveConstructorSpec

from gaitsmith.errors import BadInput

__all__ = ["Positional", "Repeatable", "choice", "integer", "number", "numbers", "parse", "text"]

_Arguments = TypeVar("_Arguments")
_Spec = PrimitiveConstructorSpec[Any]


Absent = str | Callable[[], object]
"""What the help calls a default of None: a word, or a function asked only when help is shown."""


def _spec(
    read: Callable[[list[str]], Any],
    metavar: str,
    count: int | tuple[int, ...] = 1,
    absent: Absent = "scenario",
    span: tuple[float, float] | None = None,
) -> _Spec:
    """How tyro reads one option; ``read`` gets the words given, ``span`` is the valid range that the help shows."""

    def shown(value: Any) -> list[str]:
        if value is None:
            value = absent() if callable(absent) else absent
        text = f"{value:g}" if isinstance(value, float) else str(value)
        return (text + (f", from {span[0]:g} to {span[1]:g}" if span else "")).split()

    return PrimitiveConstructorSpec(
        nargs=count, metavar=metavar, instance_from_str=read, is_instance=lambda _: True, str_from_instance=shown
    )


def number(flag: str, metavar: str, absent: Absent = "scenario", span: tuple[float, float] | None = None) -> _Spec:
    """An option that takes one finite number, within ``span`` if given."""

    def read(words: list[str]) -> float:
        value = _finite(flag, words[0], f"a number ({metavar})")
        if span is not None and not span[0] <= value <= span[1]:
            raise BadInput(flag, value, f"{span[0]:g} to {span[1]:g}")
        return value

    return _spec(read, metavar, absent=absent, span=span)


def numbers(flag: str, metavar: str, counts: tuple[int, ...], remedy: str) -> _Spec:
    """An option that takes a few finite numbers, as many as one of ``counts``."""

    def read(words: list[str]) -> tuple[float, ...]:
        if len(words) not in counts:
            raise BadInput(flag, " ".join(words), f"{' or '.join(map(str, counts))} numbers ({metavar})", remedy)
        return tuple(_finite(flag, word, f"numbers ({metavar})", remedy) for word in words)

    return _spec(read, metavar, counts)


def integer(flag: str, metavar: str, least: int, most: int | None = None, absent: Absent = "scenario") -> _Spec:
    """An option that takes one whole number, from ``least`` to ``most``."""
    valid = f"a whole number from {least}" + (f" to {most}" if most is not None else "") + f" ({metavar})"

    def read(words: list[str]) -> int:
        try:
            value = int(words[0])
        except ValueError:
            raise BadInput(flag, words[0], valid) from None
        if value < least or (most is not None and value > most):
            raise BadInput(flag, words[0], valid)
        return value

    return _spec(read, metavar, absent=absent, span=None if most is None else (least, most))


def text(flag: str, metavar: str, absent: Absent = "scenario") -> _Spec:
    """An option that takes one word, which may not be empty."""

    def read(words: list[str]) -> str:
        if not words[0].strip() or "\0" in words[0]:
            raise BadInput(flag, words[0], f"{metavar}, a word that is not empty")
        return words[0]

    return _spec(read, metavar, absent=absent)


def choice(flag: str, choices: Sequence[str], absent: Absent = "scenario") -> _Spec:
    """An option that takes one of a few words."""

    def read(words: list[str]) -> str:
        if words[0] not in choices:
            raise BadInput(flag, words[0], f"one of {', '.join(choices)}", _nearest(words[0], choices))
        return words[0]

    return _spec(read, "{" + ",".join(choices) + "}", absent=absent)


def parse(kind: type[_Arguments], words: Sequence[str], program: str) -> _Arguments:
    """Read a command line.

    Args:
        kind: frozen dataclass with a default for every field; its docstrings are the help.
        words: the command line after the command's name.
        program: the command's full name, for messages.

    Raises:
        BadInput: an unknown option, a missing value, a value of the wrong kind.
        SystemExit: after printing help, code 0.
    """
    if {"-h", "--help"} & set(words):
        words = ["--help"]  # what is given already would be missing from the usage
    switches = [_flag(field.name) for field in fields(cast(Any, kind)) if field.type in ("bool", bool)]
    for word in words:
        switch, equals, value = word.partition("=")
        if equals and switch in switches:
            raise BadInput(switch, value, "no value", f"write {switch} alone")

    def refuse(event: events.ParseErrorEvent) -> None:
        _refuse(event, kind, program)

    with events.on_parse_error(refuse):
        try:
            return tyro.cli(
                kind, prog=program, args=list(words), console_outputs=True, config=(tyro.conf.FlagCreatePairsOff,)
            )
        except SystemExit as end:
            if end.code in (0, None):
                raise
            raise BadInput(program, " ".join(words), "a valid command line", f"see {program} --help") from None


def _refuse(event: events.ParseErrorEvent, kind: type[Any], program: str) -> NoReturn:
    """Turn tyro's report of a bad command line into our own."""
    remedy = f"see {program} --help"
    if isinstance(event, events.UnrecognizedArgs):
        word = event.tokens[0].partition("=")[0] if event.tokens[0].startswith("-") else event.tokens[0]
        flags = [_flag(field.name) for field in fields(kind)]
        if word.startswith("-"):
            raise BadInput("option", word, f"an option of {program}", _nearest(word, flags) or remedy)
        raise BadInput("argument", word, "nothing more on this command line", remedy)
    if isinstance(event, events.BadValue):
        flag = event.argument.lowered.name_or_flags[-1]
        found = "nothing" if event.offending_value is None else event.offending_value
        raise BadInput(flag, found, f"a value ({event.argument.lowered.metavar})", remedy)
    if isinstance(event, events.MissingArgs):
        missing = event.missing_arguments[0].arg
        name = missing.lowered.name_or_flags[-1] if missing.lowered.name_or_flags else missing.field.intern_name
        raise BadInput(name, "nothing", missing.lowered.metavar or "a value", remedy)
    raise BadInput(program, type(event).__name__, "a valid command line", remedy)


def _flag(name: str) -> str:
    return "--" + name.replace("_", "-")


def _finite(flag: str, word: str, valid: str, remedy: str = "") -> float:
    try:
        value = float(word)
    except ValueError:
        raise BadInput(flag, word, valid, remedy) from None
    if not math.isfinite(value):
        raise BadInput(flag, word, f"{valid}, finite", remedy)
    return value


def _nearest(word: str, choices: Sequence[str]) -> str:
    """A hint at what may have been meant."""
    close = difflib.get_close_matches(word, choices, n=1)
    return f"did you mean {close[0]}?" if close else ""
