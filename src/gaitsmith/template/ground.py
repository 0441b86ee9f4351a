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
_SETTLED = 0.1  # of the period: a sole that turns later tips over an edge
_EVEN, _FORGOTTEN = 0.02, 0.3  # of z: a landing so much higher than planned is none on even ground; each step
_ACROSS, _AGREED = 0.3, 2.0  # of a slope across that landings in turn show, once so many say what the one before said
_CLOSE = 0.02  # of z: soles closer to each other show no slope
_AHEAD = 0.25  # of the way: how much farther than half of it a sole has gone at αT before a drop as deep as the lift
_STILL, _TIPPED = 0.03, 0.1  # rad: by how much a sole on good ground turns, and by how much more to bear at its end


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
        across: (1,) slope to the left as the soles' heights have shown it, uphill positive; a tangent.
        steeper: (1,) how much more of it the last landing showed.
        agreed: (1,) how many landings in turn have shown what the one before did.
        flattest: (1,) pitch of the stance sole where it was nearest to level in this step, rad.
        start: (1,) height of the ground that the swing sole has left, m.
        stumble: (1,) how much higher than planned the soles have landed of late, m.
        settled: (1,) pitch of the stance sole once it had landed, rad.
        moved: (2,) where the stance sole would have landed without being moved, from its origin, m.
        pivot: (2,) where the pendulum stands, from the stance sole's origin, m.
    """

    known: IntVector
    planned: Vector
    shift: Vector
    rise: Vector
    highest: Vector
    pitch: Vector
    across: Vector
    steeper: Vector
    agreed: Vector
    flattest: Vector
    start: Vector
    stumble: Vector
    settled: Vector
    moved: Vector
    pivot: Vector


def make_ground() -> Ground:
    """Nothing known."""
    pairs = dict.fromkeys(("planned", "shift", "moved", "pivot"), 2)
    numbers = {name: np.zeros(pairs.get(name, 1)) for name in Ground._fields if name != "known"}
    return Ground(known=np.zeros(1, dtype=np.int64), **numbers)


@kernel
def stand_on(ground: Ground, climbed: float, height: float) -> None:
    """A sole has landed: it bears where it would have been, had it not been moved onto better ground.

    So the pendulum, and with it the balance, does not feel that it was. Whoever has stumbled lifts the feet higher for
    a few steps, by as much as the landing was too high. A slope across the way is learnt from three landings in
    turn that agree: a step up or a stone is higher on one side, or on both, but no slope.

    Args:
        ground: where it landed is still what was planned.
        climbed: height of the landed sole above the one that bore the step, m.
        height: of the CoM above the soles, m.
    """
    ground.start[0] = -climbed
    ground.stumble[0] *= 1.0 - _FORGOTTEN
    higher = climbed - ground.rise[0]
    if higher > _EVEN * height:
        ground.stumble[0] = max(ground.stumble[0], higher)
    beside, steeper = ground.planned[1], 0.0
    if ground.known[0] == 0 and abs(beside) > _CLOSE * height:
        steeper = higher / beside
    if abs(steeper) > _STEEPEST or steeper * ground.steeper[0] <= 0.0:
        ground.agreed[0] = 0.0
    else:
        ground.agreed[0] += 1.0
        if ground.agreed[0] >= _AGREED:
            learnt = _ACROSS * min(abs(steeper), abs(ground.steeper[0]))
            ground.across[0] = clip(ground.across[0] + math.copysign(learnt, steeper), _STEEPEST)
    ground.steeper[0] = steeper
    for axis in range(2):
        ground.moved[axis] = -ground.shift[axis] if ground.known[0] > 0 else 0.0
        ground.pivot[axis] = 0.0


@kernel
def find_pivot(
    ground: Ground, step: StepState, sole_pitch: float, heel: float, toe: float, half_width: float, margin: float
) -> None:
    """Where the pendulum stands on the stance sole: where the sole was wanted, or the toe of one whose heel drops.

    A sole whose heel drops below the slope that was felt lies on an edge below its toe; one that landed on its toe and
    comes to lie on the ground does not. One whose toe drops is left as it is: over an edge that leads down the walk
    goes on, and bearing at the heel would only hasten it.

    Args:
        ground: its ``pivot`` is found.
        step: the step being taken.
        sole_pitch: of the stance sole, toe down positive, rad.
        heel: length of the sole behind its origin, m.
        toe: ahead of it, m.
        half_width: beside it, m.
        margin: to its edges, m.
    """
    if step.time[0] < _SETTLED * step.period[0]:
        ground.settled[0] = sole_pitch
    turned = sole_pitch - min(ground.settled[0], ground.pitch[0])
    forward = ground.moved[0] + 0.5 * (heel + toe) * max(-turned - _STILL, 0.0) / _TIPPED
    ground.pivot[0] = min(max(forward, min(margin - heel, 0.0)), max(toe - margin, 0.0))
    ground.pivot[1] = clip(ground.moved[1], max(half_width - margin, 0.0))


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
def share_of_way(start: float, rise: float, highest: float, lift: float) -> float:
    """Share of the way ahead that a swing sole has gone at αT: one half on level ground.

    None before a climb as high as the lift: first up. More before a drop: the heel is past the edge before it sinks;
    what the sole is lifted higher for the drop alone is no climb.

    Args:
        start: height at which the swing began, m.
        rise: at which it ends, m.
        highest: of the ground on the way, m.
        lift: over it, m.
    """
    drop = max(start - rise, 0.0)
    up = min(max(2.0 * (highest - start) - lift - drop, 0.0) / max(lift, 1e-6), 1.0)
    down = min(drop / max(lift, 1e-6), 1.0)
    return 0.5 * (1.0 - up) + _AHEAD * down


@kernel
def plan_landing(
    ground: Ground, step: StepState, forecast: Forecast, omega: float, velocity: Vector, com_offset: Vector, out: Vector
) -> None:
    """Where the swing sole is going to land, and how high: as it was told, else along the slopes that were felt.

    The pendulum ``c(t) = c cosh ωt + (ċ/ω) sinh ωt`` over the stance sole says where the hips will be by then.

    Args:
        ground: all but the slopes is filled; what was told is believed for ``known`` ticks.
        step: the step being taken.
        forecast: its ``arm`` is read.
        omega: of the pendulum, 1/s.
        velocity: (2,) of the CoM, m/s.
        com_offset: (2,) CoM relative to the hip midpoint, m.
        out: (2,) foothold relative to the hip midpoint, m; shifted as told.

    What is ``planned`` is relative to the stance sole, the pendulum to its pivot.
    """
    remaining = omega * max(expected_duration(step) - step.time[0], 0.0)
    carry, grow = math.cosh(remaining), math.sinh(remaining) / omega
    for axis in range(2):
        hips = carry * forecast.arm[axis] + grow * velocity[axis] - com_offset[axis]
        ground.planned[axis] = ground.pivot[axis] + hips + out[axis]
    if ground.known[0] > 0:
        ground.known[0] -= 1
        for axis in range(2):
            out[axis] += ground.shift[axis]
    else:
        ground.rise[0] = ground.across[0] * ground.planned[1] - math.tan(ground.pitch[0]) * ground.planned[0]
        ground.highest[0] = max(ground.rise[0], 0.0) + ground.stumble[0]
