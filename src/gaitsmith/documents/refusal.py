"""What a file's model refuses, in our own words: the entry, the value, and what would be valid there."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from gaitsmith.documents.about import VALID_NAME, check_name
from gaitsmith.errors import BadInput

_OWN = "value_error"
_KINDS = {bool: "true or false", int: "a whole number", float: "a finite number"}
_NOUNS = {int: "numbers", float: "numbers", str: "texts"}


def refusal(error: ValidationError, model: type[BaseModel], source: str = "") -> BadInput:
    """The first thing that a model refuses, as ``source: phases[2].duration: got ..., expected ...``.

    Args:
        error: what the model raised.
        model: the model.
        source: the file's name; empty for none.
    """
    first = error.errors(include_url=False, include_context=False)[0]
    place = first["loc"]
    if place[-1:] == ("[key]",) and first["type"] != "extra_forbidden":
        place = place[:-1]
    entry = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in place).lstrip(".")
    if first["type"] == "extra_forbidden":
        known = list(_fields(_hint(model, place[:-1])[0]))
        valid = f"no such entry; this table takes only {', '.join(known)}"
        found = BadInput(entry, first["input"], valid, nearest(place[-1], known))
    elif first["type"] == _OWN:
        found = BadInput(entry, first["input"], first["msg"].removeprefix("Value error, "))
    elif first["type"] == "json_invalid":
        found = BadInput(entry, first["msg"].rpartition(": ")[2], "values that are not nested deeply")
    else:
        value = None if first["type"] == "missing" else first["input"]
        hint, limits = _hint(model, place)
        choices = [str(item) for item in get_args(hint)] if get_origin(hint) is Literal else []
        found = BadInput(entry, value, _valid(hint, limits), nearest(value, choices))
    return found.within(source)


def nearest(word: object, choices: Iterable[str]) -> str:
    """A hint at what may have been meant; empty where nothing is near."""
    close = difflib.get_close_matches(str(word)[:100], list(choices), n=1)
    return f"did you mean {close[0]}?" if close else ""


def _fields(model: type[BaseModel]) -> dict[str, FieldInfo]:
    """The entries that a table may have."""
    return {field.alias or name: field for name, field in model.model_fields.items()}


def _hint(hint: Any, place: Iterable[int | str]) -> tuple[Any, tuple[Any, ...]]:
    """Annotation and constraints of what lies at a place of a model."""
    hint, limits = plain(hint)
    for part in place:
        if isinstance(hint, type) and issubclass(hint, BaseModel):
            field = _fields(hint).get(str(part))
            if field is None:
                return hint, ()
            hint, more = plain(field.annotation)
            limits = (*field.metadata, *more)
        elif get_origin(hint) is dict:
            hint, limits = plain(get_args(hint)[1])
        elif get_origin(hint) is tuple:
            inside = get_args(hint)
            hint, limits = plain(inside[0 if inside[-1] is Ellipsis else min(int(part), len(inside) - 1)])
    return hint, limits


def plain(hint: Any) -> tuple[Any, tuple[Any, ...]]:
    """An annotation without its constraints and without None, and the constraints."""
    limits: tuple[Any, ...] = ()
    while True:
        if get_origin(hint) is Annotated:
            hint, *found = get_args(hint)
            for item in found:
                limits += tuple(getattr(item, "metadata", ())) or (item,)
        elif get_origin(hint) in (Union, UnionType):
            hint = next(item for item in get_args(hint) if item is not NoneType)
        else:
            return hint, limits


def _valid(hint: Any, limits: tuple[Any, ...]) -> str:
    """What is valid, in words."""
    if get_origin(hint) is Literal:
        return f"one of {', '.join(str(item) for item in get_args(hint))}"
    if get_origin(hint) is tuple:
        inside = get_args(hint)
        of = "rows" if get_origin(plain(inside[0])[0]) is tuple else _NOUNS.get(plain(inside[0])[0], "tables")
        return f"a list{_count(limits)} {of}" if inside[-1] is Ellipsis else f"a list of {len(inside)} {of}"
    if hint is str:
        named = any(getattr(item, "func", None) is check_name for item in limits)
        return VALID_NAME if named else f"text{_count(limits)} characters" if _count(limits) else "text"
    return _KINDS.get(hint, "a table") + span(limits)


def span(limits: tuple[Any, ...]) -> str:
    """The range that constraints leave, in words that follow a noun; empty without any."""
    least, above, most, below = (_limit(limits, name) for name in ("ge", "gt", "le", "lt"))
    low = f" from {least:g}" if least is not None else f" above {above:g}" if above is not None else ""
    to = "to" if least is not None else "up to"
    high = f" {to} {most:.10g}" if most is not None else f" below {below:.10g}" if below is not None else ""
    return low + high


def _limit(limits: tuple[Any, ...], name: str) -> Any:
    """The number of a constraint, None without it."""
    return next((getattr(item, name) for item in limits if getattr(item, name, None) is not None), None)


def _count(limits: tuple[Any, ...]) -> str:
    """How many, in words."""
    low, high = _limit(limits, "min_length"), _limit(limits, "max_length")
    if low is None and high is None:
        return ""
    if low == high:
        return f" of {low}"
    return f" of {low or 0} to {high}" if high is not None else f" of at least {low}"
