"""Bisection for the largest impulse that is survived at every phase, direction by direction."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from gaitsmith.experiments.episodes import run_all
from gaitsmith.experiments.push_grid import Cell, PushGrid, momentum_unit, survived
from gaitsmith.experiments.result import Progress
from gaitsmith.experiments.store import Store
from gaitsmith.robots import Robot
from gaitsmith.simulation import Scenario, Summary

_RESOLUTION = 0.01  # of mass times √(gH), before it is rounded down to 1, 2 or 5 times a power of ten
_CEILING = 200.0  # resolutions; nothing larger is tried
_Found = Mapping[Scenario, Summary]
_GROWTH = 1.5  # from one survived impulse to the next that is tried


def resolution_for(robot: Robot) -> float:
    """How closely a robot's largest impulse is searched, N·s."""
    exact = _RESOLUTION * momentum_unit(robot, robot.card.gait.height)
    decade: float = 10.0 ** math.floor(math.log10(exact))
    return max(step * decade for step in (1.0, 2.0, 5.0) if step * decade <= exact)


@dataclass
class Search:
    """Bracket of one gait's largest impulse for every direction.

    Attributes:
        grid: the gait, directions and phases; its impulse is tried first.
        resolution: width of a bracket that is narrow enough, N·s.
        low: largest impulse survived at all phases, N·s; 0 if none was, None while none has been tried to the end.
        high: smallest impulse that was not, N·s; None while none has failed.
    """

    grid: PushGrid
    resolution: float = 1.0
    low: list[float | None] = field(init=False)
    high: list[float | None] = field(init=False)

    def __post_init__(self) -> None:
        self.low = [None] * self.grid.directions
        self.high = [None] * self.grid.directions

    @property
    def ceiling(self) -> float:
        """Nothing larger is tried, N·s."""
        return _CEILING * self.resolution

    @property
    def everywhere(self) -> float | None:
        """Largest impulse survived in every direction, N·s; None while one is unknown."""
        known = [low for low in self.low if low is not None]
        return min(known) if len(known) == len(self.low) else None

    def next_impulse(self, direction: int) -> float | None:
        """What to try next, in whole resolutions; None once the bracket is as narrow as one of them."""
        low, high, step = self.low[direction], self.high[direction], self.resolution
        if low is None:
            return self.grid.impulse
        if high is None:
            if low >= self.ceiling:
                return None
            grown = round(round(_GROWTH * low / step) * step, 9)
            return min(max(grown, low + step), self.ceiling)
        if high - low <= 1.000001 * step:
            return None
        middle = round(round((low + high) / 2.0 / step) * step, 9)
        return middle if low < middle < high else (low + high) / 2.0

    def learn(self, direction: int, impulse: float, stood: bool) -> None:
        """Narrow a bracket; without an impulse the robot stands."""
        if stood:
            self.low[direction] = impulse
        else:
            self.low[direction], self.high[direction] = self.low[direction] or 0.0, impulse

    def document(self) -> dict[str, Any]:
        """As plain data."""
        grid = self.grid
        return {
            "name": grid.gait_name,
            "scenario": grid.base.model_dump(mode="json", exclude_none=True),
            "directions_deg": [grid.degrees(i) for i in range(grid.directions)],
            "phases": grid.phases,
            "survived": list(self.low),
            "failed": list(self.high),
            "everywhere": self.everywhere,
            "resolution": self.resolution,
        }


def _in_turn(groups: Iterable[Sequence[Scenario]]) -> tuple[list[Scenario], Callable[[Scenario, _Found], bool]]:
    """First those that each group begins with, and so on; after a fall the rest of its group is not needed."""
    alike = {scenario: group for group in groups for scenario in group}

    def needless(scenario: Scenario, found: _Found) -> bool:
        return any(not survived(found[other]) for other in alike[scenario] if other in found)

    return sorted(alike, key=lambda scenario: alike[scenario].index(scenario)), needless


def search_largest(
    grids: Sequence[PushGrid],
    robot: Robot,
    store: Store,
    jobs: int,
    progress: Progress,
    resolution: float | None = None,
    address: str = "",
) -> tuple[list[Search], bool]:
    """Search all gaits at the same time, one round of impulses after the other.

    Survival need not fall steadily with the impulse: the result is an impulse survived below one that was not.

    Returns:
        The searches, and whether Ctrl-C left them unfinished.

    Raises:
        BadInput: an impulse or gait that the robot's card does not allow.
    """
    resolution = resolution or resolution_for(robot)
    searches = [Search(grid, resolution) for grid in grids]
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
            (k, i): [searches[k].grid.scenario(Cell(i, phase), impulse) for phase in range(searches[k].grid.phases)]
            for (k, i), impulse in tried.items()
        }
        wanted, needless = _in_turn(scenarios.values())
        episodes = run_all(
            wanted,
            robot,
            store,
            jobs=jobs,
            address=address,
            progress=progress,
            what=f"bisecting, round {number}",
            needless=needless,
        )
        for (k, i), impulse in tried.items():
            stood = [survived(episodes.found[scenario]) for scenario in scenarios[k, i] if scenario in episodes.found]
            if len(stood) == len(scenarios[k, i]) or not all(stood):  # else it is unknown
                searches[k].learn(i, impulse, all(stood))
        if episodes.interrupted:
            return searches, True
