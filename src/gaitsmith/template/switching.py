"""Event-triggered switching of support and swing leg (Han 2023, sections 2.2 and 2.3)."""

from __future__ import annotations

from gaitsmith.compiled import Matrix, kernel
from gaitsmith.template.foothold import SETTLING_STEPS, FootholdGains, SpeedGains, finish_step
from gaitsmith.template.step import GaitInputs, StepState
from gaitsmith.whole_body.frames import Frames

_SHORTEST, _LONGEST = 0.8, 1.1  # of the period; a step that a push cut short says nothing about the next


@kernel
def latch(step: StepState, requested: GaitInputs, latched: GaitInputs, foothold: FootholdGains) -> None:
    """Take over the requested gait; the paper updates parameters when the legs switch (section 2.3).

    Going sideways, every other step lands ``2 W - T |v|`` from the stance sole. Where that is nearer than the soles may
    come, W grows: else the bound holds back every other step, and the steps between overshoot to make up for it.

    Args:
        step: the step being taken.
        requested: gait inputs to take over.
        latched: overwritten.
        foothold: gains of the preset.
    """
    for axis in range(2):
        if requested.speed[axis] != latched.speed[axis]:
            step.settling[0] = SETTLING_STEPS
    for k in range(latched.values.shape[0]):
        latched.values[k] = requested.values[k]
    width = latched.width[0]
    least = min(width, 0.5 * foothold.separation) + 0.5 * latched.period[0] * abs(latched.speed[1])
    latched.width[0] = width + foothold.sway * max(least - width, 0.0)
    step.period[0] = latched.period[0]


@kernel
def begin_step(step: StepState, stance: int, swing: int, support_desired: Matrix, frames: Frames) -> None:
    """Start a step with the two rules of section 2.2.

    Args:
        step: the step that ends; overwritten.
        stance: leg that bears the step.
        swing: leg that is lifted; its actual state is where the swing starts from: second rule.
        support_desired: (3, 3) desired state of the new support sole: first rule.
        frames: of this tick.
    """
    step.stance[0] = stance
    step.last_duration[0] = step.time[0]
    step.time[0] = step.place[0] = 0.0
    step.rate[0] = 1.0
    step.count[0] += 1
    for axis in range(3):
        for order in range(3):
            step.support_start[order, axis] = support_desired[order, axis]
        step.swing_start[0, axis] = frames.relative_position[swing, axis]
        step.swing_start[1, axis] = frames.relative_velocity[swing, axis]
    step.swing_pitch_start[0] = frames.sole_pitch[swing]
    step.swing_yaw_start[0] = frames.sole_yaw[swing]


@kernel
def switch_legs(
    step: StepState,
    requested: GaitInputs,
    latched: GaitInputs,
    foothold: FootholdGains,
    gains: SpeedGains,
    landed: int,
    support_desired: Matrix,
    frames: Frames,
) -> None:
    """End the step: the leg that has landed bears the next one.

    Args:
        step: the step that ends.
        requested: gait inputs to take over.
        latched: gait inputs of the step; overwritten.
        foothold: gains of the preset.
        gains: of the preset, those of the speed.
        landed: row of the leg.
        support_desired: (3, 3) desired position, velocity, acceleration (rows) of its sole.
        frames: of this tick.
    """
    leaving = step.stance[0]
    finish_step(step, latched, gains)
    ratio = min(max(step.time[0] / step.period[0], _SHORTEST), _LONGEST)
    step.duration_ratio[0] += 0.5 * (ratio - step.duration_ratio[0])
    at_rest = requested.speed[0] == 0.0 and requested.speed[1] == 0.0
    if not at_rest:
        step.station_kept[0] = 0
    elif step.station_kept[0] == 0 and step.count[0] > 2:
        slow_x = abs(step.last_mean_velocity[0]) < gains.settled_speed
        if slow_x and abs(latched.speed[0]) + abs(latched.speed[1]) == 0.0:
            step.station_kept[0] = 1
    latch(step, requested, latched, foothold)
    begin_step(step, landed, leaving, support_desired, frames)
