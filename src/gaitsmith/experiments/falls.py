"""``gaitsmith bench falls``: falls of known cause, and whether the fall report names it and its replay confirms it."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from gaitsmith.errors import BadInput
from gaitsmith.experiments.episodes import episode_key, loop_identity
from gaitsmith.experiments.options import FallOptions
from gaitsmith.experiments.push_grid import momentum_unit
from gaitsmith.experiments.result import Progress, Result, silent
from gaitsmith.experiments.store import Lines
from gaitsmith.robots import Robot, load_robot
from gaitsmith.simulation.disturbances import Push
from gaitsmith.simulation.faults import Fault
from gaitsmith.simulation.replay import Verdict, why
from gaitsmith.simulation.scenario import Scenario

FILE = "falls.jsonl"
_TRIES = 4  # draws, in falls asked for, before it is given up
Draw = Callable[[np.random.Generator, Robot], dict[str, Any]]


def _push(rng: np.random.Generator, robot: Robot) -> dict[str, Any]:
    size = rng.uniform(0.8, 1.3) * momentum_unit(robot, robot.card.gait.height)
    angle = rng.uniform(0.0, 2.0 * math.pi)
    impulse = (round(size * math.cos(angle), 2), round(size * math.sin(angle), 2), 0.0)
    return {"pushes": (Push(time=round(rng.uniform(2.5, 4.0), 3), impulse=impulse),)}


def _fault(rng: np.random.Generator, robot: Robot) -> dict[str, Any]:
    leg = robot.legs[int(rng.integers(2))]
    name = f"{robot.joint_names[leg.knee]}.motor"
    return {"faults": (Fault(component=name, type="dead", time=round(rng.uniform(2.5, 4.0), 3), duration=1.0),)}


def _fast(robot: Robot, share: float) -> tuple[float, float]:
    """A speed in units of √(gH), forward."""
    return (round(share * math.sqrt(9.81 * robot.card.gait.height), 3), 0.0)


KNOWN: dict[str, Draw] = {
    "push": _push,
    "terrain": lambda rng, _: {
        "terrain": f"{('slope', 'cross')[int(rng.integers(2))]}:{rng.choice([-1, 1]) * rng.uniform(20.0, 28.0):.1f}"
    },
    "friction": lambda rng, robot: {"friction": round(rng.uniform(0.05, 0.1), 3), "speed": _fast(robot, 0.23)},
    "delay": lambda rng, _: {"torque_delay": round(rng.uniform(0.015, 0.03), 4)},
    "fault": _fault,
    "joint_friction": lambda rng, robot: {
        "joint_friction": round(rng.uniform(0.35, 0.6) * float(np.max(robot.torque_limit)), 1)
    },
}
"""A factor each, by the kind that the diagnosis should name; it is drawn strong enough to fell most robots."""


def run_falls(options: FallOptions, progress: Progress = silent) -> Result:
    """Draw falls, one factor each, and ask why; ``falls.json`` is written to the folder of results too.

    Raises:
        BadInput: an unknown kind, or the robot or the folder cannot be used.
    """
    robot, kinds = load_robot(options.robot), options.kind or tuple(KNOWN)
    for kind in kinds:
        if kind not in KNOWN:
            raise BadInput("--kind", kind, "one of " + ", ".join(KNOWN))
    folder = Path(options.out)
    kept = Lines(folder, FILE)
    loop, stood, interrupted = loop_identity(robot), 0, False
    found: list[tuple[str, Scenario, Verdict]] = []
    try:
        for number in range(_TRIES * options.falls):
            if len(found) == options.falls:
                break
            kind = kinds[number % len(kinds)]
            scenario = _scenario(options, robot, kind, number)
            key = episode_key(loop, scenario)
            progress(len(found), options.falls, f"{kind}: falling and asking why")
            if key not in kept:
                verdict = why(scenario, robot=robot)
                kept.keep(key, None if verdict is None else verdict.model_dump(mode="json"))
            if kept[key] is None:
                stood += 1
            else:
                found.append((kind, scenario, Verdict.model_validate(kept[key])))
    except KeyboardInterrupt:
        interrupted = True
    entries = [_entry(kind, scenario, verdict) for kind, scenario, verdict in found]
    right, confirmed = (sum(entry[name] for entry in entries) for name in ("right", "confirmed"))
    document = {
        "robot": robot.card.name,
        "identity": loop,
        "falls": entries,
        "right": right,
        "confirmed": confirmed,
        "of": len(entries),
        "stood": stood,
        "interrupted": interrupted,
    }
    rows = [_row(kind, [entry for entry in entries if entry["kind"] == kind]) for kind in kinds]
    notes = [f"{right} of {len(entries)} causes named right, {confirmed} of them confirmed; {stood} draws stood"]
    notes += [f"{kept.damaged} damaged lines in {kept.path} were passed over"] if kept.damaged else []
    columns = ("known cause", "falls", "named right", "and confirmed", "else named")
    result = Result(document, columns, tuple(rows), tuple(notes), interrupted)
    result.write(folder / "falls.json")
    return result


def _scenario(options: FallOptions, robot: Robot, kind: str, number: int) -> Scenario:
    """A walk with one factor."""
    rng = np.random.default_rng([options.seed, number])
    fields = {"speed": _fast(robot, 0.115), "duration": 12.0, **KNOWN[kind](rng, robot)}
    return Scenario(robot=options.robot, preset=options.preset, seed=number, **fields)


def _entry(kind: str, scenario: Scenario, verdict: Verdict) -> dict[str, Any]:
    """One fall as plain data."""
    right = verdict.kind == kind
    return {
        "kind": kind,
        "named": verdict.kind,
        "cause": verdict.cause.model_dump(),
        "right": right,
        "confirmed": right and verdict.cause.confirmed is True,
        "edge": verdict.edge,
        "seed": scenario.seed,
        "time": verdict.fall.time,
        "reason": verdict.fall.reason,
    }


def _row(kind: str, own: list[dict[str, Any]]) -> tuple[str, ...]:
    right = [entry for entry in own if entry["right"]]
    others = ", ".join(dict.fromkeys(entry["named"] for entry in own if not entry["right"]))
    return kind, str(len(own)), str(len(right)), str(sum(entry["confirmed"] for entry in right)), others
