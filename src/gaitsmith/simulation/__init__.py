"""The closed loop: a plant with sensors, terrain and pushes, scenarios, falls explained, logs and summaries.

Names load on first use: a scenario can be built, or help printed, without starting the physics engine.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gaitsmith.simulation.disturbances import Push as Push
    from gaitsmith.simulation.episode import Episode as Episode
    from gaitsmith.simulation.episode import Simulation as Simulation
    from gaitsmith.simulation.episode import run_episode as run_episode
    from gaitsmith.simulation.fall import Fall as Fall
    from gaitsmith.simulation.plant import Plant as Plant
    from gaitsmith.simulation.scenario import Scenario as Scenario
    from gaitsmith.simulation.scenario import load_scenario as load_scenario
    from gaitsmith.simulation.sensors import SensorNoise as SensorNoise
    from gaitsmith.simulation.summary import Summary as Summary
    from gaitsmith.simulation.terrain import Terrain as Terrain
    from gaitsmith.simulation.terrain import parse_terrain as parse_terrain

_HOMES = {
    "Episode": "episode",
    "Fall": "fall",
    "Plant": "plant",
    "Push": "disturbances",
    "Scenario": "scenario",
    "SensorNoise": "sensors",
    "Simulation": "episode",
    "Summary": "summary",
    "Terrain": "terrain",
    "load_scenario": "scenario",
    "parse_terrain": "terrain",
    "run_episode": "episode",
}


def __getattr__(name: str) -> Any:
    """Import the module that defines a public name when the name is first used."""
    home = _HOMES.get(name)
    if home is None:
        raise AttributeError(f"module 'gaitsmith.simulation' has no attribute {name!r}")
    value = getattr(import_module(f"gaitsmith.simulation.{home}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Public names, loaded or not."""
    return sorted(_HOMES)
