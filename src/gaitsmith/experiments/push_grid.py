"""A grid of pushes: every direction at every phase of the stride, as scenarios, and what became of them."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from gaitsmith.experiments.limits import Limit, Verdict
from gaitsmith.robots import Robot
from gaitsmith.simulation import Scenario, Summary
from gaitsmith.simulation.scenario import make_scenario

SURVIVAL = 10.0  # s from the beginning of the push
_SETTLING = 3.0  # s of the walk before the push
_LONGEST_STEP = 1.6  # periods; a stride that late still leaves the whole survival time
_UNKNOWN_PERIOD = 1.0  # s, of a planned gait


class Cell(NamedTuple):
    """One push of a grid: indices of direction and phase."""

    direction: int
    phase: int


def momentum_unit(robot: Robot, height: float) -> float:
    """Mass times √(gH), N·s: pushes that are the same share of it are alike to robots of any size."""
    return robot.mass * math.sqrt(-robot.model.opt.gravity[2] * height)


@dataclass(frozen=True)
class PushGrid:
    """Pushes of one impulse in all directions at all phases of one walk.

    Attributes:
        impulse: N·s, horizontal, at the torso's CoM, lasting 0.1 s.
        base: the walk that is pushed.
        least: how many cells have to be survived; None to report only.
        goal: how many are aimed at.
        separation: limit on the smallest foot separation over the survived cells; None to report only.
        directions: evenly around the robot, to the left from the first one on.
        phases: evenly over a stride, the first one at the beginning of a left stance.
        offset: of the first direction from forward, degrees.
    """

    impulse: float
    base: Scenario
    least: int | None = None
    goal: int | None = None
    separation: Limit | None = None
    directions: int = 8
    phases: int = 12
    offset: float = 0.0

    @property
    def name(self) -> str:
        """The grid in words."""
        return f"{self.impulse:g} N·s, {self.gait_name}"

    @property
    def gait_name(self) -> str:
        """The walk in words."""
        base, (vx, vy) = self.base, self.base.speed or (0.0, 0.0)
        if base.gait:
            return ", ".join(Path(path).stem for path in base.gait)
        moving = " ".join(f"{speed:g}" for speed in ((vx, vy) if vy else (vx,))) + " m/s"
        return f"T {base.period:g} s, H {base.height:g} m, " + (moving if vx or vy else "in place")

    @property
    def slug(self) -> str:
        """The grid as part of a file's name."""
        return "push_J" + re.sub(r"[^\w.]+", "_", self.name)

    @property
    def cells(self) -> tuple[Cell, ...]:
        """All pushes, phase by phase within a direction."""
        return tuple(Cell(i, k) for i in range(self.directions) for k in range(self.phases))

    def degrees(self, direction: int) -> float:
        """Direction of a push: 0 forward, 90 to the left."""
        return self.offset + 360.0 * direction / self.directions

    def scenario(self, cell: Cell, impulse: float | None = None) -> Scenario:
        """The episode of one cell: stand, walk, settle, be pushed, survive.

        Args:
            impulse: instead of the grid's, N·s.

        Raises:
            BadInput: a number of the grid is out of any range.
        """
        size = self.impulse if impulse is None else impulse
        angle = math.radians(self.degrees(cell.direction))
        pushed_at = self.base.rest_before + _SETTLING
        push = {
            "time": pushed_at,
            "phase": cell.phase / self.phases,
            "impulse": [round(size * math.cos(angle), 9), round(size * math.sin(angle), 9), 0.0],
        }
        stride = 2.0 * _LONGEST_STEP * (self.base.period or _UNKNOWN_PERIOD)
        fields = {"duration": round(pushed_at + stride + SURVIVAL, 3), "rest_after": 0.0, "pushes": [push]}
        return make_scenario({**self.base.model_dump(mode="json", exclude_none=True), **fields})


def survival_time(summary: Summary) -> float:
    """How long the robot stayed upright after the push began, at most :data:`SURVIVAL`; s.

    0 if it fell before, or if the push never began.
    """
    began = summary.pushes[0] if summary.pushes else None
    if began is None:
        return 0.0
    end = summary.fall.time if summary.fall is not None else summary.duration
    return min(max(end - began, 0.0), SURVIVAL)


def survived(summary: Summary) -> bool:
    """Whether the robot was pushed and stayed upright for :data:`SURVIVAL`."""
    return survival_time(summary) >= SURVIVAL - 1e-9


def recovery_time(summary: Summary) -> float | None:
    """How long after its beginning the push was recovered from, s; None if it was not, or if the legs touched."""
    recovered = summary.recovered[0] if survived(summary) and summary.recovered else None
    return None if summary.leg_contacts else recovered


@dataclass(frozen=True)
class GridOutcome:
    """What became of a grid; cells that were not run are absent.

    Attributes:
        found: summaries by cell.
    """

    grid: PushGrid
    found: Mapping[Cell, Summary]

    @property
    def survivors(self) -> list[Cell]:
        """Cells survived."""
        return [cell for cell, summary in self.found.items() if survived(summary)]

    @property
    def closest(self) -> tuple[float, Cell] | None:
        """Smallest foot separation of any survived cell, m, and where; None without survivors."""
        separations = [(self.found[cell].min_foot_separation, cell) for cell in self.survivors]
        return min(separations, default=None)

    def verdict(self) -> Verdict:
        """``not run`` while cells are missing, unless too many fell already."""
        grid, total = self.grid, len(self.grid.cells)
        if grid.least is None:
            return "report"
        fell = len(self.found) - len(self.survivors)
        if total - fell < grid.least:
            return "miss"
        closest = self.closest
        if grid.separation is not None and closest is not None and not grid.separation.met(closest[0]):
            return "miss"
        return "pass" if len(self.found) == total else "not run"

    def fall_limits(self) -> Counter[str]:
        """How often each limit was the first one hit before a fall."""
        reasons = (self.found[cell].fall for cell in self.found if not survived(self.found[cell]))
        return Counter(first_limit(fall.reason) if fall else "the push never began" for fall in reasons)

    def document(self) -> dict[str, Any]:
        """As plain data; matrices have a row per direction and a column per phase, null where not run."""
        grid, closest = self.grid, self.closest
        rows = [[self.found.get(Cell(i, k)) for k in range(grid.phases)] for i in range(grid.directions)]
        falls = [
            {
                "direction_deg": grid.degrees(cell.direction),
                "phase": cell.phase / grid.phases,
                "after_push": survival_time(summary),
                "step_phase": summary.fall.phase,
                "reason": summary.fall.reason,
            }
            for cell, summary in self.found.items()
            if summary.fall is not None
        ]
        return {
            "name": grid.name,
            "slug": grid.slug,
            "impulse": grid.impulse,
            "scenario": grid.base.model_dump(mode="json", exclude_none=True),
            "directions_deg": [grid.degrees(i) for i in range(grid.directions)],
            "phases": [k / grid.phases for k in range(grid.phases)],
            "total": len(grid.cells),
            "run": len(self.found),
            "survived": len(self.survivors),
            "least": grid.least,
            "goal": grid.goal,
            "verdict": self.verdict(),
            "min_separation": closest[0] if closest else None,
            "survival_limit": SURVIVAL,
            "survival_time": [[None if s is None else survival_time(s) for s in row] for row in rows],
            "recovery_time": [[None if s is None else recovery_time(s) for s in row] for row in rows],
            "separation": [[None if s is None else s.min_foot_separation for s in row] for row in rows],
            "first_limits": dict(self.fall_limits().most_common()),
            "falls": falls,
        }


def first_limit(reason: str) -> str:
    """The limit that a fall's reason says was hit first, or how it fell if none was."""
    head, _, tail = reason.partition("; first limit hit: ")
    return tail.split(", at ")[0] if tail else head.split(";")[0]
