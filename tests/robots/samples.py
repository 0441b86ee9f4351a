"""Cards and models that the tests of this folder change and load."""

from __future__ import annotations

import copy
import json
import tomllib
from pathlib import Path
from typing import Any

from gaitsmith.robots.card_file import parse_card
from gaitsmith.robots.loading import SHIPPED, build_robot
from gaitsmith.robots.robot import Robot
from gaitsmith.robots.safety import CardFolder

MODELS = Path(__file__).parents[1] / "models"
BHR = SHIPPED / "bhr_b2"


def card_data(path: Path = BHR / "card.toml") -> dict[str, Any]:
    """A card as plain data."""
    return tomllib.loads(path.read_text())


def changed(data: dict[str, Any], *path: str | int, value: Any) -> dict[str, Any]:
    """A copy in which one entry has another value; `...` removes it."""
    result = copy.deepcopy(data)
    place: Any = result
    for key in path[:-1]:
        place = place[key]
    if value is ...:
        del place[path[-1]]
    else:
        place[path[-1]] = value
    return result


def build(data: dict[str, Any], folder: Path = BHR) -> Robot:
    """The robot of a card given as plain data, its model in a folder."""
    content = json.dumps(data, default=str).encode()
    return build_robot(parse_card(data), content, CardFolder(folder.resolve(), "card.toml"))


def build_model(text: str | bytes, folder: Path, data: dict[str, Any] | None = None) -> Robot:
    """The robot of BHR-B2's card (or another) with another model."""
    name = "model.xml"
    (folder / name).write_bytes(text if isinstance(text, bytes) else text.encode())
    return build((data or card_data()) | {"model": name}, folder)


def bhr_text() -> str:
    """BHR-B2's MJCF."""
    return (BHR / "bhr_b2.xml").read_text()
