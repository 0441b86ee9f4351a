"""The measurements behind every quoted figure: time of a tick, grids of pushes, and batteries of walks.

Names load on first use: options can be read, or help printed, without starting the physics engine.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from gaitsmith.lazy import lazily

if TYPE_CHECKING:
    from gaitsmith.experiments.battery import run_battery as run_battery
    from gaitsmith.experiments.crash import run_crash as run_crash
    from gaitsmith.experiments.episodes import run_all as run_all
    from gaitsmith.experiments.falls import run_falls as run_falls
    from gaitsmith.experiments.faults import run_faults as run_faults
    from gaitsmith.experiments.options import BatteryOptions as BatteryOptions
    from gaitsmith.experiments.options import CrashOptions as CrashOptions
    from gaitsmith.experiments.options import FallOptions as FallOptions
    from gaitsmith.experiments.options import FaultOptions as FaultOptions
    from gaitsmith.experiments.options import PushOptions as PushOptions
    from gaitsmith.experiments.options import TickOptions as TickOptions
    from gaitsmith.experiments.options import TourOptions as TourOptions
    from gaitsmith.experiments.push_grid import PushGrid as PushGrid
    from gaitsmith.experiments.pushing import push_grids as push_grids
    from gaitsmith.experiments.result import Result as Result
    from gaitsmith.experiments.sets import Trial as Trial
    from gaitsmith.experiments.sets import load_set as load_set
    from gaitsmith.experiments.store import Store as Store
    from gaitsmith.experiments.tick_time import measure_tick as measure_tick
    from gaitsmith.experiments.tour import run_tour as run_tour

__getattr__, __dir__ = lazily(__name__)
