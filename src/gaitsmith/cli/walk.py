"""``gaitsmith walk``: a scenario from a file or from flags, run in closed loop, reported and written to a folder."""

from __future__ import annotations

import logging
import re
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from gaitsmith.cli.arguments import Positional, Repeatable, choice, integer, number, numbers, parse, text
from gaitsmith.cli.dispatch import DONE, FELL, INTERRUPTED, Outcome
from gaitsmith.cli.run_folder import check_new_folder, new_folder
from gaitsmith.errors import BadInput
from gaitsmith.files import uninterrupted

if TYPE_CHECKING:
    from gaitsmith.simulation import Episode, Scenario, Simulation

DEFAULT = {"speed": [0.3, 0.0], "duration": 10.0}
"""What ``gaitsmith walk`` alone walks; a scenario file starts from the scenario's own defaults instead."""

_PUSH = "t,Jx,Jy,Jz"
_NOT_SCENARIO = ("scenario", "push", "out", "no_figures", "json")


@dataclass(frozen=True)
class WalkArguments:
    """Walk a robot in closed loop with physics.

    Without a scenario it walks at 0.3 m/s for 10 s. Options override the scenario; its timed changes stay.
    """

    scenario: Annotated[str | None, Positional, text("SCENARIO", "SCENARIO")] = None
    """Scenario file (TOML), or figure5: the paper's speed profile."""
    robot: Annotated[str | None, text("--robot", "NAME_OR_PATH")] = None
    """A robot of the package, or the path of a card."""
    preset: Annotated[str | None, text("--preset", "NAME")] = None
    """Control parameters of the card, such as default or paper."""
    speed: Annotated[
        tuple[float, ...] | None, numbers("--speed", "VX [VY]", (1, 2), "name a scenario before the options")
    ] = None
    """Forward and lateral speed, m/s."""
    yaw_rate: Annotated[float | None, number("--yaw-rate", "RAD/S")] = None
    """Rate at which the heading turns, to the left, rad/s."""
    duration: Annotated[float | None, number("--duration", "S")] = None
    """Length of the whole run, rests included, s."""
    height: Annotated[float | None, number("--height", "M")] = None
    """Hip midpoint above the stance sole, m."""
    period: Annotated[float | None, number("--period", "S")] = None
    """Duration of one step, s."""
    lift: Annotated[float | None, number("--lift", "M")] = None
    """How high the swing sole is lifted, m."""
    width: Annotated[float | None, number("--width", "M")] = None
    """Half the lateral distance between the soles, m."""
    alpha: Annotated[float | None, number("--alpha", "A")] = None
    """Lifting stage's share of the period."""
    push: Annotated[tuple[Annotated[str, text("--push", _PUSH)], ...], Repeatable] = ()
    """Push of 0.1 s at the torso's centre of mass: time, s, and impulse, N·s, world axes."""
    terrain: Annotated[str | None, text("--terrain", "flat|slope:DEG|boxes:M")] = None
    """Ground: flat, a slope (uphill positive), or random boxes up to a height."""
    state: Annotated[str | None, choice("--state", ("true", "estimated"))] = None
    """What the controller sees: the true state, or noisy sensors and an estimator."""
    joint_friction: Annotated[float | None, number("--joint-friction", "N·m")] = None
    """Coulomb friction of every joint, N·m."""
    torque_delay: Annotated[float | None, number("--torque-delay", "S")] = None
    """From torque command to joint, s."""
    friction: Annotated[float | None, number("--friction", "MU")] = None
    """Coulomb coefficient between sole and ground."""
    mass_factor: Annotated[float | None, number("--mass-factor", "X")] = None
    """On every mass and inertia of the plant; the controller keeps the card's."""
    mass_spread: Annotated[float | None, number("--mass-spread", "X")] = None
    """Each body's masses differ by up to this share besides, drawn from the seed."""
    rest_before: Annotated[float | None, number("--rest-before", "S")] = None
    """Standing on both feet before the walk, s."""
    rest_after: Annotated[float | None, number("--rest-after", "S")] = None
    """Standing on both feet after the walk, s."""
    seed: Annotated[int | None, integer("--seed", "N", 0)] = None
    """Seed of everything random."""
    out: Annotated[str | None, text("--out", "DIR", absent="none")] = None
    """New folder for log.mcap, summary.json, scenario.toml and the figures."""
    no_figures: bool = False
    """Write no figures."""
    json: bool = False
    """Print one JSON document instead of the tables."""


def walk(words: list[str], program: str) -> Outcome:
    """Run the command.

    Raises:
        BadInput: the command line, the scenario, the robot, or the output folder cannot be used.
    """
    arguments = parse(WalkArguments, words, program)
    folder = check_new_folder(arguments.out) if arguments.out is not None else None
    scenario = scenario_from(arguments)
    simulation, episode = _run(scenario, arguments)
    with uninterrupted():
        if folder is not None:
            _write(folder, simulation, episode, figures=not arguments.no_figures)
        summary = episode.summary
        code = INTERRUPTED if episode.interrupted else FELL if summary.fell else DONE
        document = summary.model_dump(mode="json") | {"out": str(folder) if folder else None}

    def show() -> None:
        from gaitsmith.cli.walk_report import print_report

        print_report(summary, simulation.robot, folder)

    return Outcome(code, document, show)


def scenario_from(arguments: WalkArguments) -> Scenario:
    """The scenario file, if any, with the flags over it.

    Raises:
        BadInput: naming the flag, or the file and its field.
    """
    from gaitsmith.simulation import load_scenario
    from gaitsmith.simulation.scenario import make_scenario

    given = _given(arguments)
    base = DEFAULT
    if arguments.scenario is not None:
        base = load_scenario(arguments.scenario).model_dump(mode="json", exclude_none=True)
    try:
        return make_scenario({**base, **given})
    except BadInput as error:
        raise _renamed(error, arguments) from None


def _given(arguments: WalkArguments) -> dict[str, Any]:
    """Scenario fields that the flags set."""
    values = {field.name: getattr(arguments, field.name) for field in fields(arguments)}
    given = {name: value for name, value in values.items() if value is not None and name not in _NOT_SCENARIO}
    if arguments.push:
        given["pushes"] = [_push(word) for word in arguments.push]
    return given


def _push(word: str) -> dict[str, Any]:
    """A push as plain data."""
    try:
        time, *impulse = map(float, word.split(","))
        if len(impulse) != 3:
            raise ValueError
    except ValueError:
        valid = f"{_PUSH}, a time in s and an impulse in N·s"
        raise BadInput("--push", word, valid, "for example --push 4,0,15,0") from None
    return {"time": time, "impulse": impulse}


def _renamed(error: BadInput, arguments: WalkArguments) -> BadInput:
    """The error with its field named as the user wrote it: a flag, or a field of the scenario file."""
    name, _, rest = re.match(r"(\w*)(\[\d+\])?\.?(.*)", error.field).groups()  # type: ignore[union-attr]
    flags = {field.name: "--" + field.name.replace("_", "-") for field in fields(arguments)} | {"pushes": "--push"}
    if ": " in error.field:
        return error
    if name in flags and (arguments.scenario is None or name in _given(arguments)):
        return BadInput(f"{flags[name]} {rest}".strip(), error.value, error.valid, error.remedy)
    if arguments.scenario is not None:
        return BadInput(f"{arguments.scenario}: {error.field}", error.value, error.valid, error.remedy)
    return error


def _run(scenario: Scenario, arguments: WalkArguments) -> tuple[Simulation, Episode]:
    """Load everything, then run, with progress on stderr if that is a terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    from gaitsmith.simulation import Simulation

    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[done]}"), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as progress:
        task = progress.add_task("loading (the first time compiles)", total=None, done="")
        try:
            simulation = Simulation(scenario, record=arguments.out is not None)
        except BadInput as error:
            raise _renamed(error, arguments) from None
        progress.reset(task, total=scenario.duration, description=f"walking {simulation.robot.card.name}")

        def advance(time: float) -> None:
            progress.update(task, completed=time, done=f"{time:.1f} of {scenario.duration:g} s")

        return simulation, simulation.run(advance)


def _write(folder: Path, simulation: Simulation, episode: Episode, figures: bool) -> None:
    """Write log, summary, scenario and figures; the folder appears when all of them are there."""
    from gaitsmith.cli.scenario_file import scenario_toml
    from gaitsmith.files import write_text_atomic

    with new_folder(folder) as staging:
        if episode.log is not None:
            episode.log.write(staging / "log.mcap")
        write_text_atomic(staging / "summary.json", episode.summary.model_dump_json(indent=2) + "\n")
        write_text_atomic(staging / "scenario.toml", scenario_toml(_portable(simulation.scenario)))
        if figures and episode.log is not None and len(episode.log.rows) > 1:
            logging.getLogger("matplotlib").setLevel(logging.ERROR)  # it tells of fonts on stderr
            from gaitsmith.view import recording_of, write_figures

            write_figures(recording_of(episode.log, simulation.robot, simulation.tick_us), staging)


def _portable(scenario: Scenario) -> Scenario:
    """The scenario with a robot's path made absolute, so that it runs from any folder."""
    from gaitsmith.robots import robot_names

    if scenario.robot.replace("-", "_") in robot_names():
        return scenario
    return scenario.model_copy(update={"robot": str(Path(scenario.robot).resolve())})
