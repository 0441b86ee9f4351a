"""``gaitsmith bench falls``: falls of known cause, and whether the fall report names it and its replay confirms it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from gaitsmith.control.defaults import preset_parameters, robot_scale
from gaitsmith.errors import BadInput
from gaitsmith.experiments.episodes import episode_key, loop_identity
from gaitsmith.experiments.options import FallOptions
from gaitsmith.experiments.push_grid import momentum_unit
from gaitsmith.experiments.result import Progress, Result, silent
from gaitsmith.experiments.store import Lines
from gaitsmith.robots import Robot, load_robot
from gaitsmith.robots.presets import ControlParameters
from gaitsmith.simulation.disturbances import Push
from gaitsmith.simulation.faults import TICKS, Fault
from gaitsmith.simulation.replay import Verdict, why
from gaitsmith.simulation.scenario import Scenario
from gaitsmith.simulation.sensors import SensorNoise

FILE = "falls.jsonl"
_TRIES = 4  # draws, in falls asked for, before it is given up
_FIRST, _LAST = 2.5, 4.0  # s, when something happens


class Drawn(NamedTuple):
    """One factor: fields of the scenario, a robot that differs, and a word of the cause."""

    fields: Mapping[str, Any]
    robot: Robot | None = None
    word: str = ""


class Known(NamedTuple):
    """What the diagnosis should call a factor, and how one is drawn, strong enough to fell most robots."""

    kind: str
    draw: Callable[[np.random.Generator, Robot], Drawn]


def _units(robot: Robot) -> tuple[float, float]:
    """√(gH), m/s, and √(H/g), s."""
    height = robot.card.gait.height
    return math.sqrt(9.81 * height), math.sqrt(height / 9.81)


def _fast(robot: Robot, share: float) -> tuple[float, float]:
    """A speed in units of √(gH), forward."""
    return (round(share * _units(robot)[0], 3), 0.0)


def _when(rng: np.random.Generator) -> float:
    return round(rng.uniform(_FIRST, _LAST), 3)


def _push(rng: np.random.Generator, robot: Robot) -> Drawn:
    size = rng.uniform(0.8, 1.3) * momentum_unit(robot, robot.card.gait.height)
    angle = rng.uniform(0.0, 2.0 * math.pi)
    impulse = (round(size * math.cos(angle), 2), round(size * math.sin(angle), 2), 0.0)
    return Drawn({"pushes": (Push(time=_when(rng), impulse=impulse),)})


def _motor(rng: np.random.Generator, robot: Robot) -> Drawn:
    leg, kind = robot.legs[int(rng.integers(2))], ("dead", "stuck")[int(rng.integers(2))]
    joint = robot.joint_names[leg.knee] if kind == "dead" else leg.joints[int(rng.integers(len(leg.joints)))]
    name = f"{joint}.motor"
    return Drawn({"faults": (Fault(component=name, type=kind, time=_when(rng), duration=2.0),)}, word=name)


def _late(rng: np.random.Generator, robot: Robot) -> Drawn:
    return Drawn({"faults": (Fault(component=TICKS, type="dead", time=_when(rng), duration=2.0),)}, word=TICKS)


def _reading(rng: np.random.Generator, robot: Robot) -> Drawn:
    leg = robot.legs[int(rng.integers(2))]
    name = f"{robot.joint_names[leg.knee]}.angle"
    kind = ("nan", "stuck", "zero")[int(rng.integers(3))]
    fault = Fault(component=name, type=kind, time=_when(rng), duration=2.0)
    return Drawn({"faults": (fault,), "state": "estimated"}, word=name)


def _ground(rng: np.random.Generator, robot: Robot) -> Drawn:
    kind = ("slope", "cross")[int(rng.integers(2))]
    return Drawn({"terrain": f"{kind}:{rng.choice([-1, 1]) * rng.uniform(20.0, 28.0):.1f}"})


def _mass(rng: np.random.Generator, robot: Robot) -> Drawn:
    angle, size = rng.uniform(0.0, 2.0 * math.pi), rng.uniform(0.3, 0.4) * robot.card.gait.height
    return Drawn({"torso_shift": (round(size * math.cos(angle), 3), round(size * math.sin(angle), 3), 0.0)})


def _noise(rng: np.random.Generator, robot: Robot) -> Drawn:
    factor, usual = rng.uniform(15.0, 40.0), SensorNoise().model_dump()
    return Drawn(
        {"state": "estimated", "sensors": SensorNoise(**{k: round(min(factor * v, 10.0), 6) for k, v in usual.items()})}
    )


def _preset(robot: Robot, group: str, **factors: float) -> Robot:
    """A robot whose default preset has other numbers in one group, by factors."""
    own = preset_parameters(robot, robot_scale(robot), "default").model_dump()
    own[group] |= {name: factor * own[group][name] for name, factor in factors.items()}
    presets = robot.card.presets | {"default": ControlParameters.model_validate(own)}
    return replace(robot, card=robot.card.model_copy(update={"presets": presets}))


def _weak(rng: np.random.Generator, robot: Robot) -> Drawn:
    return Drawn({}, replace(robot, torque_limit=rng.uniform(0.2, 0.27) * robot.torque_limit))


def _slow(rng: np.random.Generator, robot: Robot) -> Drawn:
    """Joints that may not turn as fast as the walk needs; where the QP holds the swing foot they fell nobody."""
    slower = replace(robot, velocity_limit=rng.uniform(0.02, 0.04) * robot.velocity_limit)
    return Drawn({"preset": _JOINTS_HELD} if _JOINTS_HELD in robot.card.presets else {}, slower)


def _lag(rng: np.random.Generator, robot: Robot) -> Drawn:
    share = rng.uniform(0.005, 0.01)
    softer = {f"{what}_{name}": share**power for what in ("foot", "joint") for name, power in _POWERS.items()}
    return Drawn({}, _preset(robot, "tracking", **softer))


_JOINTS_HELD = "paper"  # preset with a PD on every joint
_POWERS = {"stiffness": 1.0, "damping": 0.5}
KNOWN = {
    "push": Known("push", _push),
    "slope": Known("terrain", _ground),
    "boxes": Known("terrain", lambda rng, r: Drawn({"terrain": f"boxes:{rng.uniform(0.2, 0.3):.3f}"})),
    "slip": Known(
        "friction", lambda rng, r: Drawn({"friction": round(rng.uniform(0.05, 0.1), 3), "speed": _fast(r, 0.23)})
    ),
    "delay": Known("delay", lambda rng, r: Drawn({"torque_delay": round(rng.uniform(0.06, 0.11) * _units(r)[1], 4)})),
    "motor": Known("fault", _motor),
    "reading": Known("fault", _reading),
    "late_ticks": Known("fault", _late),
    "joint_friction": Known(
        "joint_friction",
        lambda rng, r: Drawn({"joint_friction": round(rng.uniform(0.35, 0.5) * float(np.max(r.torque_limit)), 1)}),
    ),
    "mass": Known("mass", _mass),
    "noise": Known("noise", _noise),
    "speed": Known("command", lambda rng, r: Drawn({"speed": _fast(r, rng.uniform(0.85, 0.95))})),
    "torque_limit": Known("torque", _weak),
    "speed_limit": Known("velocity", _slow),
    "swing_lag": Known("lag", _lag),
}
"""Factors by name."""


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
    entries: list[dict[str, Any]] = []
    try:
        for number in range(_TRIES * options.falls):
            if len(entries) == options.falls:
                break
            kind = kinds[number % len(kinds)]
            drawn, scenario = _draw(options, robot, kind, number)
            key = f"{kind} {number} {episode_key(loop, scenario)}"
            progress(len(entries), options.falls, f"{kind}: falling and asking why")
            if key not in kept:
                verdict = why(scenario, robot=drawn.robot or robot)
                kept.keep(key, None if verdict is None else verdict.model_dump(mode="json"))
            if kept[key] is None:
                stood += 1
            else:
                entries.append(_entry(kind, drawn.word, scenario, Verdict.model_validate(kept[key])))
    except KeyboardInterrupt:
        interrupted = True
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


def _draw(options: FallOptions, robot: Robot, kind: str, number: int) -> tuple[Drawn, Scenario]:
    """A walk with one factor."""
    drawn = KNOWN[kind].draw(np.random.default_rng([options.seed, number]), robot)
    fields = {"preset": options.preset, "speed": _fast(robot, 0.115), "duration": 12.0, **drawn.fields}
    return drawn, Scenario(robot=options.robot, seed=number, **fields)


def _entry(kind: str, word: str, scenario: Scenario, verdict: Verdict) -> dict[str, Any]:
    """One fall as plain data."""
    right = verdict.kind == KNOWN[kind].kind and word in verdict.cause.what
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
