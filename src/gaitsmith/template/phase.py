"""When to stand, shift the weight, step, and switch legs: the event-triggered side of the gait template."""

from __future__ import annotations

import math
from typing import NamedTuple

from gaitsmith.compiled import Vector, kernel
from gaitsmith.template.balance import divergent_reference
from gaitsmith.template.foothold import FootholdGains, SpeedGains, pendulum_frequency
from gaitsmith.template.step import SHIFT, STAND, WALK, GaitInputs, StepState
from gaitsmith.template.switching import SETTLING_STEPS, begin_step, latch, switch_legs
from gaitsmith.template.touchdown import FORCED, NONE, TouchdownRule, detect_touchdown
from gaitsmith.whole_body.frames import Frames, to_heading
from gaitsmith.whole_body.legs import Legs

_SHIFTED = 0.15  # of the half width: how near ξ must come to what the first step starts from


class RestGains(NamedTuple):
    """When a walk begins and ends.

    Attributes:
        weight_shift: 1 to shift the weight over the first stance foot before lifting the other, 0 to lift at once.
        longest_shift: s after which the first step is taken anyway.
        entry_speed: largest CoM speed at which a walk may end in standing, m/s.
        straddle: forward distance of the soles up to which it may, m.
        height_rate: how fast the hips follow a new height while standing, m/s.
    """

    weight_shift: float
    longest_shift: float
    entry_speed: float
    straddle: float
    height_rate: float


@kernel
def com_over_sole(frames: Frames, com: Vector, leg: int, out: Vector) -> None:
    """CoM (world, m) relative to a sole, heading frame, into ``out`` (3,)."""
    place = frames.sole_position[leg]
    to_heading(frames, com[0] - place[0], com[1] - place[1], out)
    out[2] = com[2] - place[2]


@kernel
def _first_stance(legs: Legs, speed: float) -> int:
    """Leg that bears the first step: the swing goes to the side that the command points to, else to the left."""
    towards = -1.0 if speed < 0.0 else 1.0
    stance = 0
    for leg in range(legs.side.shape[0]):
        if legs.side[leg] != towards:
            stance = leg
    return stance


@kernel
def _leave_rest(
    step: StepState, requested: GaitInputs, latched: GaitInputs, legs: Legs, frames: Frames, com: Vector
) -> None:
    """Take the first step."""
    latch(step, requested, latched)
    stance = step.stance[0]
    desired = step.foot_desired[stance]
    for axis in range(3):
        desired[0, axis] = frames.relative_position[stance, axis]
        desired[1, axis] = 0.0
        desired[2, axis] = 0.0
    step.station_kept[0] = 0
    if requested.speed[0] == 0.0 and requested.speed[1] == 0.0:
        step.station_kept[0] = 1
        step.station[0] = com[0]
        step.station[1] = com[1]
    begin_step(step, stance, legs.other[stance], desired[:, 2], frames)
    step.last_duration[0] = 0.0
    step.settling[0] = SETTLING_STEPS
    step.mode[0] = WALK


@kernel
def _shifted(
    step: StepState,
    latched: GaitInputs,
    foothold: FootholdGains,
    legs: Legs,
    frames: Frames,
    com: Vector,
    arm: Vector,
    wanted: Vector,
) -> bool:
    """Whether the divergent component has come to what the first step starts from."""
    stance = step.stance[0]
    com_over_sole(frames, com, stance, arm)
    divergent_reference(step, latched, foothold, arm[2], legs.side[legs.other[stance]], 0.0, wanted)
    xi = arm[1] + frames.com_velocity[1] / pendulum_frequency(foothold, arm[2])
    return bool(abs(xi - wanted[1]) < _SHIFTED * latched.width[0])


@kernel
def _may_rest(step: StepState, frames: Frames, rest: RestGains) -> bool:
    """Whether all soles are side by side and the CoM is slow enough to be caught without a step."""
    first = last = frames.relative_position[0, 0]
    for leg in range(frames.relative_position.shape[0]):
        first, last = min(first, frames.relative_position[leg, 0]), max(last, frames.relative_position[leg, 0])
    slow = abs(step.last_mean_velocity[0]) < rest.entry_speed and abs(frames.com_velocity[0]) < rest.entry_speed
    return bool(slow and last - first < rest.straddle)


@kernel
def _rest(step: StepState, latched: GaitInputs, rest: RestGains, dt: float) -> None:
    """Follow the commanded height while standing."""
    step.station_kept[0] = 0
    limit = rest.height_rate * dt
    step.standing_height[0] += min(max(latched.height[0] - step.standing_height[0], -limit), limit)


@kernel
def within_turn(angle: float) -> float:
    """The same angle between -π and π, rad."""
    return angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi) + 0.5)


@kernel
def turn_heading(step: StepState, latched: GaitInputs, frames: Frames, dt: float) -> None:
    """Turn the wanted heading by the commanded rate while walking; from standing it starts as it is."""
    if step.heading_set[0] == 0:
        step.heading[0] = frames.yaw[0]
        step.heading_set[0] = 1
    if step.mode[0] == WALK:
        step.heading[0] += latched.yaw_rate[0] * dt
    step.heading[0] = within_turn(step.heading[0])


@kernel
def advance_phase(
    step: StepState,
    requested: GaitInputs,
    latched: GaitInputs,
    foothold: FootholdGains,
    speed: SpeedGains,
    rule: TouchdownRule,
    rest: RestGains,
    legs: Legs,
    frames: Frames,
    com: Vector,
    sole_force: Vector,
    arm: Vector,
    wanted: Vector,
    dt: float,
) -> bool:
    """Advance the step's clock and switch legs on touchdown; ``com`` is the CoM in the world, m.

    ``arm`` (3,) and ``wanted`` (2,) are scratch.

    Returns:
        True if the swing leg changed, so that its references must restart from the measured joints.
    """
    if step.mode[0] == STAND:
        latch(step, requested, latched)
        if step.walk_requested[0] == 0:
            _rest(step, latched, rest, dt)
            return False
        step.stance[0] = _first_stance(legs, requested.speed[1])
        step.mode[0] = SHIFT
        step.time[0] = 0.0
    if step.mode[0] == SHIFT:
        step.time[0] += dt
        if step.walk_requested[0] == 0:
            step.mode[0] = STAND
            return False
        ready = rest.weight_shift == 0.0 or step.time[0] > rest.longest_shift
        if not ready:
            latch(step, requested, latched)
            ready = _shifted(step, latched, foothold, legs, frames, com, arm, wanted)
        if ready:
            _leave_rest(step, requested, latched, legs, frames, com)
        return bool(ready)
    step.time[0] += dt
    stance = step.stance[0]
    swing = legs.other[stance]
    event = detect_touchdown(rule, step.time[0], step.period[0], sole_force[swing])
    if event == NONE:
        return False
    if event == FORCED:
        step.forced[0] += 1
    switch_legs(step, requested, latched, speed, swing, step.foot_desired[swing][:, 2], frames)
    if step.walk_requested[0] == 0 and event != FORCED and _may_rest(step, frames, rest):
        step.mode[0] = STAND
        step.count[0] -= 1
        height = 0.0
        for leg in range(legs.side.shape[0]):
            height -= frames.relative_position[leg, 2] / legs.side.shape[0]
        step.standing_height[0] = height
        return False
    return True
