"""The measurements behind every quoted figure: time of a tick, grids of pushes, and batteries of walks."""

from gaitsmith.experiments.battery import run_battery as run_battery
from gaitsmith.experiments.episodes import run_all as run_all
from gaitsmith.experiments.push_grid import PushGrid as PushGrid
from gaitsmith.experiments.pushing import push_grids as push_grids
from gaitsmith.experiments.result import Result as Result
from gaitsmith.experiments.sets import Trial as Trial
from gaitsmith.experiments.sets import load_set as load_set
from gaitsmith.experiments.store import Store as Store
from gaitsmith.experiments.tick_time import measure_tick as measure_tick
from gaitsmith.experiments.tour import run_tour as run_tour
