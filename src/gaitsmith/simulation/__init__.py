"""The closed loop: a plant with sensors, terrain and pushes, scenarios, falls explained, logs and summaries.

Names load on first use: a scenario can be built, or help printed, without starting the physics engine.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from gaitsmith.lazy import lazily

if TYPE_CHECKING:
    from gaitsmith.simulation.disturbances import Push as Push
    from gaitsmith.simulation.episode import Episode as Episode
    from gaitsmith.simulation.episode import Simulation as Simulation
    from gaitsmith.simulation.episode import run_episode as run_episode
    from gaitsmith.simulation.fall import Fall as Fall
    from gaitsmith.simulation.loop import Backend as Backend
    from gaitsmith.simulation.loop import Loop as Loop
    from gaitsmith.simulation.loop import Order as Order
    from gaitsmith.simulation.loop import Script as Script
    from gaitsmith.simulation.loop import replayed as replayed
    from gaitsmith.simulation.plant import Plant as Plant
    from gaitsmith.simulation.props import Ball as Ball
    from gaitsmith.simulation.scenario import Scenario as Scenario
    from gaitsmith.simulation.scenario import load_scenario as load_scenario
    from gaitsmith.simulation.sensors import SensorNoise as SensorNoise
    from gaitsmith.simulation.summary import Summary as Summary
    from gaitsmith.simulation.terrain import Terrain as Terrain
    from gaitsmith.simulation.terrain import parse_terrain as parse_terrain

__getattr__, __dir__ = lazily(__name__)
