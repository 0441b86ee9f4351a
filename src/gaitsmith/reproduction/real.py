"""The real ZMP and centre of mass of a run, seen in the plant while it goes, beside those of its plan."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from gaitsmith.reports.run import Run, make_run
from gaitsmith.reproduction.finding import Tell
from gaitsmith.robots import Robot
from gaitsmith.simulation.episode import Simulation
from gaitsmith.simulation.loop import Observer
from gaitsmith.simulation.planned_run import completed
from gaitsmith.simulation.scenario import make_scenario
from gaitsmith.synthesis.files.gait_file import write_gait
from gaitsmith.synthesis.gaits.gait import Gait
from gaitsmith.synthesis.gaits.support import depths
from gaitsmith.synthesis.gaits.unrolled import Samples, UnrolledGait
from gaitsmith.synthesis.motions.biped import biped_from

Array = npt.NDArray[np.float64]
_EVERY = 5  # ticks


class Real(NamedTuple):
    """A run beside its plan at n instants.

    Attributes:
        time: (n,) s.
        zmp, com: (n, 2) real, world, m; the ZMP is NaN in the air.
        plan: the plan at these instants.
        zmp_inside, com_inside: (n,) how far they are inside the planned support polygon, m.
        ball: (n, 3) of the ball that is kicked, world, m; None without one.
    """

    run: Run
    time: Array
    zmp: Array
    com: Array
    plan: Samples
    zmp_inside: Array
    com_inside: Array
    ball: Array | None = None


class _Seen(Observer):
    """Notes ZMP and centre of mass as the run goes."""

    def __init__(self, simulation: Simulation) -> None:
        self._plant, self.rows = simulation.plant, list[tuple[float, ...]]()

    def observe(self, tick: int) -> bool:
        """Take note of a tick; never ends the run."""
        if tick % _EVERY == 0:
            zmp = self._plant.zmp() or (np.nan, np.nan)
            balls = [float(part) for ball in self._plant.balls for part in ball.position]
            self.rows.append((self._plant.time, *zmp, *self._plant.com[:2].tolist(), *balls))
        return False


def walk_plan(gait: Gait, robot: Robot, name: str, folder: Path, tell: Tell, steps: int = 1) -> Real:
    """Write a gait, walk it in closed loop, and set it beside its plan; ``steps`` of a cyclic one."""
    path = folder / f"{name}.json"
    write_gait(path, gait)
    asked: dict[str, Any] = {"gait": [str(path.resolve())]} | ({"cycles": steps} if gait.motion.cyclic else {})
    scenario, seen = make_scenario(completed(asked)), list[_Seen]()

    def watch(simulation: Simulation) -> _Seen:
        seen.append(_Seen(simulation))
        return seen[0]

    run = make_run(
        scenario, folder / f"{name}-run", lambda time: tell(f"{name}: {time:.0f} of {scenario.duration:.0f} s"), watch
    )
    unrolled = UnrolledGait(gait, robot, steps)
    rows = np.array([row for row in seen[0].rows if row[0] <= unrolled.duration])
    time, zmp, com = rows[:, 0], rows[:, 1:3], rows[:, 3:5]
    plan = unrolled.at(time)
    offset = _moved(plan, gait, time, unrolled)
    zmp_inside, com_inside = (depths(biped_from(robot), plan.phases, points - offset) for points in (zmp, com))
    ball = rows[:, 5:8] if rows.shape[1] > 5 else None
    return Real(run, time, zmp, com, plan, zmp_inside, com_inside, ball)


def _moved(plan: Samples, gait: Gait, time: Array, unrolled: UnrolledGait) -> Array:
    """(n, 2) by how much the plan's phases, written out for two steps, have gone on at each instant, m."""
    if not gait.motion.cyclic or unrolled.steps <= 2:
        return np.zeros((len(time), 2))
    turns = np.clip(np.floor(time / (2.0 * gait.duration)), 0, (unrolled.steps - 1) // 2)
    first = unrolled.at(np.array([0.0, 2.0 * gait.duration]))
    return turns[:, None] * (first.com[1, :2] - first.com[0, :2])
