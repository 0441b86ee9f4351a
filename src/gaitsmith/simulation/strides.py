"""Steps as they were taken: how long each lasted, and when the walk was itself again after a push."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from gaitsmith.simulation.stages import ENTERED
from gaitsmith.simulation.summary import StepTimes

if TYPE_CHECKING:
    from gaitsmith.log.columns import Columns
    from gaitsmith.robots import Robot
    from gaitsmith.simulation.scenario import Scenario

CALM = 0.038
"""A stride is calm if its mean velocity is that close to the commanded one; √(g · commanded height)."""
_READ = ("mode", "step_count", "command.height", "command.speed_x", "command.speed_y")


class Strides:
    """Watches steps in bounded memory.

    A push is recovered from at the end of the first of the strides (two steps each) that are calm from then on until
    the next push, the end, or a plan's leaving its loop: what is in front of and behind a loop has no speed to compare.

    Args:
        columns: telemetry of the controller; what is true, or believed, of the robot.
        prefix: of the columns that tell where the robot is.
        scenario: how many pushes there are; steps of libraries are not watched.
        dt: s from one observation to the next.
        robot: whose world has gravity.
        gait: what is commanded at first, by name; of a plan the speed in its loop.
    """

    def __init__(
        self, columns: Columns, prefix: str, scenario: Scenario, dt: float, robot: Robot, gait: Mapping[str, Any]
    ) -> None:
        self._dt, self._ticks, self._planned = dt, 0, bool(scenario.gait or scenario.library)
        self._watches, self._looped, self._speed = not self._planned, False, tuple(gait.get("speed", (0.0, 0.0)))
        self._gravity = -float(robot.model.opt.gravity[2])
        self._views = [columns.block([name]) for name in _READ]
        self._velocity = columns.block([f"{prefix}com_velocity_{axis}" for axis in "xy"])
        self._count, self._began = -1, 0
        self._sums: list[tuple[float, float, int]] = [(0.0, 0.0, 0), (0.0, 0.0, 0)]  # of the step before, of this one
        self._durations: tuple[int, float, float, float] = (0, 0.0, math.inf, 0.0)  # steps, sum, least, greatest; s
        self._calm_since: float | None = None
        self._pushed: tuple[int, float] | None = None
        self._recovered: list[float | None] = [None] * len(scenario.pushes)

    def observe(self, tick: int) -> bool:
        """Take note of the present tick; never ends the run."""
        if not self._watches:
            self._ticks += 1
            return False
        mode, count, height, speed_x, speed_y = (float(view[0]) for view in self._views)
        vx, vy = self._velocity.tolist()
        if self._planned:
            speed_x, speed_y = self._speed
        if mode == 1.0:
            if int(count) != self._count:
                self._step(int(count), height, speed_x, speed_y)
            x, y, n = self._sums[1]
            self._sums[1] = (x + vx, y + vy, n + 1)
        else:  # at rest there are no strides
            self._count = -1
            self._settle(vx, vy, height)
        self._ticks += 1
        return False

    def hear(self, event: Mapping[str, Any]) -> None:
        """A push begins, or a plan enters or leaves its loop."""
        if "plan" in event:
            self._watches = event["plan"] == ENTERED
            self._looped = self._looped or self._watches
        if "push" in event and not event.get("over"):
            self._close(self._recovered, self._since_push())
            self._pushed, self._calm_since = (int(event["push"]), self._now), None

    def report(self, fell: bool) -> dict[str, Any]:
        """``recovered`` and ``step_time``, as :class:`gaitsmith.simulation.summary.Summary` has them."""
        steps, total, least, greatest = self._durations
        times = StepTimes(mean=total / steps, min=least, max=greatest) if steps else None
        found = list(self._recovered)
        self._close(found, None if fell else self._since_push())
        return {"recovered": () if self._planned and not self._looped else tuple(found), "step_time": times}

    @property
    def _now(self) -> float:
        return self._ticks * self._dt

    def _step(self, count: int, height: float, speed_x: float, speed_y: float) -> None:
        """A step begins; the one before may have been whole, and so may the stride."""
        if count == self._count + 1 and self._count >= 0:
            lasted = (self._ticks - self._began) * self._dt
            steps, total, least, greatest = self._durations
            self._durations = (steps + 1, total + lasted, min(least, lasted), max(greatest, lasted))
            (x, y, n), (x_now, y_now, n_now) = self._sums
            if n:
                ticks = n + n_now
                self._settle((x + x_now) / ticks - speed_x, (y + y_now) / ticks - speed_y, height)
            self._sums = [self._sums[1], (0.0, 0.0, 0)]
        else:
            self._sums = [(0.0, 0.0, 0), (0.0, 0.0, 0)]
        self._count, self._began = count, self._ticks

    def _settle(self, vx: float, vy: float, height: float) -> None:
        """Whether a velocity beside the commanded one, m/s, is calm."""
        calm = math.hypot(vx, vy) < CALM * math.sqrt(self._gravity * max(height, 0.0))
        if not calm:
            self._calm_since = None
        elif self._calm_since is None:
            self._calm_since = self._now

    def _since_push(self) -> float | None:
        if self._pushed is None or self._calm_since is None:
            return None
        return round(self._calm_since - self._pushed[1], 6)

    def _close(self, found: list[float | None], recovered: float | None) -> None:
        """What became of the latest push is known; a page's pushes stand in no scenario."""
        if self._pushed is not None:
            number = self._pushed[0]
            found.extend([None] * (number + 1 - len(found)))
            found[number] = recovered
