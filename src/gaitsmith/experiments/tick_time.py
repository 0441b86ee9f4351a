"""``gaitsmith bench tick``: how long a tick takes in closed loop, what it allocates, and how fast the loop runs."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from pathlib import Path
from time import perf_counter
from typing import Any

import gaitsmith
from gaitsmith.errors import BadInput, GaitsmithError
from gaitsmith.experiments.limits import QUANTITIES, Finding, Limit, shown
from gaitsmith.experiments.options import TickOptions
from gaitsmith.experiments.push_grid import momentum_unit
from gaitsmith.experiments.result import Progress, Result, silent
from gaitsmith.robots import Robot, load_robot
from gaitsmith.simulation import Scenario, Simulation, Summary
from gaitsmith.simulation.scenario import make_scenario

ALLOCATION_TICKS = 10_000
_ALLOCATION_TIME = ALLOCATION_TICKS * 1e-3 + 1.0  # s
_SPEEDS = (0.0, 0.08, 0.19, 0.11, 0.0, -0.08, 0.0)  # of √(gH), in equal parts of the run
_PUSH = 0.14  # of mass times √(gH)
_PUSH_EVERY, _TURN = 2.0, 135.0  # s and degrees from one push to the next
_START = (
    "import sys, gaitsmith;"
    "from gaitsmith.simulation import Simulation;"
    "Simulation(gaitsmith.Scenario(robot=sys.argv[1], preset=sys.argv[2])).step()"
)
_LIMITS = {
    "tick_median": Limit("tick_median", 30.0),
    "tick_p99": Limit("tick_p99", 100.0),
    "qp_fallbacks": Limit("qp_fallbacks", 0.01),
    "allocations": Limit("allocations", 0),
    "start_up": Limit("start_up", 5.0),
    "realtime_factor": Limit("realtime_factor", 8.0),
}


def measure_tick(options: TickOptions, progress: Progress = silent) -> Result:
    """Measure the control tick in closed loop, without and with pushes; the times are those of this machine now.

    Raises:
        BadInput: the robot or the preset cannot be used.
    """
    robot, preset, duration = options.robot, options.preset, options.duration
    loaded = load_robot(robot)
    if preset not in loaded.card.presets:
        raise BadInput("--preset", preset, "one of " + ", ".join(sorted(loaded.card.presets)))
    walk = _walk(loaded, robot, preset, duration)
    findings: list[tuple[str, Finding]] = []
    document: dict[str, Any] = {"robot": loaded.card.name, "preset": preset, "duration": duration}
    notes: list[str] = []
    interrupted = False
    try:
        steps = ("walking", "walking, pushed", "allocations", "start")
        for done, what in enumerate(steps):
            progress(done, len(steps), what)
            if what == "allocations":
                count = count_allocations(Simulation(_walk(loaded, robot, preset, _ALLOCATION_TIME), robot=loaded))
                findings.append((f"{ALLOCATION_TICKS} ticks of the closed loop", _finding("allocations", count)))
            elif what == "start":
                findings.append(("compiled before", _finding("start_up", start_up(robot, preset))))
            else:
                scenario = walk if what == "walking" else _pushed(walk, loaded)
                episode = Simulation(scenario, robot=loaded).run()
                findings += _closed_loop(what, episode.summary)
                document[what.replace(", ", "_")] = episode.summary.model_dump(mode="json", exclude={"stages"})
                if episode.summary.fall is not None:
                    fall = episode.summary.fall
                    notes.append(f"{what}: fell at {fall.time:.2f} s, measured until then; {fall.reason}")
                if episode.interrupted:
                    raise KeyboardInterrupt
        progress(len(steps), len(steps), "done")
    except KeyboardInterrupt:
        interrupted = True
    document["findings"] = [{"when": when, **finding.document()} for when, finding in findings]
    document["interrupted"] = interrupted
    rows = []
    for when, finding in findings:
        label = QUANTITIES[finding.quantity].label
        target = finding.limit.target().removeprefix(label).strip() if finding.limit else ""
        rows.append((f"{when}: {label}", target, shown(finding.quantity, finding.value), finding.verdict()))
    notes.append("wall times are of this machine as busy as it is; a free core is needed to judge them")
    return Result(document, ("what", "target", "measured", "verdict"), tuple(rows), tuple(notes), interrupted)


def _finding(quantity: str, value: float) -> Finding:
    return Finding(quantity, value, _LIMITS.get(quantity))


def _walk(loaded: Robot, robot: str, preset: str, duration: float) -> Scenario:
    """A walk through speeds that the card allows."""
    low, high = loaded.card.gait_limits.speed_x
    each = (duration - 1.0) / len(_SPEEDS)
    unit = momentum_unit(loaded, loaded.card.gait.height) / loaded.mass
    speeds = [round(min(max(unit * speed, low), high), 3) for speed in _SPEEDS]
    changes = [{"time": round(1.0 + k * each, 3), "speed": [speed, 0.0]} for k, speed in enumerate(speeds) if k]
    fields = {"robot": robot, "preset": preset, "duration": duration, "speed": [speeds[0], 0.0]}
    return make_scenario({**fields, "changes": changes})


def _pushed(walk: Scenario, loaded: Robot) -> Scenario:
    """The same walk with pushes from all sides."""
    pushes, size = [], _PUSH * momentum_unit(loaded, loaded.card.gait.height)
    for k in range(int((walk.duration - 3.0) / _PUSH_EVERY)):
        angle = math.radians(_TURN * k)
        impulse = [round(size * math.cos(angle), 6), round(size * math.sin(angle), 6), 0.0]
        pushes.append({"time": 3.0 + _PUSH_EVERY * k, "impulse": impulse})
    return make_scenario({**walk.model_dump(mode="json", exclude_none=True), "pushes": pushes})


def _closed_loop(when: str, summary: Summary) -> list[tuple[str, Finding]]:
    """What one run says about tick, QP and loop."""
    tick = summary.tick_us
    values = {
        **{f"tick_{name}": getattr(tick, name) for name in ("median", "p99", "max")},
        "overruns": float(tick.overruns),
        "qp_fallbacks": summary.qp.fallbacks / max(summary.qp.solves, 1),
        "realtime_factor": summary.realtime_factor,
    }
    return [(when, _finding(quantity, value)) for quantity, value in values.items()]


def count_allocations(simulation: Simulation, ticks: int = ALLOCATION_TICKS) -> int:
    """Allocations and releases that numba's runtime counts over ``ticks`` ticks of the recorded closed loop.

    Raises:
        GaitsmithError: the robot fell before the ticks were done.
    """
    from numba.core.runtime import _nrt_python, rtsys

    _nrt_python.memsys_enable_stats()  # off by default: numba counts for tests only
    simulation.step()
    before = rtsys.get_allocation_stats()
    for _ in range(ticks):
        if not simulation.step():
            raise GaitsmithError("the robot fell before allocations could be counted")
    after = rtsys.get_allocation_stats()
    return sum(abs(late - early) for late, early in zip(after, before, strict=True))


def start_up(robot: str, preset: str) -> float:
    """Wall time from starting a Python process to its first tick in closed loop, kernels compiled before; s.

    Raises:
        GaitsmithError: the process failed.
    """
    root = str(Path(gaitsmith.__file__).resolve().parents[1])
    paths = [root, *filter(None, [os.environ.get("PYTHONPATH")])]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
    began = perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", _START, robot, preset], env=environment, capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise GaitsmithError(f"a fresh process failed: {done.stderr.strip().splitlines()[-1:]}")
    return perf_counter() - began
