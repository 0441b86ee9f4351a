"""Random walks: whatever may differ between model and robot is drawn at once; how many stand, and how surely."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import betaincinv

from gaitsmith.experiments.episodes import run_all
from gaitsmith.experiments.push_grid import momentum_unit
from gaitsmith.experiments.result import Progress
from gaitsmith.experiments.store import Store
from gaitsmith.robots import Robot
from gaitsmith.simulation import Scenario, Summary
from gaitsmith.simulation.scenario import make_scenario

CONFIDENCE = 0.95
DRAWN = (
    "estimated state; every mass × 0.9 to 1.1, the torso's centre of mass off by up to 0.043 H forward and aside; "
    "friction 0.4 to 1; torques late by up to 0.03 √(H/g); boxes up to 0.057 H; a speed of −0.076 to 0.19 √(gH); "
    "five pushes of up to 0.096 m√(gH) in any direction; 20 s"
)
"""What differs from one to the next."""

_SPEED, _PUSH, _SHIFT, _BOXES, _DELAY = (-0.076, 0.19), 0.096, 0.043, 0.057, 0.03
_LENGTH, _PUSHES, _FIRST, _LAST = 20.0, 5, 3.0, 17.5  # s; how many, and when
_LOOKS = (8, 4, 2, 1)  # shares of all runs after which it may stop


def interval(stood: int, of: int, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """Lowest and highest share that is compatible with ``stood`` out of ``of`` (Clopper and Pearson 1934)."""
    tail = 0.5 * (1.0 - confidence)
    low = float(betaincinv(stood, of - stood + 1, tail)) if stood else 0.0
    high = float(betaincinv(stood + 1, of - stood, 1.0 - tail)) if stood < of else 1.0
    return low, high


def random_walk(seed: int, robot: Robot, fields: Mapping[str, Any]) -> Scenario:
    """The walk of a seed; ``fields`` are put over what is drawn."""
    rng, gait = np.random.default_rng([seed, 0xC4]), robot.card.gait
    gravity = -float(robot.model.opt.gravity[2])
    root, limits = math.sqrt(gravity * gait.height), robot.card.gait_limits.speed_x
    speed = min(max(rng.uniform(*_SPEED) * root, limits[0]), limits[1])
    delay = rng.uniform(0.0, _DELAY * math.sqrt(gait.height / gravity))
    mass, friction = rng.uniform(0.9, 1.1), rng.uniform(0.4, 1.0)
    shift = rng.uniform(-_SHIFT * gait.height, _SHIFT * gait.height, 2)
    pushes = []
    for time in np.sort(rng.uniform(_FIRST, _LAST, _PUSHES)):
        size, angle = rng.uniform(0.0, _PUSH * momentum_unit(robot, gait.height)), rng.uniform(0.0, 2.0 * math.pi)
        impulse = [round(size * math.cos(angle), 3), round(size * math.sin(angle), 3), 0.0]
        pushes.append({"time": round(float(time), 3), "impulse": impulse})
    drawn = {
        "state": "estimated",
        "seed": seed,
        "duration": _LENGTH,
        "speed": [round(speed, 4), 0.0],
        "terrain": f"boxes:{_BOXES * gait.height:.4f}",
        "mass_factor": round(mass, 4),
        "torso_shift": [round(float(shift[0]), 4), round(float(shift[1]), 4), 0.0],
        "friction": round(friction, 3),
        "torque_delay": round(delay, 4),
        "pushes": pushes,
    }
    return make_scenario({**drawn, **fields})


@dataclass(frozen=True)
class Walks:
    """Random walks that were run, by seed, in order.

    Attributes:
        interval: of the share that stands; it holds at whichever look the walks were stopped.
        interrupted: whether Ctrl-C left some out.
    """

    found: dict[int, Summary]
    interval: tuple[float, float]
    interrupted: bool

    @property
    def stood(self) -> int:
        """How many did not fall."""
        return sum(not summary.fell for summary in self.found.values())

    def document(self) -> dict[str, Any]:
        """As plain data."""
        falls = [(seed, summary.fall) for seed, summary in self.found.items() if summary.fall is not None]
        return {
            "runs": len(self.found),
            "survived": self.stood,
            "interval": list(self.interval),
            "falls": [
                {"seed": seed, "cause": fall.cause.what if fall.cause is not None else fall.reason}
                for seed, fall in falls
            ],
        }


def looks(runs: int, target: float | None) -> list[int]:
    """After how many walks it may stop: always after all, with a target earlier too."""
    return [runs] if target is None else sorted({math.ceil(runs / share) for share in _LOOKS})


def run_walks(
    robot: Robot,
    store: Store,
    *,
    fields: Mapping[str, Any],
    runs: int,
    first: int,
    target: float | None,
    jobs: int,
    address: str,
    progress: Progress,
) -> Walks:
    """Run walks until there are enough.

    With a target they stop at the first look at which the interval lies above or below it. Each look takes its share of
    the error (Bonferroni), so that the interval holds with 95 % whichever look is the last.

    Args:
        fields: of the scenario, put over what is drawn.
        runs: at most.
        first: seed.
        target: share that is to be decided upon; None to run all.
        address: of a Ray cluster instead; empty for none.
    """
    planned = looks(runs, target)
    confidence = 1.0 - (1.0 - CONFIDENCE) / len(planned)
    for count in planned:
        scenarios = {seed: random_walk(seed, robot, fields) for seed in range(first, first + count)}
        episodes = run_all(
            scenarios.values(), robot, store, jobs=jobs, address=address, progress=progress, what="walking at random"
        )
        found = {}
        for seed, scenario in scenarios.items():
            summary = episodes.found.get(scenario)
            if summary is None:  # falls are over sooner: what was finished beyond the first gap is no fair sample
                break
            found[seed] = summary
        stood = sum(not summary.fell for summary in found.values())
        low, high = interval(stood, len(found), confidence) if found else (0.0, 1.0)
        if episodes.interrupted or (target is not None and (low >= target or high < target)):
            break
    return Walks(found, (low, high), episodes.interrupted)
