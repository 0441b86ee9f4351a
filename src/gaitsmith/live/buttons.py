"""A row of buttons on the page, each with what it does."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any


def button_row(server: Any, label: str, actions: Mapping[str, Callable[[], None]]) -> None:
    """Add buttons named as the keys; what a browser sends that is no key does nothing."""
    group = server.gui.add_button_group(label, tuple(actions))

    async def clicked(_: Any) -> None:
        act = actions.get(str(group.value))
        if act is not None:
            act()

    group.on_click(clicked)
