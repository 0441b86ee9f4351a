"""``gaitsmith bench push``: a set's grids of pushes, one grid of one's own, or the largest impulse survived."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from gaitsmith.errors import BadInput
from gaitsmith.experiments.episodes import loop_identity, run_all, why_unfit
from gaitsmith.experiments.largest import Search, search_largest
from gaitsmith.experiments.limits import shown
from gaitsmith.experiments.options import PushOptions
from gaitsmith.experiments.push_grid import Cell, GridOutcome, PushGrid, momentum_unit
from gaitsmith.experiments.result import Progress, Result, silent
from gaitsmith.experiments.sets import load_set, walking
from gaitsmith.experiments.store import Store
from gaitsmith.robots import Robot
from gaitsmith.simulation.scenario import check_scenario

_GRIDS: tuple[str, ...] = ("pushes", "target", "survived", "separation", "verdict")
_LARGEST: tuple[str, ...] = ("gait", "in every direction", "by direction, N·s (0° forward, 90° to the left)")
_STRENGTH = 0.15  # of mass times √(gH), without an impulse


def push_grids(options: PushOptions, progress: Progress = silent) -> Result:
    """Push the walking robot; see :class:`gaitsmith.experiments.PushGrid`.

    Without ``impulse``, ``strength``, ``speed``, ``height`` and ``period`` all grids of the set are run; those whose
    walk the robot's card does not allow are skipped. With one of them a single grid is run, of a strength of 0.15, of
    the gait file, or else in place, at the card's height and period where not given. ``push.json`` or
    ``push_largest.json`` is written to the folder of results too.

    Raises:
        BadInput: an option, the robot, or the folder cannot be used.
    """
    chosen = load_set(options.set, options.robot, options.preset, options.gait, options.engine)
    loaded, grids, impulse, strength = chosen.robot, chosen.grids, options.impulse, options.strength
    walk = {name: getattr(options, name) for name in ("speed", "height", "period")}
    single = impulse is not None or strength is not None or any(value is not None for value in walk.values())
    if single:
        try:
            base = walking(chosen.base | {name: value for name, value in walk.items() if value is not None}, loaded)
            check_scenario(base, loaded)
        except BadInput as error:
            raise BadInput(f"--{error.field.split('[')[0]}", error.value, error.valid, error.remedy) from None
        unit = momentum_unit(loaded, base.height or loaded.card.gait.height)
        size = (_STRENGTH if strength is None else strength) * unit if impulse is None else impulse
        if not 0.0 < size <= 1000.0:
            raise BadInput("--impulse" if strength is None else "--strength", size, "more than 0 to 1000 N·s")
        grids = (PushGrid(round(size, 3), base),)
    counts = {"directions": options.directions, "phases": options.phases}
    changed: dict[str, Any] = {name: value for name, value in counts.items() if value is not None}
    if changed:
        grids = tuple(replace(grid, least=None, goal=None, **changed) for grid in grids)
    if options.largest:  # the gaits of the set, each once, beginning with its largest impulse
        grids = tuple({grid.base: grid for grid in sorted(grids, key=lambda grid: grid.impulse)}.values())
    skipped = {grid: reason for grid in grids if (reason := why_unfit([grid.scenario(Cell(0, 0))], loaded))}
    store = Store(options.out)
    fit = [grid for grid in grids if grid not in skipped]
    if options.largest:
        searches, interrupted = search_largest(fit, loaded, store, options.jobs, progress)
        found = {"largest": [search.document() for search in searches]}
        columns = _LARGEST
        rows = [_largest_row(search) for search in searches]
        notes = ["survived at all phases; an impulse above by the width of the bracket has been seen to fail"]
        if interrupted:
            notes.append("interrupted: what was survived so far (≥); run again, finished runs are kept")
    else:
        outcomes, notes, interrupted = _run_grids(fit, loaded, store, options.jobs, progress)
        found = {"grids": [outcome.document() for outcome in outcomes]}
        columns, rows = _GRIDS, [_row(outcome) for outcome in outcomes]
    names = {grid: grid.gait_name if options.largest else grid.name for grid in skipped}
    rows += [(name, *[""] * (len(columns) - 2), "skipped") for name in names.values()]
    if not fit:
        notes = ["nothing was run: no walk of this set is one of this robot's; try --set strangers, or --speed"]
    notes += [f"{grid.name}: skipped, {reason}" for grid, reason in skipped.items()]
    head = {"robot": loaded.card.name, "preset": options.preset, "engine": options.engine, "set": chosen.name}
    document = {
        **head,
        "identity": loop_identity(loaded),
        **found,
        "skipped": {names[grid]: reason for grid, reason in skipped.items()},
        "interrupted": interrupted,
    }
    result = Result(document, columns, tuple(rows), tuple(notes), interrupted)
    result.write(store.path.with_name("push_largest.json" if options.largest else "push.json"))
    return result


def _run_grids(
    grids: Sequence[PushGrid], robot: Robot, store: Store, jobs: int, progress: Progress
) -> tuple[list[GridOutcome], list[str], bool]:
    """Run every cell of every grid: what became of them, notes, and whether Ctrl-C left some out."""
    scenarios = {(grid, cell): grid.scenario(cell) for grid in grids for cell in grid.cells}
    episodes = run_all(scenarios.values(), robot, store, jobs=jobs, progress=progress, what="pushing")
    outcomes = []
    for grid in grids:
        found = {cell: episodes.found.get(scenarios[grid, cell]) for cell in grid.cells}
        outcomes.append(GridOutcome(grid, {cell: summary for cell, summary in found.items() if summary is not None}))
    notes = episodes.notes(len(scenarios), store)
    for outcome in outcomes:
        limits = ", ".join(f"{name} ({count})" for name, count in outcome.fall_limits().most_common(4))
        if limits:
            notes.append(f"{outcome.grid.name}: falls began with {limits}")
    return outcomes, notes, episodes.interrupted


def _row(outcome: GridOutcome) -> tuple[str, ...]:
    """One grid in words."""
    closest, grid = outcome.closest, outcome.grid
    target = "report" if grid.least is None else f"≥ {grid.least} of {len(grid.cells)}"
    if grid.goal is not None and grid.goal > (grid.least or 0):
        target += f", goal {grid.goal}"
    if grid.separation is not None:
        target += f"; {grid.separation.target()}"
    survived = f"{len(outcome.survivors)} of {len(outcome.found)}"
    return grid.name, target, survived, shown("separation", closest[0] if closest else None), outcome.verdict()


def _largest_row(search: Search) -> tuple[str, ...]:
    """One gait in words; an impulse is marked if no larger one has failed yet, or if one just above may not have."""
    each, least = [], search.everywhere
    for i, (low, high) in enumerate(zip(search.low, search.high, strict=True)):
        unfinished = high is None or search.next_impulse(i) is not None
        known = "unknown" if low is None else f"{'≥ ' if unfinished else ''}{low:g}"
        each.append(f"{search.grid.degrees(i):g}°: {known}")
    return search.grid.gait_name, "unknown" if least is None else f"{least:g} N·s", ", ".join(each)
