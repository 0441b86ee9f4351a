"""From a card's text to a validated card: presets merged over the default."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from gaitsmith.documents import checked, read_toml
from gaitsmith.robots.card import CardText

CARD_NAME = "card.toml"
OLD_VERSION = 1
OLD_NOTE = "a card of schema_version 1: its presets are gains of earlier control laws, the defaults are used instead"


def read_card(path: Path) -> tuple[CardText, bytes]:
    """The card in a TOML file, and the file's bytes.

    Raises:
        BadInput: the file cannot be read, is not TOML, or is not a valid card.
    """
    data, content = read_toml(path, "a robot card")
    return parse_card(data, path.name), content


def parse_card(data: dict[str, Any], source: str = CARD_NAME) -> CardText:
    """A validated card from plain data as TOML gives it; presets need only say what differs from `default`.

    Args:
        data: tables, lists, texts and numbers.
        source: file name that errors begin with.

    Raises:
        BadInput: names the entry, as in ``card.toml: legs[0].sole.toe``.
    """
    if data.get("schema_version") == OLD_VERSION:
        data = {name: value for name, value in data.items() if name != "presets"}
    presets = data.get("presets", {})
    if isinstance(presets, dict):
        default = presets.get("default", {})
        merged = {name: _over(default, preset) for name, preset in {"default": default, **presets}.items()}
        data = data | {"presets": merged}
    return checked(CardText, data, source)


def _over(base: Any, top: Any) -> Any:
    """Tables with the base's values where they are silent."""
    if not (isinstance(base, dict) and isinstance(top, dict)):
        return top
    return base | {key: _over(base[key], value) if key in base else value for key, value in top.items()}
