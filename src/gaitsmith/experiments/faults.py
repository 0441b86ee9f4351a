"""``gaitsmith bench faults``: every component that fails in every way, for every duration, at instants of a stride."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gaitsmith.errors import BadInput
from gaitsmith.experiments.episodes import loop_identity, run_all
from gaitsmith.experiments.options import FaultOptions
from gaitsmith.experiments.result import Progress, Result, silent
from gaitsmith.experiments.store import Store
from gaitsmith.robots import Robot, load_robot
from gaitsmith.simulation import Scenario, Summary
from gaitsmith.simulation.faults import (
    MOTOR_FAULTS,
    SENSOR_FAULTS,
    TICK_FAULTS,
    TICKS,
    Fault,
    members,
    motors,
    sensors,
)
from gaitsmith.simulation.reactions import UNNOTICED, ended_braked

_BEFORE, _AFTER = 6.0, 9.0  # of the period: walked before the first instant; watched after the fault
_NOTHING: Mapping[str, Any] = {}
_UNREAD = {
    "true": ("accelerometer", "gyro"),
    "estimated": ("base_position", "base_velocity", ".rate"),
}


@dataclass(frozen=True)
class Cell:
    """One component, one way to fail, one duration: an episode for every instant."""

    component: str
    type: str
    duration: float
    scenarios: tuple[Scenario, ...]


def run_faults(
    options: FaultOptions, progress: Progress = silent, fields: Mapping[str, Any] = _NOTHING, address: str = ""
) -> Result:
    """Run the matrix; ``faults.json`` is written to the folder of results too.

    Args:
        address: of a Ray cluster instead of processes here.
        fields: of the scenario, put over every episode's.

    Raises:
        BadInput: a component or a type that the robot does not have, or the robot or the folder cannot be used.
    """
    robot = load_robot(options.robot)
    store, cells = Store(options.out), _cells(options, robot, fields)
    wanted = [scenario for cell in cells for scenario in cell.scenarios]
    episodes = run_all(wanted, robot, store, jobs=options.jobs, address=address, progress=progress, what="failing")
    found = [(cell, [s for one in cell.scenarios if (s := episodes.found.get(one))]) for cell in cells]
    document = {
        "robot": robot.card.name,
        "preset": options.preset,
        "state": options.state,
        "identity": loop_identity(robot),
        "faults": [_entry(cell, summaries) for cell, summaries in found],
        "interrupted": episodes.interrupted,
    }
    columns = ("component", "type", *(f"{1000 * d:g} ms" for d in options.duration), "reaction")
    rows = [_row(options, found, *pair) for pair in dict.fromkeys((cell.component, cell.type) for cell in cells)]
    notes = [_total(duration, found) for duration in options.duration] + episodes.notes(len(wanted), store)
    result = Result(document, columns, tuple(rows), tuple(notes), episodes.interrupted)
    result.write(store.path.with_name("faults.json"))
    return result


def _cells(options: FaultOptions, robot: Robot, fields: Mapping[str, Any]) -> list[Cell]:
    """All cells that were asked for; a sensor that the controller does not read in this state is left out."""
    unread = _UNREAD[options.state]
    every = [name for name in sensors(robot) if not name.endswith(unread)]
    every += [*motors(robot), TICKS, *(["imu"] if options.state == "estimated" else [])]
    names, gait = options.component or tuple(every), robot.card.gait
    speed = options.speed * math.sqrt(9.81 * gait.height)
    cells = []
    for name in names:
        try:
            first = members(Fault(component=name, type="delayed", time=0.0, duration=1.0), robot)[0]
        except BadInput as error:
            raise error.named("--component") from None
        kinds = TICK_FAULTS if first == TICKS else MOTOR_FAULTS if first.endswith(".motor") else SENSOR_FAULTS
        for kind in options.type or kinds:
            if kind not in kinds:
                if options.component and kind not in {*SENSOR_FAULTS, *MOTOR_FAULTS}:
                    raise BadInput(
                        "--type", kind, "one of " + ", ".join(dict.fromkeys((*SENSOR_FAULTS, *MOTOR_FAULTS)))
                    )
                continue
            for duration in options.duration:
                cells.append(_cell(options, name, kind, duration, gait.period, speed, fields))
    if not cells:
        raise BadInput("--type", ", ".join(options.type), "ways in which these components can fail")
    return cells


def _cell(
    options: FaultOptions,
    name: str,
    kind: Any,
    duration: float,
    period: float,
    speed: float,
    fields: Mapping[str, Any],
) -> Cell:
    """Its episodes."""
    scenarios = []
    for k in range(options.instants):
        begin = round(1.0 + _BEFORE * period + 2.0 * period * k / options.instants, 3)
        scenarios.append(
            Scenario(
                robot=options.robot,
                preset=options.preset,
                state=options.state,
                speed=(speed, 0.0),
                duration=round(begin + duration + _AFTER * period, 3),
                faults=(Fault(component=name, type=kind, time=begin, duration=duration),),
                **fields,
            )
        )
    return Cell(name, kind, duration, tuple(scenarios))


def _stood(summaries: list[Summary]) -> int:
    return sum(not summary.fell and summary.control_state != "fault" for summary in summaries)


def _braked(summary: Summary) -> bool:
    """Whether a run ended with braked joints and a name for it, before the robot was down."""
    if summary.fall is None:
        return summary.control_state == "fault"
    return ended_braked(summary.faults, summary.fall.time)


def _reaction(summaries: list[Summary]) -> str:
    """What was done most often."""
    done = Counter(entry.reaction for summary in summaries for entry in summary.faults if entry.reaction != UNNOTICED)
    return done.most_common(1)[0][0] if done else UNNOTICED


def _entry(cell: Cell, summaries: list[Summary]) -> dict[str, Any]:
    """One cell as plain data; ``braked`` counts those that ended with braked joints and a name, before they fell."""
    return {
        "component": cell.component,
        "type": cell.type,
        "duration": cell.duration,
        "survived": _stood(summaries),
        "of": len(summaries),
        "braked": sum(map(_braked, summaries)),
        "reaction": _reaction(summaries),
        "falls": [
            {"time": scenario.faults[0].time, "reason": summary.fall.reason, "braked": _braked(summary)}
            for scenario, summary in zip(cell.scenarios, summaries, strict=False)
            if summary.fall is not None
        ],
    }


def _row(options: FaultOptions, found: list[tuple[Cell, list[Summary]]], name: str, kind: str) -> tuple[str, ...]:
    """One component and type in words."""
    own = {cell.duration: summaries for cell, summaries in found if (cell.component, cell.type) == (name, kind)}
    counts = [f"{_stood(own[d])} of {len(own[d])}" for d in options.duration]
    return name, kind, *counts, _reaction([summary for summaries in own.values() for summary in summaries])


def _total(duration: float, found: list[tuple[Cell, list[Summary]]]) -> str:
    """How many of one duration stood."""
    own = [summary for cell, summaries in found if cell.duration == duration for summary in summaries]
    stood, braked = _stood(own), sum(map(_braked, own))
    rest = f", {braked} ended braked, {len(own) - stood - braked} fell without" if stood < len(own) else ""
    return f"{1000 * duration:g} ms: {stood} of {len(own)} stood{rest}"
