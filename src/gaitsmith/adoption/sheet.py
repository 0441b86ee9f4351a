"""What a robot can do, by short simulations: speeds, heights, periods and pushes between walks and falls."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from gaitsmith.adoption.trials import SPEED, errors, in_reach, walk_scenario
from gaitsmith.experiments.episodes import run_all
from gaitsmith.experiments.largest import search_largest
from gaitsmith.experiments.push_grid import PushGrid, momentum_unit
from gaitsmith.experiments.result import Progress
from gaitsmith.experiments.store import Store
from gaitsmith.robots import Robot
from gaitsmith.simulation import Scenario, Summary

_SHORT = 6.0  # s of a walk that is tried
_OFF, _SHARE = 0.02, 0.15  # m/s, or share of the command: error of a mean speed with which it still walks
_TURNING = 0.1  # rad/s of error in the yaw rate
_STRAYING = 0.02  # rad/s of a heading that should stay
_ROUNDS = 2  # of bisection
_PUSH, _FINE = 0.06, 0.02  # first impulse and resolution, of mass times √(gH)
_DIRECTIONS, _PHASES = 4, 2


@dataclass
class Bracket:
    """One end of a range: `inside` walks, `outside` does not, or has not been tried."""

    quantity: str
    end: int
    inside: float
    outside: float
    done: bool = False
    tried: int = 0

    def next(self) -> float | None:
        """What to try: the far end first, then half-way."""
        if self.done or self.tried > _ROUNDS or math.isclose(self.inside, self.outside, abs_tol=1e-4):
            return None
        return self.outside if self.tried == 0 else (self.inside + self.outside) / 2.0

    def learn(self, value: float, walks: bool) -> None:
        """Narrow it."""
        self.done = walks and self.tried == 0
        self.tried += 1
        if walks:
            self.inside = value
        else:
            self.outside = value


def measure(robot: Robot, name: str, store: Store, jobs: int, progress: Progress) -> dict[str, Any]:
    """The sheet: `[low, high]` walked of each quantity within the card's limits, and the largest push by direction.

    Args:
        robot: walks at the test's speed.
        name: under which it is loaded again.

    Raises:
        KeyboardInterrupt: Ctrl-C.
    """
    gait, limits = robot.card.gait, robot.card.gait_limits
    start = {"speed_x": (0.0, min(SPEED, limits.speed_x[1])), "speed_y": (0.0, 0.0), "yaw_rate": (0.0, 0.0)}
    start |= {part: (getattr(gait, part),) * 2 for part in ("height", "period")}
    brackets = [
        Bracket(part, end, inside[end], getattr(limits, part)[end]) for part, inside in start.items() for end in (0, 1)
    ]
    for bracket in brackets:
        if bracket.quantity == "height":
            while not (in_reach(robot, bracket.outside, gait.width) or bracket.next() is None):
                bracket.outside += (bracket.inside - bracket.outside) / 4.0
    while pending := {k: value for k, bracket in enumerate(brackets) if (value := bracket.next()) is not None}:
        scenarios = {k: _scenario(name, brackets[k].quantity, value) for k, value in pending.items()}
        number = max(brackets[k].tried for k in pending) + 1
        what = f"measuring what it walks, round {number}"
        episodes = run_all(list(scenarios.values()), robot, store, jobs=jobs, progress=progress, what=what)
        if episodes.interrupted:
            raise KeyboardInterrupt
        for k, value in pending.items():
            brackets[k].learn(value, walks(episodes.found[scenarios[k]]))
    found: dict[str, Any] = {part: [0.0, 0.0] for part in start}
    for bracket in brackets:
        found[bracket.quantity][bracket.end] = _inward(bracket.inside, bracket.end)
    return found | {"push": _pushes(robot, name, store, jobs, progress)}


def reserves(robot: Robot, summary: Summary) -> dict[str, float]:
    """Share of the legs' torque and velocity limits that a walk leaves unused at its worst moment."""
    found = {}
    for key, peak, limit in (
        ("torque_reserve", summary.torque_peak, robot.torque_limit),
        ("velocity_reserve", summary.velocity_peak, robot.velocity_limit),
    ):
        limits = dict(zip(robot.joint_names, limit.tolist(), strict=True))
        legs = [name for leg in robot.legs for name in leg.joints]
        found[key] = round(1.0 - max(peak[name] / limits[name] for name in legs), 3)
    return found


def walks(summary: Summary) -> bool:
    """Whether a robot stayed up and did what was commanded."""
    if summary.fell:
        return False
    stage = [stage for stage in summary.stages if not stage.rest][-1]
    speed = math.hypot(stage.command.vx, stage.command.vy)
    wanted = abs(stage.command.yaw_rate)
    turning = abs(stage.yaw_rate_error) <= (max(_TURNING, 0.5 * wanted) if wanted else _STRAYING)
    return errors(summary)[0] <= max(_OFF, _SHARE * speed) and turning


def _scenario(name: str, quantity: str, value: float) -> Scenario:
    """A short walk with one quantity at a value."""
    inputs: dict[str, Any] = {"duration": _SHORT}
    if quantity in ("speed_x", "speed_y"):
        inputs["speed"] = (value, 0.0) if quantity == "speed_x" else (0.0, value)
    else:
        inputs[quantity] = value
    return walk_scenario(name, **inputs)


def _pushes(robot: Robot, name: str, store: Store, jobs: int, progress: Progress) -> dict[str, float]:
    """Largest impulse survived at every tried phase while walking in place, N·s, by direction."""
    gait = robot.card.gait
    unit = momentum_unit(robot, gait.height)
    base = walk_scenario(name, speed=(0.0, 0.0), height=gait.height, period=gait.period)
    grid = PushGrid(round(_PUSH * unit, 3), base, directions=_DIRECTIONS, phases=_PHASES)
    searches, interrupted = search_largest([grid], robot, store, jobs, progress, _FINE * unit)
    if interrupted:
        raise KeyboardInterrupt
    return {
        direction: round(low, 2)
        for direction, low in zip(("forward", "left", "back", "right"), searches[0].low, strict=True)
        if low is not None
    }


def _inward(value: float, end: int) -> float:
    """Rounded to what was walked, not beyond."""
    return (math.floor if end else math.ceil)(round(value * 1000.0, 6)) / 1000.0
