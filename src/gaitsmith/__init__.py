"""Gait template and whole-body control for biped robots, in closed loop with physics.

Names load on first use, so that ``import gaitsmith`` costs nothing::

    import gaitsmith

    episode = gaitsmith.run_episode(gaitsmith.Scenario(speed=(0.3, 0.0), duration=10.0))
    print(episode.summary)
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gaitsmith.control import Controller as Controller
    from gaitsmith.log import read_log as read_log
    from gaitsmith.robots import Robot as Robot
    from gaitsmith.robots import load_robot as load_robot
    from gaitsmith.robots import robot_names as robot_names
    from gaitsmith.simulation import Episode as Episode
    from gaitsmith.simulation import Plant as Plant
    from gaitsmith.simulation import Scenario as Scenario
    from gaitsmith.simulation import Simulation as Simulation
    from gaitsmith.simulation import load_scenario as load_scenario
    from gaitsmith.simulation import run_episode as run_episode

__version__ = "0.1.0"

_HOMES = {
    "Controller": "gaitsmith.control",
    "Episode": "gaitsmith.simulation",
    "Plant": "gaitsmith.simulation",
    "Robot": "gaitsmith.robots",
    "Scenario": "gaitsmith.simulation",
    "Simulation": "gaitsmith.simulation",
    "load_robot": "gaitsmith.robots",
    "load_scenario": "gaitsmith.simulation",
    "read_log": "gaitsmith.log",
    "robot_names": "gaitsmith.robots",
    "run_episode": "gaitsmith.simulation",
}


def __getattr__(name: str) -> Any:
    """Import the module that defines a public name when the name is first used."""
    home = _HOMES.get(name)
    if home is None:
        raise AttributeError(f"module 'gaitsmith' has no attribute {name!r}")
    value = getattr(import_module(home), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Public names, loaded or not."""
    return sorted([*_HOMES, "__version__"])
