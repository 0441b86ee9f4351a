"""Gait template and whole-body control for biped robots, in closed loop with physics.

Names load on first use, so that ``import gaitsmith`` costs nothing::

    import gaitsmith

    episode = gaitsmith.run_episode(gaitsmith.Scenario(speed=(0.3, 0.0), duration=10.0))
    print(episode.summary)
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from gaitsmith.lazy import lazily

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

__version__ = "0.3.0.dev0"

__getattr__, __dir__ = lazily(__name__)
