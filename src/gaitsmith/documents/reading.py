"""From a file to checked data: bounded before it is parsed, parsed in linear time, checked strictly by a model."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NoReturn, TypeVar

from pydantic import BaseModel, ValidationError

from gaitsmith.documents.refusal import refusal
from gaitsmith.errors import BadInput
from gaitsmith.files import read_bounded

LIMIT = 1_000_000  # bytes of a TOML document
KEY_PARTS = 20  # of a dotted key; the parser's memory grows with their square
_Model = TypeVar("_Model", bound=BaseModel)
_TOKEN = re.compile(
    r"#[^\n]*"
    r'|"""(?:\\.|[^\\])*?(?:"""|\Z)'
    r"|'''.*?(?:'''|\Z)"
    r'|(?P<part>"(?:\\.|[^"\\\n])*"?|' + r"'[^'\n]*'?|[A-Za-z0-9_-]+)"
    r"|(?P<dot>\.)|[ \t]+|(?P<end>.)",
    re.DOTALL,
)  # what ends a run of dotted parts is matched as `end`; strings that never end take the rest of their line


def read_toml(path: Path, what: str) -> tuple[dict[str, Any], bytes]:
    """Tables of a TOML file, and its bytes.

    Raises:
        BadInput: the file cannot be read, is too large, or is not TOML.
    """
    content = read_bounded(path, LIMIT)
    return parse_toml(content, path.name, what), content


def parse_toml(content: bytes, source: str, what: str) -> dict[str, Any]:
    """Tables of a TOML document.

    Args:
        content: at most 1 MB.
        source: the file's name, which errors begin with.
        what: the document should be, with its article.

    Raises:
        BadInput: it is not TOML, or a dotted key has too many parts.
    """
    try:
        text = content.decode("utf-8-sig")
        _check_keys(text, source)
        return tomllib.loads(text)
    except RecursionError:
        raise BadInput(source, "deeply nested values", f"{what} in TOML") from None
    except ValueError as error:
        raise BadInput(source, str(error), f"{what} in TOML") from None


def _check_keys(text: str, source: str) -> None:
    dots = 0
    for token in _TOKEN.finditer(text):
        kind = token.lastgroup
        if kind == "dot":
            dots += 1
            if dots >= KEY_PARTS:
                raise BadInput(source, "a dotted key of more parts", f"keys of at most {KEY_PARTS} parts")
        elif kind == "end" or token[0][0] == "#":
            dots = 0


def toml(value: Any) -> str:
    """A value as TOML writes it, tables inline and every digit kept."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(name)} = {toml(item)}" for name, item in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else toml(name)


def parse_json(content: bytes) -> Any:
    """Values of a JSON document.

    Raises:
        ValueError: it is no JSON, holds NaN or an infinity, or gives a key twice.
        RecursionError: it is nested too deeply.
    """
    return json.loads(content.decode("utf-8-sig"), parse_constant=_refuse_constant, object_pairs_hook=_without_twins)


def _refuse_constant(word: str) -> NoReturn:
    raise ValueError(f"the number {word}")


def _without_twins(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """An object whose keys all differ: of two that are equal, readers may take either."""
    found: dict[str, Any] = {}
    for key, value in pairs:
        if key in found:
            raise ValueError(f"the key {key[:40]!r} twice in one object")
        found[key] = value
    return found


def checked(model: type[_Model], data: Any, source: str = "") -> _Model:
    """The model of plain data as TOML, JSON or a command line give it; a text is never taken for a number.

    Args:
        model: what the data should be.
        data: tables, lists, texts and numbers.
        source: what errors begin with, such as a file's name; empty for none.

    Raises:
        BadInput: naming the first entry that is wrong, its value, and what is valid there.
    """
    try:
        return model.model_validate_json(json.dumps(data, default=str), strict=True)
    except ValidationError as error:
        raise refusal(error, model, source) from None
    except BadInput as error:
        raise error.within(source) from None
    except (RecursionError, OverflowError, TypeError, ValueError) as error:
        raise BadInput(source or "entries", str(error), "values that are not nested deeply") from None
