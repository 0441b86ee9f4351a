"""Bisection for the largest impulse that is survived at every phase, direction by direction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from gaitsmith.experiments.episodes import run_all
from gaitsmith.experiments.push_grid import Cell, PushGrid, survived
from gaitsmith.experiments.result import Progress
from gaitsmith.experiments.store import Store
from gaitsmith.robots import Robot

RESOLUTION = 1.0  # N·s
CEILING = 200.0  # N·s; nothing larger is tried
_GROWTH = 1.5  # from one survived impulse to the next that is tried


@dataclass
class Search:
    """Bracket of one gait's largest impulse for every direction.

    Attributes:
        grid: the gait, directions and phases; its impulse is tried first.
        low: largest impulse survived at all phases, N·s; 0 if none was.
        high: smallest impulse that was not, N·s; None while none has failed.
    """

    grid: PushGrid
    low: list[float] = field(default_factory=list)
    high: list[float | None] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.low = [0.0] * self.grid.directions
        self.high = [None] * self.grid.directions

    @property
    def everywhere(self) -> float:
        """Largest impulse survived in every direction, N·s."""
        return min(self.low)

    def next_impulse(self, direction: int) -> float | None:
        """What to try next, whole N·s; None once the bracket is as narrow as the resolution."""
        low, high = self.low[direction], self.high[direction]
        if high is None:
            if low >= CEILING:
                return None
            grown = round(_GROWTH * low / RESOLUTION) * RESOLUTION
            return self.grid.impulse if low == 0.0 else min(max(grown, low + RESOLUTION), CEILING)
        if high - low <= RESOLUTION:
            return None
        middle = round((low + high) / 2.0 / RESOLUTION) * RESOLUTION
        return middle if low < middle < high else (low + high) / 2.0

    def learn(self, direction: int, impulse: float, stood: bool) -> None:
        """Narrow a bracket."""
        if stood:
            self.low[direction] = impulse
        else:
            self.high[direction] = impulse

    def document(self) -> dict[str, Any]:
        """As plain data."""
        grid = self.grid
        return {
            "name": grid.gait_name,
            "speed": grid.speed,
            "height": grid.height,
            "period": grid.period,
            "directions_deg": [grid.degrees(i) for i in range(grid.directions)],
            "phases": grid.phases,
            "survived": list(self.low),
            "failed": list(self.high),
            "everywhere": self.everywhere,
            "resolution": RESOLUTION,
        }


def search_largest(
    grids: Sequence[PushGrid], robot: str, preset: str, loaded: Robot, store: Store, jobs: int, progress: Progress
) -> tuple[list[Search], bool]:
    """Search all gaits at the same time, one round of impulses after the other.

    Survival need not fall steadily with the impulse: the result is an impulse survived below one that was not.

    Returns:
        The searches, and whether Ctrl-C left them unfinished.

    Raises:
        BadInput: an impulse or gait that the robot's card does not allow.
    """
    searches = [Search(grid) for grid in grids]
    number = 0
    while True:
        tried = {
            (k, i): impulse
            for k, search in enumerate(searches)
            for i in range(search.grid.directions)
            if (impulse := search.next_impulse(i)) is not None
        }
        if not tried:
            return searches, False
        number += 1
        scenarios = {
            (k, i): [
                searches[k].grid.scenario(Cell(i, phase), robot, preset, impulse)
                for phase in range(searches[k].grid.phases)
            ]
            for (k, i), impulse in tried.items()
        }
        wanted = [scenario for group in scenarios.values() for scenario in group]
        episodes = run_all(wanted, loaded, store, jobs=jobs, progress=progress, what=f"bisecting, round {number}")
        if episodes.interrupted:
            return searches, True
        for (k, i), impulse in tried.items():
            searches[k].learn(i, impulse, all(survived(episodes.found[s]) for s in scenarios[k, i]))
