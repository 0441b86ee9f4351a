"""A finished run, read back from its folder: scenario, robot, log, summary."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from gaitsmith.documents import checked, parse_json
from gaitsmith.errors import BadInput
from gaitsmith.files import read_bounded, write_text_atomic
from gaitsmith.log import Log, read_log
from gaitsmith.robots import Robot, load_robot
from gaitsmith.simulation.episode import Simulation
from gaitsmith.simulation.loop import Observer
from gaitsmith.simulation.recovery import summary_of
from gaitsmith.simulation.run_folder import (
    FIGURE_ROWS,
    LOG,
    SCENARIO,
    SUMMARY,
    NewFolder,
    folder_of,
    scenario_toml,
    write_summary,
)
from gaitsmith.simulation.scenario import Scenario, load_scenario
from gaitsmith.simulation.summary import Summary
from gaitsmith.view import Recording

_LARGEST = 10_000_000  # bytes of a summary


@dataclass(frozen=True)
class Run:
    """A run.

    Attributes:
        robot: that was run, as its files are now.
        log: its last rows, ten minutes at most.
        summary: in numbers; from the log where the run was killed before it wrote one.
        notes: what a reader has to know: a log that was cut, a robot that has changed since.
    """

    folder: Path
    scenario: Scenario
    robot: Robot
    log: Log
    summary: Summary
    notes: tuple[str, ...]

    @property
    def recording(self) -> Recording:
        """What figures draw."""
        fall = self.summary.fall
        return Recording(self.log, self.robot, fell=None if fall is None else fall.time)


def open_run(name: str | Path) -> Run:
    """The run in a folder that ``gaitsmith walk --out`` or a live page has written.

    Raises:
        BadInput: no such folder, no run in it, or one from a newer version.
    """
    folder, notes = folder_of(name), []
    if not (folder / LOG).is_file():
        raise BadInput("RUN", str(name), f"a folder with a {LOG}, as gaitsmith walk --out writes it")
    log = read_log(folder / LOG, last=FIGURE_ROWS)
    if len(log.rows) < 2:
        behind = "the file is damaged behind them" if log.damaged else ""
        raise BadInput(str(folder / LOG), f"{len(log.rows)} rows", "the log of a run that has begun", behind)
    scenario = load_scenario(folder / SCENARIO)
    robot = load_robot(scenario.robot)
    if log.notes.get("robot_hash") not in (None, robot.content_hash):
        notes.append("the robot's files have changed since the run; limits and shapes are those of today")
    if log.damaged:
        notes.append(f"the log is damaged: what follows {log.time[-1]:.3f} s cannot be read")
    elif not log.complete:
        notes.append(f"the log was cut at {log.time[-1]:.3f} s; gaitsmith log check mends it")
    if (folder / SUMMARY).is_file():
        try:
            fields = parse_json(read_bounded(folder / SUMMARY, _LARGEST))
        except (ValueError, RecursionError):
            raise BadInput(str(folder / SUMMARY), "no JSON", "a summary that gaitsmith wrote") from None
        summary = checked(Summary, fields, str(folder / SUMMARY))
    else:
        summary = summary_of(folder / LOG)
        notes.append("there was no summary; this one is from the log")
    return Run(folder, scenario, robot, log, summary, tuple(notes))


def make_run(
    scenario: Scenario,
    folder: Path,
    tell: Callable[[float], None],
    watch: Callable[[Simulation], Observer] | None = None,
) -> Run:
    """Walk a scenario and leave a complete run in a new folder.

    Args:
        folder: new.
        tell: hears of the simulated time, s.
        watch: makes one more observer.

    Raises:
        BadInput: the scenario does not fit the robot, or the disk is full.
        KeyboardInterrupt: a signal; the run up to then is in the folder.
    """
    made = NewFolder(folder)
    simulation = Simulation(scenario, record=made.log)
    write_text_atomic(folder / SCENARIO, scenario_toml(scenario))
    if watch is not None:
        simulation.watch(watch(simulation))
    episode = simulation.run(tell)
    write_summary(folder, episode.summary)
    if episode.interrupted:
        raise KeyboardInterrupt
    return open_run(folder)
