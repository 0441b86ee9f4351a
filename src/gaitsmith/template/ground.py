"""The ground ahead: what a map or a camera knows of the next landing, and the slope that the soles have felt.

Heights are above the stance sole; x and y are the heading frame's.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import IntVector, Vector, kernel
from gaitsmith.template.foothold import Forecast, clip, expected_duration
from gaitsmith.template.step import StepState

_FLATTENED = 0.3  # of the period: a sole that has landed lies on the ground
_LEARNT = 0.5  # of a new slope, each step
_STEEPEST = 0.4  # rad


class Ground(NamedTuple):
    """What is known of the ground.

    Attributes:
        known: (1,) ticks for which ``shift``, ``rise`` and ``highest`` are what someone has told; 0 without.
        planned: (2,) where the swing sole would land by the foothold law, relative to the stance sole, m; written by
            every tick of a walk.
        shift: (2,) how much farther it is to land, so that the whole sole has ground below it, m.
        rise: (1,) height of the ground there, m.
        highest: (1,) greatest height of the ground on the way there, m.
        pitch: (1,) slope of the ground as the soles have lain on it, downhill positive, rad.
        flattest: (1,) pitch of the stance sole where it was nearest to level in this step, rad.
    """

    known: IntVector
    planned: Vector
    shift: Vector
    rise: Vector
    highest: Vector
    pitch: Vector
    flattest: Vector


def make_ground() -> Ground:
    """Nothing known."""
    one = [np.zeros(1) for _ in range(4)]
    return Ground(np.zeros(1, dtype=np.int64), np.zeros(2), np.zeros(2), *one)


@kernel
def feel_slope(ground: Ground, step: StepState, sole_pitch: float) -> None:
    """Learn the slope from the stance sole: once a step, from where the sole was nearest to level.

    A sole that tips over its edge is steeper than the ground; therefore the least pitch counts.

    Args:
        ground: its ``pitch`` is learnt.
        step: the step being taken.
        sole_pitch: of the stance sole, toe down positive, rad.
    """
    if step.place[0] == 0.0:
        if step.count[0] > 1:
            felt = clip(ground.flattest[0], _STEEPEST)
            ground.pitch[0] += _LEARNT * (felt - ground.pitch[0])
        ground.flattest[0] = math.inf
    if step.time[0] > _FLATTENED * step.period[0] and abs(sole_pitch) < abs(ground.flattest[0]):
        ground.flattest[0] = sole_pitch


@kernel
def share_of_way(highest: float, lift: float) -> float:
    """Share of the way ahead that a swing sole has gone at αT: one half, none before a climb as high as the lift."""
    return 0.5 * (1.0 - min(max(2.0 * highest - lift, 0.0) / max(lift, 1e-6), 1.0))


@kernel
def plan_landing(
    ground: Ground, step: StepState, forecast: Forecast, omega: float, velocity: Vector, com_offset: Vector, out: Vector
) -> None:
    """Where the swing sole is going to land, and how high: as it was told, else along the slope that was felt.

    The pendulum ``c(t) = c cosh ωt + (ċ/ω) sinh ωt`` over the stance sole says where the hips will be by then.

    Args:
        ground: all but the slope is filled; what was told is believed for ``known`` ticks.
        step: the step being taken.
        forecast: its ``arm`` is read.
        omega: of the pendulum, 1/s.
        velocity: (2,) of the CoM, m/s.
        com_offset: (2,) CoM relative to the hip midpoint, m.
        out: (2,) foothold relative to the hip midpoint, m; shifted as told.
    """
    remaining = omega * max(expected_duration(step) - step.time[0], 0.0)
    carry, grow = math.cosh(remaining), math.sinh(remaining) / omega
    for axis in range(2):
        hips = carry * forecast.arm[axis] + grow * velocity[axis] - com_offset[axis]
        ground.planned[axis] = hips + out[axis]
    if ground.known[0] > 0:
        ground.known[0] -= 1
        for axis in range(2):
            out[axis] += ground.shift[axis]
    else:
        ground.rise[0] = -math.tan(ground.pitch[0]) * ground.planned[0]
        ground.highest[0] = max(ground.rise[0], 0.0)
