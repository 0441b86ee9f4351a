"""``gaitsmith walk``: a scenario from a file or from flags, run in closed loop, reported and written to a folder."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from gaitsmith.cli.arguments import Arguments, Positional, as_flag, overriding, parse
from gaitsmith.cli.dispatch import DONE, FELL, INTERRUPTED, Outcome
from gaitsmith.cli.run_folder import check_new_folder, new_folder
from gaitsmith.documents import About
from gaitsmith.errors import BadInput
from gaitsmith.files import uninterrupted
from gaitsmith.simulation.scenario import Scenario, load_scenario, make_scenario

if TYPE_CHECKING:
    from gaitsmith.simulation import Episode, Simulation

DEFAULT = {"speed": [0.3, 0.0], "duration": 10.0}
"""What ``gaitsmith walk`` alone walks; a scenario file starts from the scenario's own defaults instead."""


class _Walk(Arguments):
    """Walk a robot in closed loop with physics.

    Without a scenario it walks at 0.3 m/s for 10 s. Options override the scenario; its timed changes stay.
    """

    scenario: Annotated[
        str | None, Positional("Scenario file (TOML), or figure5: the paper's speed profile", metavar="SCENARIO")
    ] = None
    out: Annotated[
        str | None,
        About("New folder for log.mcap, summary.json, scenario.toml and the figures", metavar="DIR", absent="none"),
    ] = None
    no_figures: Annotated[bool, About("Write no figures")] = False


WalkArguments = overriding(_Walk, Scenario, "the robot's", DEFAULT)


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


def scenario_from(arguments: _Walk) -> Scenario:
    """The scenario file, if any, with the options over it.

    Raises:
        BadInput: naming the option, or the file and its field.
    """
    base = DEFAULT
    if arguments.scenario is not None:
        base = load_scenario(arguments.scenario).model_dump(mode="json", exclude_none=True)
    try:
        return make_scenario({**base, **_given(arguments)})
    except BadInput as error:
        raise _renamed(error, arguments) from None


def _given(arguments: _Walk) -> dict[str, Any]:
    """Scenario fields that the options set."""
    return arguments.model_dump(mode="json", exclude_none=True, exclude=set(_Walk.model_fields))


def _renamed(error: BadInput, arguments: _Walk) -> BadInput:
    """The error with its field named as the user wrote it: an option, or a field of the scenario file."""
    given = list(_given(arguments)) if arguments.scenario is not None else None
    found = as_flag(error, WalkArguments, given)
    if found is not error or arguments.scenario is None or ": " in error.field:
        return found
    return error.within(arguments.scenario)


def _run(scenario: Scenario, arguments: _Walk) -> tuple[Simulation, Episode]:
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
