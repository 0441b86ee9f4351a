"""``gaitsmith bench``: the measurements behind every quoted figure, resumable, on as many cores as wanted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

from gaitsmith.cli.arguments import Repeatable, integer, number, numbers, parse, text
from gaitsmith.cli.dispatch import DONE, INTERRUPTED, Outcome
from gaitsmith.files import uninterrupted


@dataclass(frozen=True)
class TickArguments:
    """Measure one control tick: template, inverse kinematics, whole-body QP and joint torques."""

    robot: Annotated[str, text("--robot", "NAME_OR_PATH")] = "bhr_b2"
    """A robot of the package, or the path of a card."""
    preset: Annotated[str, text("--preset", "NAME")] = "default"
    """Control parameters of the card."""
    duration: Annotated[float, number("--duration", "S")] = 20.0
    """Simulated time that is measured, s."""
    json: bool = False
    """Print one JSON document instead of a table."""


@dataclass(frozen=True)
class PushArguments:
    """Push the walking robot in every direction at every phase of the stride.

    Without a walk or an impulse of its own it runs the grids of a set; with one of them it runs that single grid.
    """

    set: Annotated[str, text("--set", "NAME_OR_FILE")] = "walks"
    """Set of trials and grids: walks, courses, planned, or a TOML file."""
    robot: Annotated[str | None, text("--robot", "NAME_OR_PATH", absent="the set's")] = None
    """A robot of the package, or the path of a card."""
    preset: Annotated[str, text("--preset", "NAME")] = "default"
    """Control parameters of the card."""
    gait: Annotated[str | None, text("--gait", "FILE", absent="the template")] = None
    """A planned gait to walk."""
    impulse: Annotated[float | None, number("--impulse", "N·s", absent="standard")] = None
    """Impulse of 0.1 s at the torso's centre of mass, N·s."""
    strength: Annotated[float | None, number("--strength", "X", absent="standard")] = None
    """The impulse over mass times √(gH) instead."""
    speed: Annotated[
        tuple[float, ...] | None, numbers("--speed", "VX [VY]", (1, 2), "forward, and to the left if there are two")
    ] = None
    """Forward and lateral speed, m/s."""
    height: Annotated[float | None, number("--height", "M", absent="standard")] = None
    """Hip midpoint above the stance sole, m."""
    period: Annotated[float | None, number("--period", "S", absent="standard")] = None
    """Duration of one step, s."""
    directions: Annotated[int | None, integer("--directions", "N", 1, absent="the set's, or 8")] = None
    """Directions, evenly around the robot."""
    phases: Annotated[int | None, integer("--phases", "N", 1, absent="the set's, or 12")] = None
    """Phases, evenly over one stride."""
    largest: bool = False
    """Search the largest impulse survived in every direction instead."""
    jobs: Annotated[int, integer("--jobs", "N", 1)] = 1
    """Processes."""
    out: Annotated[str, text("--out", "DIR")] = "runs/bench"
    """Folder of results; runs found there are not repeated."""
    json: bool = False
    """Print one JSON document instead of a table."""


@dataclass(frozen=True)
class BatteryArguments:
    """Run the trials of a set: speeds, heights, slopes, boxes, noise, each against its target."""

    set: Annotated[str, text("--set", "NAME_OR_FILE")] = "walks"
    """Set of trials: walks, courses, courses_estimated, planned, kick, or a TOML file."""
    robot: Annotated[str | None, text("--robot", "NAME_OR_PATH", absent="the set's")] = None
    """A robot of the package, or the path of a card."""
    preset: Annotated[str, text("--preset", "NAME")] = "default"
    """Control parameters of the card."""
    gait: Annotated[str | None, text("--gait", "FILE", absent="the template")] = None
    """A planned gait to walk."""
    only: Annotated[tuple[Annotated[str, text("--only", "NAME")], ...], Repeatable] = ()
    """Run these trials only."""
    jobs: Annotated[int, integer("--jobs", "N", 1)] = 1
    """Processes."""
    out: Annotated[str, text("--out", "DIR")] = "runs/bench"
    """Folder of results; runs found there are not repeated."""
    json: bool = False
    """Print one JSON document instead of a table."""


def tick(words: list[str], program: str) -> Outcome:
    """Run ``bench tick``.

    Raises:
        BadInput: the command line or the robot cannot be used.
    """
    return _measure("measure_tick", parse(TickArguments, words, program))


def push(words: list[str], program: str) -> Outcome:
    """Run ``bench push``.

    Raises:
        BadInput: the command line, the robot or the folder cannot be used.
    """
    return _measure("push_grids", parse(PushArguments, words, program))


def battery(words: list[str], program: str) -> Outcome:
    """Run ``bench battery``.

    Raises:
        BadInput: the command line, the robot or the folder cannot be used.
    """
    return _measure("run_battery", parse(BatteryArguments, words, program))


def _measure(name: str, arguments: Any) -> Outcome:
    """Run one experiment with progress on stderr.

    An experiment takes the options by name and ``progress(done, total, what)``; it returns ``document`` (plain
    data), ``columns`` and ``rows`` (words), ``notes`` (lines) and ``interrupted``.
    """
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    experiment: Callable[..., Any] = getattr(import_module("gaitsmith.experiments"), name)
    options = {key: value for key, value in vars(arguments).items() if key != "json"}
    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as progress:
        task = progress.add_task("loading (the first time compiles)", total=None)

        def advance(done: int, total: int, what: str) -> None:
            progress.update(task, completed=done, total=total, description=what)

        result = experiment(**options, progress=advance)
    with uninterrupted():  # the figures belong to what is recorded already
        _draw_grids(result.document, options)
    return Outcome(INTERRUPTED if result.interrupted else DONE, result.document, lambda: _print_result(result))


def _draw_grids(document: dict[str, Any], options: dict[str, Any]) -> None:
    """A map of every grid of pushes, beside its numbers."""
    if not document.get("grids"):
        return
    import logging

    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    from gaitsmith.view import draw_push_map, save

    for grid in document["grids"]:
        if "survival_time" in grid:
            picture = draw_push_map(grid["name"], grid["survival_time"], grid["survival_limit"])
            save(picture, Path(options["out"]) / f"{grid['slug']}.png")


def _print_result(result: Any) -> None:
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    from gaitsmith.cli.printing import Printer

    console = Printer()
    table = Table(box=SIMPLE_HEAD)
    for index, heading in enumerate(result.columns):
        table.add_column(heading, justify="right" if index else "left")
    for row in result.rows:
        table.add_row(*row)
    console.print(table)
    for note in result.notes:
        console.print(note)
