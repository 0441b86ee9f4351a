"""``gaitsmith bench``: the measurements behind every quoted figure, resumable, on as many cores as wanted."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from gaitsmith.cli.arguments import Arguments, Jobs, Preset, RobotName, parse
from gaitsmith.cli.dispatch import DONE, INTERRUPTED, Outcome, Table
from gaitsmith.documents import About
from gaitsmith.files import uninterrupted

_Set = Annotated[str, About("Set of trials and grids of the package, or a TOML file", metavar="NAME_OR_FILE")]
_Robot = Annotated[
    str | None, About("A robot of the package, or the path of a card", metavar="NAME_OR_PATH", absent="the set's")
]
_Gait = Annotated[str | None, About("A planned gait to walk", metavar="FILE", absent="the template")]
_Folder = Annotated[str, About("Folder of results; runs found there are not repeated", metavar="DIR")]


class TickArguments(Arguments):
    """Measure one control tick: template, inverse kinematics, whole-body QP and joint torques."""

    robot: RobotName = "bhr_b2"
    preset: Preset = "default"
    duration: Annotated[float, About("Simulated time that is measured", "s", "S")] = 20.0


class PushArguments(Arguments):
    """Push the walking robot in every direction at every phase of the stride.

    Without a walk or an impulse of its own it runs the grids of a set; with one of them it runs that single grid.
    """

    set: _Set = "walks"
    robot: _Robot = None
    preset: Preset = "default"
    gait: _Gait = None
    impulse: Annotated[
        float | None, About("Impulse of 0.1 s at the torso's centre of mass", "N·s", "N·s", absent="standard")
    ] = None
    strength: Annotated[
        float | None, About("The impulse over mass times √(gH) instead", metavar="X", absent="standard")
    ] = None
    speed: Annotated[
        tuple[float, float] | None, About("Forward and lateral speed", "m/s", "VX [VY]", absent="standard")
    ] = None
    height: Annotated[float | None, About("Hip midpoint above the stance sole", "m", "M", absent="standard")] = None
    period: Annotated[float | None, About("Duration of one step", "s", "S", absent="standard")] = None
    directions: Annotated[
        int | None, Field(ge=1), About("Directions, evenly around the robot", metavar="N", absent="the set's, or 8")
    ] = None
    phases: Annotated[
        int | None, Field(ge=1), About("Phases, evenly over one stride", metavar="N", absent="the set's, or 12")
    ] = None
    largest: Annotated[bool, About("Search the largest impulse survived in every direction instead")] = False
    jobs: Jobs = 1
    out: _Folder = "runs/bench"


class BatteryArguments(Arguments):
    """Run the trials of a set: speeds, heights, slopes, boxes, noise, each against its target."""

    set: _Set = "walks"
    robot: _Robot = None
    preset: Preset = "default"
    gait: _Gait = None
    only: Annotated[tuple[str, ...], About("Run these trials only", metavar="NAME")] = ()
    jobs: Jobs = 1
    out: _Folder = "runs/bench"


class TourArguments(Arguments):
    """Run the public teleoperation test of walking: 90 s, 18 waypoints, 18 punches.

    The table has our row beside published ones, and says what is different.
    """

    robot: RobotName = "bhr_b2"
    preset: Preset = "default"
    runs: Annotated[int, Field(ge=1, le=10_000), About("Run ids", metavar="N")] = 32
    first: Annotated[int, Field(ge=0, lt=2**31), About("The first of them", metavar="ID")] = 0
    force: Annotated[float, Field(ge=0.0, le=10.0), About("Factor on all punches, 0 for none", metavar="X")] = 1.0
    height: Annotated[float | None, About("Hip midpoint above the stance sole", "m", "M", absent="the card's")] = None
    period: Annotated[float | None, About("Duration of one step", "s", "S", absent="the card's")] = None
    width: Annotated[float | None, About("Half the distance of the soles", "m", "M", absent="the card's")] = None
    jobs: Jobs = 1
    out: _Folder = "runs/bench"


_EXPERIMENTS: dict[str, tuple[type[Arguments], str]] = {
    "tick": (TickArguments, "measure_tick"),
    "push": (PushArguments, "push_grids"),
    "battery": (BatteryArguments, "run_battery"),
    "tour": (TourArguments, "run_tour"),
}


def bench(words: list[str], program: str) -> Outcome:
    """Run the experiment that the program's last word names, with progress on stderr.

    An experiment takes the options by name and ``progress(done, total, what)``; it returns ``document`` (plain
    data), ``columns`` and ``rows`` (words), ``notes`` (lines) and ``interrupted``.
    """
    kind, name = _EXPERIMENTS[program.split()[-1]]
    options = parse(kind, words, program).model_dump(exclude={"json_"})
    from gaitsmith.cli.display import Display

    experiment: Callable[..., Any] = getattr(import_module("gaitsmith.experiments"), name)
    with Display("loading (the first time compiles)") as display:
        advance = lambda done, total, what: display.show(what, f"{done} of {total}", done, total)  # noqa: E731
        result = experiment(**options, progress=advance)
    with uninterrupted():  # the figures belong to what is recorded already
        _draw_grids(result.document, options)
    text = [Table(result.columns, result.rows), *result.notes]
    return Outcome(INTERRUPTED if result.interrupted else DONE, result.document, text)


def _draw_grids(document: dict[str, Any], options: dict[str, Any]) -> None:
    """A map of every grid of pushes, beside its numbers."""
    if not document.get("grids"):
        return
    from gaitsmith.view import draw_push_map, save

    for grid in document["grids"]:
        if "survival_time" in grid:
            picture = draw_push_map(grid["name"], grid["survival_time"], grid["survival_limit"])
            save(picture, Path(options["out"]) / f"{grid['slug']}.png")
