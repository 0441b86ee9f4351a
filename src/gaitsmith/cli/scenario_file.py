"""A scenario as a TOML file that runs again: what was left out is left out, numbers keep every digit."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from gaitsmith.simulation import Scenario


def scenario_toml(scenario: Scenario) -> str:
    """TOML text that :func:`gaitsmith.simulation.load_scenario` turns into the same scenario."""
    fields = scenario.model_dump(mode="json", exclude_none=True)
    tables = {name: value for name, value in fields.items() if isinstance(value, dict)}
    lists = {name: value for name, value in fields.items() if name in ("changes", "pushes")}
    parts = [_table({name: value for name, value in fields.items() if name not in tables and name not in lists})]
    parts += [f"[{name}]\n{_table(value)}" for name, value in tables.items()]
    parts += [f"[[{name}]]\n{_table(entry)}" for name, value in lists.items() for entry in value]
    return "\n".join(parts)


def _table(fields: Mapping[str, Any]) -> str:
    return "".join(f"{name} = {_value(value)}\n" for name, value in fields.items())


def _value(value: Any) -> str:
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    text = json.dumps(value, ensure_ascii=False)
    return text.replace("\x7f", "\\u007f") if isinstance(value, str) else text
