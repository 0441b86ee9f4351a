"""``gaitsmith walk``: a scenario from a file or from flags, run in closed loop, reported and written to a folder."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from gaitsmith.cli.arguments import Arguments, Positional, as_flag, overriding, parse
from gaitsmith.cli.dispatch import DONE, FELL, INTERRUPTED, Outcome
from gaitsmith.cli.inputs import tell_old_card
from gaitsmith.cli.walk_report import report
from gaitsmith.documents import About
from gaitsmith.errors import BadInput, GaitsmithError
from gaitsmith.files import uninterrupted, write_text_atomic
from gaitsmith.simulation.run_folder import (
    FIGURE_ROWS,
    LOG,
    SCENARIO,
    NewFolder,
    check_new_folder,
    portable,
    scenario_toml,
    write_summary,
)
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
        str | None,
        Positional("Scenario file (TOML), or the paper's figure5, 7, 8, 10 or 11, as figure5", metavar="SCENARIO"),
    ] = None
    out: Annotated[
        str | None,
        About("New folder for log.mcap, which grows as it goes, summary and figures", metavar="DIR", absent="none"),
    ] = None
    no_figures: Annotated[bool, About("Write no figures")] = False


WalkArguments = overriding(_Walk, Scenario, "the robot's", DEFAULT)


def walk(words: list[str], program: str) -> Outcome:
    """Run the command."""
    arguments = parse(WalkArguments, words, program)
    folder = check_new_folder(arguments.out) if arguments.out is not None else None
    scenario = scenario_from(arguments)
    simulation, episode = _run(scenario, arguments, folder)
    with uninterrupted():
        summary = episode.summary
        if folder is not None:
            write_summary(folder, summary)
            if not arguments.no_figures:
                _draw(folder, simulation)
        code = INTERRUPTED if episode.interrupted else FELL if summary.fell else DONE
        document = summary.model_dump(mode="json") | {"out": str(folder) if folder else None}
    return Outcome(code, document, report(summary, simulation.robot, folder, not scenario.controller))


def scenario_from(arguments: _Walk) -> Scenario:
    """The scenario file, if any, with the options over it.

    Raises:
        BadInput: naming the option, or the file and its field.
    """
    base: dict[str, Any] = DEFAULT
    if arguments.scenario is not None:
        base = load_scenario(arguments.scenario).model_dump(mode="json", exclude_none=True)
    given = _given(arguments)
    try:
        whole = {**base, **given}
        if whole.get("gait") or whole.get("library"):
            from gaitsmith.simulation.planned_run import completed

            return make_scenario(completed({**(base if base is not DEFAULT or whole.get("library") else {}), **given}))
        return make_scenario(whole)
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


def _run(scenario: Scenario, arguments: _Walk, folder: Path | None) -> tuple[Simulation, Episode]:
    """Load everything, then run, with progress on stderr if that is a terminal; what a run has done is never lost."""
    from gaitsmith.cli.display import Display
    from gaitsmith.simulation import Simulation

    simulation = None
    made = None if folder is None else NewFolder(folder)
    with Display("loading (the first time compiles)") as display:
        try:
            simulation = Simulation(scenario, record=made.log if made else False)
            tell_old_card(simulation.robot)
            if made is not None:
                write_text_atomic(made.path / SCENARIO, scenario_toml(portable(scenario)))
            name, end = f"walking {simulation.robot.card.name}", scenario.duration
            tell = lambda time: display.show(name, f"{time:.1f} of {end:g} s", time, end)  # noqa: E731
            return simulation, simulation.run(tell)
        except BaseException as error:
            with uninterrupted():
                if isinstance(error, KeyboardInterrupt) and simulation is not None and simulation.tick > 0:
                    simulation.interrupted = True
                    return simulation, simulation.finish()
                if made is not None and (simulation is None or simulation.tick == 0):
                    made.discard()
                elif made is not None and simulation is not None and isinstance(error, GaitsmithError):
                    with contextlib.suppress(BadInput):
                        write_summary(made.path, simulation.summary())
            if isinstance(error, BadInput) and simulation is None:
                raise _renamed(error, arguments) from None
            raise


def _draw(folder: Path, simulation: Simulation) -> None:
    """Draw what the log has to show; a figure that cannot be drawn or written takes nothing else with it."""
    from gaitsmith.cli.display import Display
    from gaitsmith.log import read_log

    with Display("drawing figures") as display:
        try:
            log = read_log(folder / LOG, last=FIGURE_ROWS)
            if len(log.rows) < 2:
                return
            from gaitsmith.view import Recording, write_figures

            if len(log.rows) == FIGURE_ROWS and log.time[0] > 1.0:
                display.say(f"the figures show the run from {log.time[0]:.0f} s on; the log has all of it")
            fell = simulation.fall.time if simulation.fall else None
            write_figures(Recording(log, simulation.robot, simulation.wall_times.histogram(), fell), folder)
        except (GaitsmithError, OSError, MemoryError) as error:
            display.say(f"figures: {error}; log and summary are in {folder}")
