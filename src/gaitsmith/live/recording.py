"""Recording a stretch of a walk that somebody steers, as the folder of a run."""

from __future__ import annotations

import time
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from gaitsmith.errors import BadInput
from gaitsmith.files import write_text_atomic
from gaitsmith.log.record import DECIMATION, Recorder
from gaitsmith.simulation.run_folder import LOG, SCENARIO, NewFolder, log_notes, portable, scenario_toml, write_summary

if TYPE_CHECKING:
    from gaitsmith.simulation.episode import Simulation


class Recording:
    """Observer that writes a log while it is asked to; its time begins with the recording.

    Args:
        parent: folder in which each recording gets one of its own, named after the time of day.

    Attributes:
        folder: of the recording that goes on; None while there is none.
        done: of the last one that ended.
        trouble: why the last one could not go on, in words.
    """

    def __init__(self, simulation: Simulation, parent: Path) -> None:
        self._simulation, self._parent = simulation, parent
        self.folder: Path | None = None
        self.done: Path | None = None
        self.trouble = ""
        self._time = np.zeros(1)
        self._recorder: Recorder | None = None
        self._file: BinaryIO | None = None

    def start(self, walks: bool) -> None:
        """Begin, if none goes on; ``walks`` whether a walk is asked for."""
        if self.folder is not None:
            return
        simulation, self.trouble = self._simulation, ""
        folder = _unused(self._parent / time.strftime("live-%Y%m%d-%H%M%S"))
        gait = simulation.controller.gait
        update = {} if simulation.plan else {**gait.model_dump(), "rest_before": 0.0}
        self._scenario = scenario = simulation.scenario.model_copy(update=update)
        notes = log_notes(scenario, simulation.robot, simulation.plant.control_step, gait.model_dump())
        try:
            made = NewFolder(folder)
            self._file = made.log()
            write_text_atomic(folder / SCENARIO, scenario_toml(portable(scenario)))
            first, *rest = simulation.columns.buffers
            scene = simulation.scene_log()
            buffers = (self._time, first[1:], *rest)  # the first number is the time
            self._recorder = Recorder(self._file, buffers, simulation.columns.names, notes, DECIMATION, scene)
        except BadInput as error:
            self.trouble = str(error)
            return
        self.folder, self._began = folder, simulation.time
        if walks and simulation.plan is None:
            self.hear({"time": simulation.time, "action": "walk"})

    def stop(self) -> None:
        """End, and finish the log."""
        if self.folder is None or self._recorder is None or self._file is None:
            return
        self.done, self.folder = self.folder, None
        try:
            length = max(self._simulation.time - self._began, self._simulation.plant.control_step)
            scenario = self._scenario.model_copy(update={"duration": length})
            write_text_atomic(self.done / SCENARIO, scenario_toml(portable(scenario)))
            if self._simulation.loop.over:
                self._recorder.observe(0)  # the last tick, whatever its number: the fall
            self._recorder.close()
        except BadInput as error:
            self.trouble = str(error)
        self._file.close()

    def observe(self, tick: int) -> bool:
        """Take the present row if its turn has come; never ends the run, whatever happens to the disk."""
        if self.folder is None or self._recorder is None:
            return False
        self._time[0] = self._simulation.columns.buffers[0][0] - self._began
        try:
            self._recorder.observe(tick)
        except BadInput as error:
            self.stop()
            self.trouble = str(error)
        return False

    def hear(self, event: Mapping[str, Any]) -> None:
        """Keep something that happened once."""
        if self.folder is not None and self._recorder is not None:
            self._recorder.hear({**event, "time": event["time"] - self._began})


def finish_folder(folder: Path) -> str:
    """Write the summary of a recording from its log; what went wrong, in words, if something did."""
    from gaitsmith.simulation.recovery import summary_of

    try:
        write_summary(folder, summary_of(folder / LOG))
    except (BadInput, OSError) as error:
        return str(error)
    return ""


def _unused(folder: Path) -> Path:
    """The folder, or one numbered behind it that does not exist yet."""
    names = (folder.with_name(f"{folder.name}{f'-{k}' if k else ''}") for k in range(1000))
    return next(name for name in names if not name.exists())
