"""Command lines generated from models: every field that says what it is, is an option, and its range the rule.

Whatever is wrong with a command line ends in one :class:`~gaitsmith.errors.BadInput`.
"""

from __future__ import annotations

import inspect
import math
import re
import shutil
import textwrap
from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal, TypeVar, get_args, get_origin

from pydantic import BaseModel, create_model

from gaitsmith.documents import About, Frozen, Worded, about, checked, nearest, plain, span
from gaitsmith.errors import BadInput

_NUMBER = re.compile(r"-(\.?\d|inf|nan)", re.IGNORECASE)
_COLUMN = 26  # of the help, where meanings begin
_Model = TypeVar("_Model", bound="Arguments")


@dataclass(frozen=True)
class Positional(About):
    """The argument that takes the one word without an option before it, or all of them if it repeats."""


class Arguments(Frozen):
    """Base of what commands take; the docstring of a command's own class is the head of its help."""

    json_: Annotated[bool, About("Print one JSON document instead of text", flag="--json")] = False


OwnRobot = Annotated[
    str | None,
    About("The robot it was planned for, if not one of the package", metavar="NAME_OR_PATH", absent="the one it names"),
]
GaitFile = Annotated[str, Positional("Gait file", metavar="GAIT")]


def overriding(
    own: type[_Model],
    model: type[BaseModel],
    absent: str,
    defaults: Mapping[str, Any] | None = None,
    without: Container[str] = (),
) -> type[_Model]:
    """A command's own arguments, and every described field of a model as an option that may be left out.

    Args:
        model: what the options override.
        absent: what the help calls a value that the model has no default for.
        defaults: what the help shows instead of the model's own defaults.
        without: fields that are no options here.
    """
    fields: dict[str, Any] = {}
    for name, field in model.model_fields.items():
        described = about(field)
        if described is not None and name not in without:
            usual = (defaults or {}).get(name, field.default)
            shown = "none" if usual == "" else _shown(usual)
            entry = replace(described, absent=described.absent or shown or absent)
            rules = [rule for rule in field.metadata if rule is not described]
            kind: Any = Annotated[(field.annotation, *rules)] if rules else field.annotation
            fields[name] = (Annotated[kind | None, entry], None)
    combined: type[_Model] = create_model(own.__name__, __base__=own, __doc__=own.__doc__, **fields)
    return combined


@dataclass(frozen=True)
class _Option:
    """One field as the command line sees it; `least` to `most` words, or none for a switch."""

    name: str
    word: str
    about: About
    kind: Any
    least: int
    most: int
    repeats: bool
    default: Any
    range: str

    @property
    def usage(self) -> str:
        """What stands for the values."""
        if get_origin(self.kind) is Literal:
            return "{" + ",".join(map(str, get_args(self.kind))) + "}"
        return self.about.metavar

    def value(self, words: list[str], first: str) -> Any:
        """What the words after an option say; what is no number stays a word, for the type to refuse."""
        found = [self._one(word) for word in words]
        right = self.least <= len(words) <= self.most
        if self.most == 1 and not right:
            raise BadInput(self.word, None, f"a value ({self.usage})", self.about.meaning)
        if self.most > 1 and not (right and _finite(found)):
            count = " or ".join(map(str, range(self.least, self.most + 1)))
            remedy = f"name the {first} before the options" if first and words else ""
            raise BadInput(self.word, " ".join(words) or None, f"{count} finite numbers ({self.usage})", remedy)
        return found + [0.0] * (self.most - len(found)) if self.most > 1 else found[0]

    def _one(self, word: str) -> Any:
        if get_origin(self.kind) is Literal:
            return next((item for item in get_args(self.kind) if str(item) == word), word)
        if not word.strip() or "\0" in word:
            raise BadInput(self.word, word, f"{self.usage}, a word that is not empty")
        if not issubclass(self.kind, BaseModel):
            return _number(self.kind, word)
        return word if issubclass(self.kind, Worded) else self._compact(word)

    def _compact(self, word: str) -> dict[str, Any]:
        """A table whose required entries are numbers, written with commas."""
        sizes = {
            name: len(get_args(field.annotation)) if get_origin(field.annotation) is tuple else 0
            for name, field in self.kind.model_fields.items()
            if field.is_required()
        }
        count = sum(max(size, 1) for size in sizes.values())
        numbers = [_number(float, part) for part in word.split(",")]
        if len(numbers) != count or not _finite(numbers):
            example = ",".join(str(k + 1) for k in range(count))
            raise BadInput(
                self.word, word, f"{count} finite numbers ({self.usage})", f"for example {self.word} {example}"
            )
        found: dict[str, Any] = {}
        for name, size in sizes.items():
            found[name], numbers = numbers[:size] if size else numbers[0], numbers[max(size, 1) :]
        return found


def _finite(numbers: list[Any]) -> bool:
    return all(isinstance(number, float) and math.isfinite(number) for number in numbers)


def _number(kind: Any, word: str) -> Any:
    """The word as a number of a kind; the word itself if it is none, or if it is none of the kind."""
    try:
        return kind(word)
    except ValueError:
        return word


def _options(kind: type[BaseModel]) -> list[_Option]:
    """Options in the order of the fields, inherited ones after the class's own; ``--json`` comes last."""
    found = []
    for name, field in kind.model_fields.items():
        described = about(field)
        if described is None:
            continue
        value, limits = plain(field.annotation)
        inside = get_args(value) if get_origin(value) is tuple else ()
        repeats = inside[-1:] == (Ellipsis,)
        if inside:
            value = plain(inside[0])[0]
        metavar = described.metavar.split()
        most = 0 if value is bool else 1 if repeats or not inside else len(inside)
        least = most if len(metavar) < 2 else sum("[" not in part for part in metavar)
        word = described.metavar if isinstance(described, Positional) else described.flag or flag(name)
        shown = span((*field.metadata, *limits))
        default = ... if field.is_required() else field.default
        found.append(_Option(name, word, described, value, least, most, repeats, default, shown))
    own = inspect.get_annotations(kind)
    return sorted(found, key=lambda option: (option.name == "json_", option.name not in own))


def parse(kind: type[_Model], words: Sequence[str], program: str) -> _Model:
    """Read a command line.

    Args:
        kind: the command's arguments; its docstring and its fields' descriptions are the help.
        program: the command's full name, for messages.

    Raises:
        BadInput: an unknown option, a missing value, a value of the wrong kind or out of range.
        SystemExit: after printing help, code 0.
    """
    options = _options(kind)
    if {"-h", "--help"} & set(words):
        print(_help(kind, options, program))  # noqa: T201
        raise SystemExit(0)
    values: dict[str, Any] = {}
    for option, value in _read(options, words, program):
        if option.repeats:
            values.setdefault(option.name, []).append(value)
        else:
            values[option.name] = value
    for option in options:
        if option.name not in values and option.default is ...:
            raise BadInput(option.word, None, f"a value ({option.about.meaning})", f"see {program} --help")
    try:
        return checked(kind, values)
    except BadInput as error:
        raise as_flag(error, kind) from None


def _read(options: list[_Option], words: Sequence[str], program: str) -> Iterator[tuple[_Option, Any]]:
    """Options and their values, in the order given."""
    flags = {option.word: option for option in options if not isinstance(option.about, Positional)}
    place = next((option for option in options if isinstance(option.about, Positional)), None)
    first = place.word if place else ""
    rest, ended, taken = list(words), False, False
    while rest:
        word = rest.pop(0)
        if word == "--" and not ended:
            ended = True
        elif not ended and _is_option(word):
            name, equals, value = word.partition("=")
            option = flags.get(name)
            if option is None:
                raise BadInput(
                    "option", name, f"an option of {program}", nearest(name, flags) or f"see {program} --help"
                )
            given = [value] if equals else []
            if not option.most:
                if equals:
                    raise BadInput(name, value, "no value", f"write {name} alone")
                yield option, True
                continue
            while not equals and rest and not _is_option(rest[0]) and rest[0] != "--":
                if option.most == 1 and given:
                    break
                given.append(rest.pop(0))
            yield option, option.value(given, first)
        elif place is None or (taken and not place.repeats):
            raise BadInput("argument", word, "nothing more on this command line", f"see {program} --help")
        else:
            taken = True
            yield place, place.value([word], first)


def _is_option(word: str) -> bool:
    return len(word) > 1 and word[0] == "-" and not _NUMBER.match(word)


def flag(name: str) -> str:
    """The option of a field."""
    return "--" + name.replace("_", "-")


def as_flag(error: BadInput, kind: type[BaseModel], given: Sequence[str] | None = None) -> BadInput:
    """The error with its field named as the user wrote it, if that was an option.

    Args:
        error: its field is one of a model's, such as ``pushes[0].time``.
        kind: the command's arguments.
        given: names of the fields that options gave; None takes all.
    """
    name, _, rest = re.match(r"(\w*)(\[\d+\])?\.?(.*)", error.field, re.DOTALL).groups()  # type: ignore[union-attr]
    words = {option.name: option.word for option in _options(kind)}
    if name not in words or ": " in error.field or (given is not None and name not in given):
        return error
    return error.named(f"{words[name]} {rest}".strip())


def _shown(value: Any) -> str:
    if isinstance(value, list | tuple):
        return " ".join(map(_shown, value))
    if isinstance(value, float):
        return f"{value:g}"
    return str(value) if isinstance(value, (str, int)) and not isinstance(value, bool) else ""


def _help(kind: type[BaseModel], options: list[_Option], program: str) -> str:
    """Usage, the head, and a line or more for every option."""
    width = max(60, min(shutil.get_terminal_size().columns, 100))
    rows: dict[bool, list[str]] = {True: [], False: []}
    for option in options:
        positional = isinstance(option.about, Positional)
        term = (f"[{option.word}]" if option.default is not ... else option.word) if positional else option.word
        term = term if positional else f"{term} {option.usage}".strip()
        told = f"{option.about.meaning}{f', {option.about.unit}' if option.about.unit else ''}."
        absent = option.about.absent() if callable(option.about.absent) else option.about.absent
        default = _shown(absent if option.default is None else option.default)
        details = [f"default: {default}{option.range.replace(' ', ', ', 1)}"] if default and not option.repeats else []
        details += ["repeatable"] if option.repeats else []
        details += ["required"] if option.default is ... and not positional else []
        told += "".join(f" ({detail})" for detail in details)
        lines = textwrap.wrap(told, width - _COLUMN)
        lead = f"  {term}"
        rows[positional] += [lead] if len(lead) > _COLUMN - 2 else [f"{lead:<{_COLUMN}}{lines.pop(0)}"]
        rows[positional] += [" " * _COLUMN + line for line in lines]
    rows[False].insert(0, f"{'  -h, --help':<{_COLUMN}}Show this and exit.")
    place = next((f" {row.split()[0]}" for row in rows[True]), "")
    head = f"usage: {program} [OPTIONS]{place}\n\n{inspect.cleandoc(kind.__doc__ or '')}\n"
    arguments = "\narguments:\n" + "\n".join(rows[True]) + "\n" if rows[True] else ""
    return f"{head}{arguments}\noptions:\n" + "\n".join(rows[False])
