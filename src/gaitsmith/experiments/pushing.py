"""``gaitsmith bench push``: the standard grids of pushes, one grid of one's own, or the largest impulse survived."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from gaitsmith.errors import BadInput
from gaitsmith.experiments.episodes import run_all
from gaitsmith.experiments.identity import loop_identity
from gaitsmith.experiments.largest import Search, search_largest
from gaitsmith.experiments.limits import shown
from gaitsmith.experiments.push_grid import STANDARD_GRIDS, Cell, GridOutcome, PushGrid
from gaitsmith.experiments.result import Progress, Result, silent
from gaitsmith.experiments.store import Store
from gaitsmith.robots import Robot, load_robot
from gaitsmith.simulation.scenario import check_scenario

_DEFAULT_IMPULSE = 15.0  # N·s


def push_grids(
    robot: str = "bhr_b2",
    preset: str = "default",
    impulse: float | None = None,
    speed: float | None = None,
    height: float | None = None,
    period: float | None = None,
    directions: int = 8,
    phases: int = 12,
    largest: bool = False,
    jobs: int = 1,
    out: str | Path = "runs/bench",
    progress: Progress = silent,
) -> Result:
    """Push the walking robot; see :class:`gaitsmith.experiments.PushGrid`.

    Without ``impulse``, ``speed``, ``height`` and ``period`` all standard grids are run; those whose gait the robot's
    card does not allow are skipped. With one of them a single grid is run, of 15 N·s, in place, at the card's height
    and period where not given.

    Args:
        robot: name or path.
        preset: control parameters of the card.
        impulse: N·s.
        speed: forward, m/s.
        height: hip midpoint above the stance sole, m.
        period: of one step, s.
        directions: number of directions.
        phases: number of phases.
        largest: search, for each gait, the largest impulse that is survived at all phases, direction by direction.
        jobs: processes.
        out: folder of the finished episodes; ``push.json`` or ``push_largest.json`` is written there too.
        progress: told of the episodes done.

    Raises:
        BadInput: an option, the robot, or the folder cannot be used.
    """
    loaded = load_robot(robot)
    _check(loaded, preset, directions, phases, impulse)
    single = any(value is not None for value in (impulse, speed, height, period))
    grids: Sequence[PushGrid] = STANDARD_GRIDS
    if single:
        gait = loaded.card.gait
        grids = (
            PushGrid(
                impulse=_DEFAULT_IMPULSE if impulse is None else impulse,
                speed=0.0 if speed is None else speed,
                height=gait.height if height is None else height,
                period=gait.period if period is None else period,
            ),
        )
    grids = [replace(grid, directions=directions, phases=phases) for grid in grids]
    skipped: dict[PushGrid, str] = {}
    for grid in grids:
        try:
            check_scenario(grid.scenario(Cell(0, 0), robot, preset), loaded)
        except BadInput as error:
            if single:
                raise BadInput(f"--{error.field.split('[')[0]}", error.value, error.valid, error.remedy) from None
            skipped[grid] = f"{error.field} {error.value} is not {error.valid}"
    store = Store(out)
    head = {"robot": loaded.card.name, "preset": preset, "identity": loop_identity(loaded)}
    grids = [grid for grid in grids if grid not in skipped]
    if largest:
        searches, interrupted = search_largest(grids, robot, preset, loaded, store, jobs, progress)
        result = _largest_result(head, searches, skipped, interrupted)
    else:
        result = _run_grids(head, grids, skipped, robot, preset, loaded, store, jobs, progress)
    result.write(store.path.with_name("push_largest.json" if largest else "push.json"))
    return result


def _check(robot: Robot, preset: str, directions: int, phases: int, impulse: float | None) -> None:
    """Refuse what no scenario check would name by its option."""
    if preset not in robot.card.presets:
        raise BadInput("--preset", preset, "one of " + ", ".join(sorted(robot.card.presets)))
    for name, value in (("--directions", directions), ("--phases", phases)):
        if not 1 <= value <= 360:
            raise BadInput(name, value, "1 to 360")
    if impulse is not None and not 0.0 < impulse <= 1000.0:
        raise BadInput("--impulse", impulse, "more than 0 to 1000 N·s")


def _run_grids(
    head: dict[str, Any],
    grids: Sequence[PushGrid],
    skipped: dict[PushGrid, str],
    robot: str,
    preset: str,
    loaded: Robot,
    store: Store,
    jobs: int,
    progress: Progress,
) -> Result:
    """Run every cell of every grid, and tabulate."""
    scenarios = {(grid, cell): grid.scenario(cell, robot, preset) for grid in grids for cell in grid.cells}
    episodes = run_all(scenarios.values(), loaded, store, jobs=jobs, progress=progress, what="pushing")
    outcomes = [
        GridOutcome(
            grid,
            {
                cell: episodes.found[scenarios[grid, cell]]
                for cell in grid.cells
                if scenarios[grid, cell] in episodes.found
            },
        )
        for grid in grids
    ]
    notes = episodes.notes(len(scenarios), store)
    for outcome in outcomes:
        limits = ", ".join(f"{name} ({count})" for name, count in outcome.fall_limits().most_common(4))
        if limits:
            notes.append(f"{outcome.grid.name}: falls began with {limits}")
    notes += _skip_notes(skipped)
    rows = [_row(outcome) for outcome in outcomes]
    rows += [(grid.name, "", "", "", "skipped") for grid in skipped]
    return Result(
        {
            **head,
            "grids": [outcome.document() for outcome in outcomes],
            "skipped": {grid.name: reason for grid, reason in skipped.items()},
            "interrupted": episodes.interrupted,
        },
        ("pushes", "target", "survived", "separation", "verdict"),
        tuple(rows),
        tuple(notes),
        episodes.interrupted,
    )


def _row(outcome: GridOutcome) -> tuple[str, ...]:
    """One grid in words."""
    document, closest, grid = outcome.document(), outcome.closest, outcome.grid
    target = "report" if document["least"] is None else f"≥ {document['least']} of {document['total']}"
    if document["goal"] is not None and document["goal"] > document["least"]:
        target += f", goal {document['goal']}"
    if grid.separation is not None:
        target += f"; {grid.separation.target()}"
    return (
        grid.name,
        target,
        f"{document['survived']} of {document['run']}",
        shown("separation", closest[0] if closest else None),
        outcome.verdict(),
    )


def _largest_result(
    head: dict[str, Any], searches: Sequence[Search], skipped: dict[PushGrid, str], interrupted: bool
) -> Result:
    """Table of the largest impulse survived, by direction and over all."""
    rows = []
    for search in searches:
        each = ", ".join(
            f"{search.grid.degrees(i):g}°: {_bracket(low, search.high[i])}" for i, low in enumerate(search.low)
        )
        rows.append((search.grid.gait_name, f"{search.everywhere:g} N·s", each))
    rows += [(grid.gait_name, "skipped", "") for grid in skipped]
    return Result(
        {
            **head,
            "largest": [search.document() for search in searches],
            "skipped": {grid.gait_name: reason for grid, reason in skipped.items()},
            "interrupted": interrupted,
        },
        ("gait", "in every direction", "by direction, N·s (0° forward, 90° to the left)"),
        tuple(rows),
        (
            "survived at all phases; bisection to 1 N·s, so one impulse above has been seen to fail",
            *_skip_notes(skipped),
        ),
        interrupted,
    )


def _bracket(low: float, high: float | None) -> str:
    """An impulse survived, marked if no larger one has failed yet."""
    return f"{low:g}" if high is not None else f"≥ {low:g}"


def _skip_notes(skipped: dict[PushGrid, str]) -> list[str]:
    return [f"{grid.name}: skipped, {reason}" for grid, reason in skipped.items()]
