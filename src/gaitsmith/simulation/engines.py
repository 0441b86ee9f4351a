"""Physics engines by name; one that is an extra is loaded when it is asked for."""

from __future__ import annotations

from gaitsmith.simulation.plant import Plant


def engine_of(name: str) -> type[Plant]:
    """The plant of an engine.

    Raises:
        BadInput: its package is not there.
    """
    if name != "bullet":
        return Plant
    from gaitsmith.simulation.bullet import BulletPlant

    return BulletPlant
