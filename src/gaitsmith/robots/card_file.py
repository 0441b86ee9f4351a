"""From a card's text to a validated card: TOML, presets merged over the default, errors in one line."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from gaitsmith.errors import BadInput
from gaitsmith.files import read_bounded
from gaitsmith.robots.card import RobotCard

CARD_NAME = "card.toml"
CARD_LIMIT = 1_000_000


def read_card(path: Path) -> tuple[RobotCard, bytes]:
    """The card in a TOML file, and the file's bytes.

    Raises:
        BadInput: the file cannot be read, is not TOML, or is not a valid card.
    """
    content = read_bounded(path, CARD_LIMIT)
    try:
        data = tomllib.loads(content.decode("utf-8"))
    except RecursionError:
        raise BadInput(path.name, "deeply nested values", "a robot card in TOML") from None
    except ValueError as error:
        raise BadInput(path.name, str(error), "a robot card in TOML") from None
    return parse_card(data, path.name), content


def parse_card(data: dict[str, Any], source: str = CARD_NAME) -> RobotCard:
    """A validated card from plain data as TOML gives it; presets need only say what differs from `default`.

    Args:
        data: tables, lists, strings and numbers. A string is never taken for a number.
        source: file name that errors begin with.

    Raises:
        BadInput: names the entry, as in ``card.toml: legs[0].sole.toe``.
    """
    try:
        text = json.dumps(data | {"presets": _merged(data.get("presets"))}, default=str)
        return RobotCard.model_validate_json(text, strict=True)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False)[0]
        value = None if first["type"] == "missing" else first["input"]
        raise BadInput(f"{source}: {_entry(first['loc'])}", value, _valid(first["type"], first["msg"])) from None
    except BadInput as error:
        raise BadInput(f"{source}: {error.field}", error.value, error.valid, error.remedy) from None
    except (RecursionError, TypeError, ValueError) as error:
        raise BadInput(source, str(error), "a robot card in TOML") from None


def _merged(presets: Any) -> Any:
    """Presets with the default's values where they are silent."""
    if not isinstance(presets, dict):
        return presets
    if "default" not in presets:
        raise BadInput("presets", sorted(presets), "a preset named default")
    return {name: _over(presets["default"], preset) for name, preset in presets.items()}


def _over(base: Any, top: Any) -> Any:
    if not (isinstance(base, dict) and isinstance(top, dict)):
        return top
    return base | {key: _over(base[key], value) if key in base else value for key, value in top.items()}


def _entry(location: tuple[int | str, ...]) -> str:
    """``("legs", 0, "sole")`` as ``legs[0].sole``."""
    entry = ""
    for part in location:
        entry += f"[{part}]" if isinstance(part, int) else f".{part}"
    return entry.lstrip(".") or "card"


def _valid(kind: str, message: str) -> str:
    if kind == "missing":
        return "a value"
    if kind == "extra_forbidden":
        return "no such entry"
    return message.removeprefix("Input should be ").replace("String should", "text that should")
