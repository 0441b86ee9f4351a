"""A seeded search for a gait and gains with which a robot walks, in factors of what its size suggests."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from gaitsmith.adoption.trials import WALKING, errors, in_reach, walk_scenario, walked
from gaitsmith.control.defaults import default_parameters, robot_scale
from gaitsmith.experiments.episodes import run_all
from gaitsmith.experiments.result import Progress
from gaitsmith.experiments.store import Store
from gaitsmith.robots import Robot
from gaitsmith.simulation import Summary

ROUND = 8
"""Candidates tried before the best one is looked at."""
NEAR = 0.35
"""How far later candidates are from the best one, of a factor's range."""
_GAIT = {"period": (0.7, 1.3), "height": (0.9, 1.03), "lift": (0.7, 1.8), "width": (0.8, 1.4)}
GAINS = {
    "cop.gain": (0.4, 1.5),
    "attitude": (0.5, 2.0),
    "tracking": (0.6, 2.5),
    "weights.swing_foot": (0.3, 3.0),
    "weights.swing_joint": (0.5, 3.0),
    "speed.integral_gain": (0.2, 1.0),
}


@dataclass(frozen=True)
class Candidate:
    """Factors on the default gait and gains, by name."""

    factors: dict[str, float]

    def gait(self, robot: Robot) -> dict[str, float]:
        """Gait inputs, within the card's limits."""
        card = robot.card
        found = {}
        for name in _GAIT:
            low, high = getattr(card.gait_limits, name)
            found[name] = _rounded(min(max(getattr(card.gait, name) * self.factors[name], low), high), low, high)
        if not in_reach(robot, found["height"], found["width"]):
            found |= {"height": card.gait.height, "width": card.gait.width}
        return found

    def gains(self, defaults: dict[str, Any]) -> dict[str, dict[str, Any]]:
        """The presets' groups with what differs from the defaults."""
        found: dict[str, dict[str, Any]] = {}
        for name in self.factors:
            if name in _GAIT:
                continue
            group, _, entry = name.partition(".")
            for key in [entry] if entry else defaults[group]:
                factor = self.factors[name]
                factor = math.sqrt(factor) if key.endswith("damping") else factor
                value = defaults[group][key]
                scaled = [_digits(v * factor) for v in value] if isinstance(value, tuple) else _digits(value * factor)
                found.setdefault(group, {})[key] = scaled
        return found


@dataclass(frozen=True)
class Found:
    """Outcome of a search: the best candidate, its walk, how many were tried, and for how long, s."""

    gait: dict[str, float]
    gains: dict[str, dict[str, Any]]
    summary: Summary
    rollouts: int
    seconds: float
    walks: bool


Stage = Callable[[dict[str, dict[str, dict[str, Any]]]], tuple[str, Robot]]
"""Loads the robot with some presets, by name; returns under which name it is loaded again, and the robot."""


def search(
    robot: Robot, stage: Stage, store: Store, most: int, seed: int, jobs: int, progress: Progress
) -> Found | None:
    """Try candidates in rounds until one walks; half of those after the first round lie near the best one.

    Args:
        robot: whose card's gait and default gains the factors apply to.
        stage: see :data:`Stage`.
        store: of finished runs.
        most: candidates at most.

    Raises:
        KeyboardInterrupt: Ctrl-C.
    """
    random = np.random.default_rng(seed)
    scale = robot_scale(robot)
    defaults = default_parameters(scale)
    best: tuple[float, Candidate, Summary] | None = None
    tried, began = 0, perf_counter()
    while tried < most:
        made = [
            drawn(random, _GAIT | GAINS, best[1] if best and k % 2 else None) for k in range(min(ROUND, most - tried))
        ]
        named = {f"search_{tried + k}": candidate for k, candidate in enumerate(made)}
        path, staged = stage({name: candidate.gains(defaults) for name, candidate in named.items()})
        runs = {
            walk_scenario(path, preset=name, **candidate.gait(robot)): candidate for name, candidate in named.items()
        }
        what = f"searching gains, {tried} tried"
        episodes = run_all(list(runs), staged, store, jobs=jobs, progress=progress, what=what)
        if episodes.interrupted:
            raise KeyboardInterrupt
        tried += len(made)
        for scenario, summary in episodes.found.items():
            value = score(summary)
            if best is None or value > best[0]:
                best = (value, runs[scenario], summary)
        if best and walked(best[2]).ok:
            break
    if best is None:
        return None
    _, candidate, summary = best
    return Found(
        candidate.gait(robot),
        candidate.gains(defaults),
        summary,
        tried,
        round(perf_counter() - began, 1),
        walked(summary).ok,
    )


def score(summary: Summary) -> float:
    """How good a walk was: share of its time upright; if all of it, plus 1, less errors of speed and heading."""
    if summary.fall is not None:
        return summary.fall.time / WALKING
    off, heading = errors(summary)
    return 2.0 - min(0.5, 5.0 * off) - min(0.5, heading / 90.0)


def drawn(
    random: np.random.Generator,
    ranges: Mapping[str, tuple[float, float]],
    near: Candidate | None = None,
    width: float = NEAR,
) -> Candidate:
    """A candidate, anywhere in the ranges or near another one; factors are uniform in their logarithms."""
    factors = {}
    for name, (low, high) in ranges.items():
        span, middle = math.log(high / low), random.uniform()
        at = math.log(low) + span * middle
        if near is not None:
            at = math.log(near.factors[name]) + width * span * (middle - 0.5)
        factors[name] = math.exp(min(max(at, math.log(low)), math.log(high)))
    return Candidate(factors)


def _digits(value: float) -> float:
    return float(f"{value:.4g}")


def _rounded(value: float, low: float, high: float) -> float:
    return min(max(_digits(value), low), high)
