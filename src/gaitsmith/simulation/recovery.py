"""What a killed run left: its log made whole, and its summary from the log."""

from __future__ import annotations

from collections import deque
from pathlib import Path
from typing import BinaryIO, NamedTuple

import numpy as np

from gaitsmith.control.defaults import preset_parameters, robot_scale
from gaitsmith.errors import BadInput
from gaitsmith.log.columns import Columns
from gaitsmith.log.mcap_file import ChunkReader
from gaitsmith.log.mcap_writer import ChunkWriter
from gaitsmith.robots import load_robot
from gaitsmith.simulation.diagnosis import suspects
from gaitsmith.simulation.monitor import UPRIGHT, Monitor
from gaitsmith.simulation.reactions import Reactions, with_unnoticed
from gaitsmith.simulation.report import explain, phase_in_words, refused_readings, sum_up
from gaitsmith.simulation.scenario import make_scenario
from gaitsmith.simulation.strides import Strides
from gaitsmith.simulation.summary import LogCounts, Summary
from gaitsmith.simulation.wall_time import WallTimes


class Found(NamedTuple):
    """What a log holds: rows, time of the last one (s), whether it was finished, whether there is more out of reach."""

    rows: int
    last_time: float
    complete: bool
    damaged: bool = False


def survey(file: BinaryIO, source: str, copy: BinaryIO | None = None) -> Found:
    """Read a log from its beginning to where it was cut.

    Args:
        file: the log, at its beginning.
        source: its name in errors.
        copy: receives what is whole, as a complete log.

    Raises:
        BadInput: not a log, or one from a newer version.
        OSError: ``copy`` takes no more.
    """
    reader = ChunkReader(file, source)
    writer = ChunkWriter(copy, reader.head) if copy is not None else None
    rows, last = 0, 0.0
    for content, blocks in reader.chunks():
        reader.events.clear()
        if writer is not None:
            _attach(reader, writer)
            writer.copy(content)
        for block in blocks:
            rows, last = rows + len(block), float(block[-1, 0])
    if writer is not None:
        _attach(reader, writer)
        writer.finish()
    return Found(rows, last, reader.complete, reader.damaged)


def _attach(reader: ChunkReader, writer: ChunkWriter) -> None:
    """Files that were in the log so far, into its copy."""
    while reader.attachments:
        writer.attach(reader.attachments.pop(0))


def summary_of(path: Path) -> Summary:
    """The summary of a run from its log: what the run's own would be, seen only at every row; no wall times.

    Raises:
        BadInput: not a log of a run, or its robot cannot be loaded.
    """
    with open(path, "rb") as file:
        reader = ChunkReader(file, str(path))
        notes, columns = reader.head.notes, reader.head.columns
        try:
            scenario = make_scenario(notes["scenario"], f"{path.name}: ")
            dt, gait = float(notes["control_step"]) * reader.head.decimation, dict(notes["gait"])
        except (KeyError, TypeError, ValueError) as error:
            raise BadInput(str(path), f"notes without {error}", "the log of a run of gaitsmith walk") from None
        robot = load_robot(scenario.robot)
        row = np.zeros(len(columns))
        seen = Columns((columns, row))
        monitor = Monitor(robot, preset_parameters(robot, robot_scale(robot), scenario.preset), seen, dt, gait)
        reactions = Reactions(seen, scenario.state == "estimated", dt, lambda _: None)
        strides = Strides(seen, monitor.prefix, scenario, dt, robot, gait)
        waiting, rows, started = deque(reader.events), 0, [None] * len(scenario.pushes)
        for block in reader:
            waiting.extend(reader.events)
            reader.events.clear()
            for values in block:
                row[:] = values
                while waiting and waiting[0]["time"] < row[0]:
                    event = waiting.popleft()
                    monitor.hear(event)
                    strides.hear(event)
                    if "push" in event and event["push"] < len(started) and not event.get("over"):
                        started[event["push"]] = event["time"]
                monitor.observe(rows)
                reactions.observe(rows)
                strides.observe(rows)
                rows += 1
    time, fall = float(row[0]), None
    if monitor.state != UPRIGHT:
        place = float(monitor.kept.place[0])
        listed = suspects(scenario, monitor.dated_hits(time), started, reactions.found, place, time, robot)
        fall = explain(monitor, time, phase_in_words(seen), refused_readings(seen), listed[0].what)
    changed = robot.content_hash != notes.get("robot_hash")
    return sum_up(
        scenario,
        robot,
        monitor,
        seen,
        duration=time,
        fall=fall,
        interrupted=True,
        tick_us=WallTimes(dt).summary(),
        realtime_factor=0.0,
        pushes=tuple(started),
        **strides.report(fall is not None),
        faults=with_unnoticed(tuple(reactions.found), scenario.faults, time),
        warnings=("the robot's files have changed since the run",) if changed else (),
        memory_mb=None,
        log=LogCounts(rows=rows, dropped=reader.head.dropped, complete=reader.complete),
    )
