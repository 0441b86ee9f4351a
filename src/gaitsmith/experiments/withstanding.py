"""How strong a push a walk withstands, over everything that a random walk draws: one number that gains can raise."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from gaitsmith.experiments.push_grid import momentum_unit
from gaitsmith.experiments.random_walks import random_walk
from gaitsmith.robots import Robot
from gaitsmith.simulation import Scenario, Summary
from gaitsmith.simulation.scenario import make_scenario

STRONGEST = 0.6
"""Of the pushes, over m√(gH)."""
_PUSHED, _AFTER, _STRIDES = 3.0, 6.0, 1.6  # s; watched after the push, s; longest stride in periods, twice
_TIE = 0.01  # of the score: what time upright counts where as many stand


def pushed_walks(seeds: Iterable[int], robot: Robot, fields: Mapping[str, Any]) -> list[Scenario]:
    """Random walks, each pushed once; the strengths divide 0 to :data:`STRONGEST` evenly among the seeds."""
    chosen = list(seeds)
    return [_pushed(seed, (k + 0.5) / len(chosen), robot, fields) for k, seed in enumerate(chosen)]


def _pushed(seed: int, share: float, robot: Robot, fields: Mapping[str, Any]) -> Scenario:
    rng, gait = np.random.default_rng([seed, 0xC5]), robot.card.gait
    size, angle = share * STRONGEST * momentum_unit(robot, gait.height), rng.uniform(0.0, 2.0 * math.pi)
    push = {
        "time": _PUSHED,
        "phase": round(float(rng.uniform(0.0, 0.999)), 3),
        "impulse": [round(size * math.cos(angle), 3), round(size * math.sin(angle), 3), 0.0],
    }
    length = round(_PUSHED + 2.0 * _STRIDES * gait.period + _AFTER, 3)
    drawn = random_walk(seed, robot, fields).model_dump(mode="json", exclude_none=True)
    return make_scenario({**drawn, "duration": length, "pushes": [push]})


def stood(summary: Summary) -> bool:
    """Whether the push came and the robot did not fall."""
    return not summary.fell and bool(summary.pushes) and summary.pushes[0] is not None


def withstood(summaries: Iterable[Summary]) -> float:
    """Mean strength of push that is withstood, over m√(gH): ∫ P(stands | strength) d strength."""
    found = list(summaries)
    return STRONGEST * sum(map(stood, found)) / len(found)


def score(summaries: Iterable[Summary]) -> float:
    """The same, and a little for the time upright, by which candidates are ordered."""
    found = list(summaries)
    upright = [1.0 if stood(summary) else min(summary.duration / (_PUSHED + _AFTER), 1.0) for summary in found]
    return withstood(found) + _TIE * sum(upright) / len(found)
