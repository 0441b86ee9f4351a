"""Three physical tests of a robot: both soles carry it, it stands still, it walks slowly."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gaitsmith.adoption.holding import why_weak
from gaitsmith.errors import BadInput
from gaitsmith.experiments.result import Progress, silent
from gaitsmith.kinematics.posture import standing_posture
from gaitsmith.robots import Robot
from gaitsmith.robots.footing import below_soles, check_soles
from gaitsmith.simulation import Scenario, Simulation, Summary

STANDING = 8.0  # s
WALKING = 20.0  # s
SPEED = 0.1  # m/s
TURNED = 2.0  # degrees of heading while standing
_SHARE = 0.25  # of the weight that each sole has to carry
_OFF = 0.02  # m/s of error in the mean speed
_HEADING = 10.0  # degrees of heading over the walk
_SHOWN = 4  # bodies
_SETTLED = 0.25  # of the standing time, at the end of which loads are measured


@dataclass(frozen=True)
class Test:
    """One test: whether it was passed, the figure that decided, and it in words."""

    name: str
    ok: bool
    figure: float
    words: str

    def line(self) -> str:
        """For people."""
        return f"{self.name}: {'ok' if self.ok else 'FAILED'}: {self.words}"

    def document(self) -> dict[str, Any]:
        """As plain data."""
        return {"ok": self.ok, "figure": self.figure, "words": self.words}


@dataclass(frozen=True)
class Doctor:
    """The three tests' outcome, and the walk's summary."""

    soles: Test
    standing: Test
    walk: Test
    summary: Summary

    @property
    def tests(self) -> tuple[Test, Test, Test]:
        """In order."""
        return self.soles, self.standing, self.walk

    @property
    def failed(self) -> Test | None:
        """The first test that was not passed."""
        return next((test for test in self.tests if not test.ok), None)


def examine(robot: Robot, name: str, *, progress: Progress = silent) -> Doctor:
    """Run the tests, one after the other.

    Args:
        name: under which scenarios load it again.

    Raises:
        BadInput: the robot cannot stand in its card's posture.
    """
    progress(0, 3, "standing")
    soles, standing = stand(robot, name)
    progress(2, 3, "walking")
    summary = _run(robot, walk_scenario(name))
    return Doctor(soles, standing, walked(summary), summary)


def stand(robot: Robot, name: str) -> tuple[Test, Test]:
    """Both soles carry the weight, and the heading stays, over 8 s on both feet."""
    scenario = Scenario(robot=name, speed=(0.0, 0.0), duration=STANDING, rest_before=STANDING)
    simulation = Simulation(scenario, robot=robot, record=True)
    episode = simulation.run()
    if episode.interrupted:
        raise KeyboardInterrupt
    log, summary = episode.log, episode.summary
    weight = robot.mass * float(np.linalg.norm(robot.model.opt.gravity))
    assert log is not None
    settled = log.column("time") > (1.0 - _SETTLED) * simulation.time
    loads = [float(np.mean(log.column(f"sole_force.{leg.name}")[settled])) / weight for leg in robot.legs]
    share = min(loads) if loads else 0.0
    words = " and ".join(f"{leg.name} {load:.0%}" for leg, load in zip(robot.legs, loads, strict=True))
    soles = Test("soles", share >= _SHARE, share, f"the soles carry {words} of the weight")
    gait = robot.card.gait
    low = below_soles(robot, standing_posture(robot, gait.height, gait.width))
    if low:
        words = " and ".join(f"{body} ({_length(depth)})" for body, depth in list(low.items())[:_SHOWN])
        soles = Test("soles", False, share, f"{words} would be below the ground on which the soles stand")
    try:
        check_soles(robot)
    except BadInput as error:
        soles = Test("soles", False, share, str(error))
    heading = max(map(abs, summary.heading_deg))
    words = f"stood {summary.duration:g} s, heading within {heading:.2g}°"
    if summary.fall is not None:
        words = f"fell after {summary.fall.time:.2f} s of standing: {why_weak(robot) or summary.fall.reason}"
    return soles, Test("standing", not summary.fell and heading <= TURNED, heading, words)


def _length(metres: float) -> str:
    return f"{1e3 * metres:.2g} mm" if metres < 0.01 else f"{1e2 * metres:.2g} cm"


def in_reach(robot: Robot, height: float, width: float) -> bool:
    """Whether the legs stand at a height with the soles that far apart."""
    try:
        standing_posture(robot, height, width)
    except BadInput:
        return False
    return True


def walk_scenario(name: str, **inputs: Any) -> Scenario:
    """The slow walk that is tested; inputs override it."""
    return Scenario(**{"robot": name, "speed": (SPEED, 0.0), "duration": WALKING, "rest_before": 1.0, **inputs})


def walked(summary: Summary) -> Test:
    """Whether a walk at the test's speed got where it should."""
    if summary.fall is not None:
        words = f"fell after {summary.fall.time:.2f} s: {summary.fall.reason}"
        return Test("walk", False, summary.fall.time, words)
    error, heading = errors(summary)
    mean = [stage for stage in summary.stages if not stage.rest][-1].vx_mean
    words = f"walked {summary.duration:g} s at {mean:.3f} m/s, heading within {heading:.2g}°"
    missed = [f"a mean speed {error:.3f} m/s off, more than {_OFF:g}"] if error > _OFF else []
    missed += [f"heading off by more than {_HEADING:g}°"] if heading > _HEADING else []
    return Test("walk", not missed, mean, " but with ".join([words, " and ".join(missed)] if missed else [words]))


def errors(summary: Summary) -> tuple[float, float]:
    """Worst error of a mean speed, m/s, and of the heading, degrees, over the walking stages."""
    walking = [stage for stage in summary.stages if not stage.rest]
    off = [max(abs(stage.vx_error), abs(stage.vy_error)) for stage in walking]
    return max(off, default=np.inf), max((abs(stage.heading_drift_deg) for stage in walking), default=np.inf)


def _run(robot: Robot, scenario: Scenario) -> Summary:
    summary = Simulation(scenario, robot=robot, record=False).run().summary
    if summary.interrupted:
        raise KeyboardInterrupt
    return summary
