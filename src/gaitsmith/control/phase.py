"""When to stand, step, and switch legs: the event-triggered side of the gait template."""

from __future__ import annotations

from gaitsmith.compiled import Vector, kernel
from gaitsmith.control.state import ControlState, TickGains
from gaitsmith.control.touchdown import FORCED, NONE, TouchdownRule, detect_touchdown
from gaitsmith.estimation.measurement import Measurement
from gaitsmith.template.foothold import FootholdGains
from gaitsmith.template.step import LEFT, RIGHT, STAND, WALK, Gait, StepState
from gaitsmith.template.switching import SETTLING_STEPS, begin_step, latch, switch_legs
from gaitsmith.whole_body.frames import Frames

_HEIGHT_RATE = 0.15  # m/s, how fast the hips follow a new height while standing
_LONGEST_STRADDLE = 0.06  # m, forward distance of the soles at which a walk may end in standing


@kernel
def _leave_rest(
    step: StepState, requested: Gait, latched: Gait, frames: Frames, com: Vector, control: ControlState
) -> None:
    """Take the first step, towards the side that the command points to."""
    latch(step, requested, latched)
    stance = LEFT if requested.speed[1] < 0.0 else RIGHT
    swing = RIGHT if stance == LEFT else LEFT
    desired = control.foot_desired[3 * stance : 3 * stance + 3]
    for axis in range(3):
        desired[0, axis] = frames.relative[stance, 0, axis]
        desired[1, axis] = 0.0
        desired[2, axis] = 0.0
    step.station_kept[0] = 0
    if requested.speed[0] == 0.0 and requested.speed[1] == 0.0:
        step.station_kept[0] = 1
        step.station[0] = com[0]
        step.station[1] = com[1]
    begin_step(step, stance, desired, frames.relative[swing], frames.sole_pitch[swing])
    step.last_duration[0] = 0.0
    step.settling[0] = SETTLING_STEPS
    step.mode[0] = WALK


@kernel
def _may_rest(step: StepState, frames: Frames, gains: TickGains) -> bool:
    """Whether both soles are side by side and the CoM is slow enough to be caught without a step."""
    straddle = abs(frames.relative[0, 0, 0] - frames.relative[1, 0, 0])
    speed = abs(frames.com_velocity[0])
    slow = abs(step.last_mean_velocity[0]) < gains.entry_speed and speed < gains.entry_speed
    return bool(slow and straddle < _LONGEST_STRADDLE)


@kernel
def _stand(step: StepState, requested: Gait, latched: Gait, control: ControlState, gains: TickGains) -> None:
    """Follow the commanded height while standing."""
    latch(step, requested, latched)
    step.station_kept[0] = 0
    change = latched.height[0] - control.standing_height[0]
    limit = _HEIGHT_RATE * gains.dt
    control.standing_height[0] += min(max(change, -limit), limit)


@kernel
def advance_phase(
    step: StepState,
    requested: Gait,
    latched: Gait,
    foothold: FootholdGains,
    rule: TouchdownRule,
    gains: TickGains,
    frames: Frames,
    com: Vector,
    control: ControlState,
    measurement: Measurement,
) -> bool:
    """Advance the step's clock and switch legs on touchdown; ``com`` is the CoM in the world, m.

    Returns:
        True if the swing leg changed, so that its references must restart from the measured joints.
    """
    if step.mode[0] == STAND:
        if step.walk_requested[0] == 1:
            _leave_rest(step, requested, latched, frames, com, control)
            return True
        _stand(step, requested, latched, control, gains)
        return False
    step.time[0] += gains.dt
    stance = step.stance[0]
    swing = RIGHT if stance == LEFT else LEFT
    event = detect_touchdown(rule, step.time[0], latched.period[0], measurement.sole_force[swing])
    if event == NONE:
        return False
    if event == FORCED:
        control.counts[2] += 1
    landed = control.foot_desired[3 * swing : 3 * swing + 3]
    switch_legs(step, requested, latched, foothold, landed, frames.relative[stance], frames.sole_pitch[stance])
    if step.walk_requested[0] == 0 and event != FORCED and _may_rest(step, frames, gains):
        step.mode[0] = STAND
        step.count[0] -= 1
        control.standing_height[0] = -0.5 * (frames.relative[0, 0, 2] + frames.relative[1, 0, 2])
        return False
    return True
