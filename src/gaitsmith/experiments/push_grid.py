"""A grid of pushes: every direction at every phase of the stride, as scenarios, and what became of them."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from gaitsmith.experiments.limits import Limit, Verdict
from gaitsmith.simulation import Scenario, Summary
from gaitsmith.simulation.scenario import make_scenario

SURVIVAL = 10.0  # s from the beginning of the push
_STANDING, _SETTLING = 1.0, 3.0  # s before the walk, and of the walk before the push
_LONGEST_STEP = 1.6  # periods; a stride that late still leaves the whole survival time


class Cell(NamedTuple):
    """One push of a grid: indices of direction and phase."""

    direction: int
    phase: int


@dataclass(frozen=True)
class PushGrid:
    """Pushes of one impulse in all directions at all phases, in one gait.

    Attributes:
        impulse: N·s, horizontal, at the torso's CoM, lasting 0.1 s.
        speed: forward, m/s.
        height: hip midpoint above the stance sole, m.
        period: of one step, s.
        least: share of the cells that have to be survived; None to report only.
        goal: share that is aimed at.
        separation: limit on the smallest foot separation over the survived cells; None to report only.
        directions: evenly around the robot, the first one forward, then to the left.
        phases: evenly over a stride, the first one at the beginning of a left stance.
    """

    impulse: float
    speed: float
    height: float
    period: float
    least: float | None = None
    goal: float | None = None
    separation: Limit | None = None
    directions: int = 8
    phases: int = 12

    @property
    def name(self) -> str:
        """The grid in words."""
        return f"{self.impulse:g} N·s, {self.gait_name}"

    @property
    def gait_name(self) -> str:
        """The gait in words."""
        return f"T {self.period:g} s, H {self.height:g} m, " + (f"{self.speed:g} m/s" if self.speed else "in place")

    @property
    def slug(self) -> str:
        """The grid as part of a file's name."""
        return f"push_J{self.impulse:g}_T{self.period:g}_H{self.height:g}_V{self.speed:g}"

    @property
    def cells(self) -> tuple[Cell, ...]:
        """All pushes, phase by phase within a direction."""
        return tuple(Cell(i, k) for i in range(self.directions) for k in range(self.phases))

    def degrees(self, direction: int) -> float:
        """Direction of a push: 0 forward, 90 to the left."""
        return 360.0 * direction / self.directions

    def scenario(self, cell: Cell, robot: str, preset: str, impulse: float | None = None) -> Scenario:
        """The episode of one cell: stand, walk, settle, be pushed, survive.

        Args:
            cell: direction and phase.
            robot: name or path.
            preset: control parameters.
            impulse: instead of the grid's, N·s.

        Raises:
            BadInput: a number of the grid is out of any range.
        """
        size = self.impulse if impulse is None else impulse
        angle = 2.0 * math.pi * cell.direction / self.directions
        pushed_at = _STANDING + _SETTLING
        push = {
            "time": pushed_at,
            "phase": cell.phase / self.phases,
            "impulse": [round(size * math.cos(angle), 9), round(size * math.sin(angle), 9), 0.0],
        }
        return make_scenario(
            {
                "robot": robot,
                "preset": preset,
                "duration": round(pushed_at + 2.0 * _LONGEST_STEP * self.period + SURVIVAL, 3),
                "rest_before": _STANDING,
                "speed": [self.speed, 0.0],
                "height": self.height,
                "period": self.period,
                "pushes": [push],
            }
        )


_APART = Limit("separation", 0.04, least=True)
STANDARD_GRIDS = (
    *(
        PushGrid(15.0, speed, height, 0.4, least=1.0, goal=1.0, separation=_APART)
        for height in (0.66, 0.70)
        for speed in (0.0, 0.4)
    ),
    PushGrid(40.0, 0.0, 0.66, 0.25, least=86 / 96, goal=1.0),
)
"""The grids that the default preset is judged by."""


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


@dataclass(frozen=True)
class GridOutcome:
    """What became of a grid; cells that were not run are absent.

    Attributes:
        grid: the grid.
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
        if total - fell < grid.least * total - 1e-9:
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
            "speed": grid.speed,
            "height": grid.height,
            "period": grid.period,
            "directions_deg": [grid.degrees(i) for i in range(grid.directions)],
            "phases": [k / grid.phases for k in range(grid.phases)],
            "total": len(grid.cells),
            "run": len(self.found),
            "survived": len(self.survivors),
            "least": None if grid.least is None else math.ceil(grid.least * len(grid.cells) - 1e-9),
            "goal": None if grid.goal is None else math.ceil(grid.goal * len(grid.cells) - 1e-9),
            "verdict": self.verdict(),
            "min_separation": closest[0] if closest else None,
            "min_separation_at": [grid.degrees(closest[1].direction), closest[1].phase / grid.phases]
            if closest
            else None,
            "survival_limit": SURVIVAL,
            "survival_time": [[None if s is None else survival_time(s) for s in row] for row in rows],
            "separation": [[None if s is None else s.min_foot_separation for s in row] for row in rows],
            "first_limits": dict(self.fall_limits().most_common()),
            "falls": falls,
        }


def first_limit(reason: str) -> str:
    """The limit that a fall's reason says was hit first, or how it fell if none was."""
    head, _, tail = reason.partition("; first limit hit: ")
    return tail.split(", at ")[0] if tail else head.split(";")[0]
