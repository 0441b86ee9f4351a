"""Event-triggered switching of support and swing leg (Han 2023, sections 2.2 and 2.3)."""

from __future__ import annotations

from gaitsmith.compiled import Matrix, kernel
from gaitsmith.template.foothold import FootholdGains, finish_step
from gaitsmith.template.step import LEFT, RIGHT, Gait, StepState

SETTLING_STEPS = 3  # a new speed is reached within two steps and averaged over two
_SHORTEST, _LONGEST = 0.8, 1.1  # of the period; a step that a push cut short says nothing about the next
_SETTLED_SPEED = 0.05  # m/s, below it a robot commanded to zero has arrived and keeps its station


@kernel
def latch(step: StepState, requested: Gait, latched: Gait) -> None:
    """Take over the requested gait; the paper updates parameters when the legs switch (section 2.3)."""
    for axis in range(2):
        if requested.speed[axis] != latched.speed[axis]:
            step.settling[0] = SETTLING_STEPS
        latched.speed[axis] = requested.speed[axis]
    latched.period[0] = requested.period[0]
    latched.alpha[0] = requested.alpha[0]
    latched.height[0] = requested.height[0]
    latched.lift[0] = requested.lift[0]
    latched.width[0] = requested.width[0]


@kernel
def begin_step(step: StepState, stance: int, support_desired: Matrix, swing_actual: Matrix, swing_pitch: float) -> None:
    """Start a step with the two rules of section 2.2.

    Args:
        stance: leg that bears the step.
        support_desired: (3, 3) desired position, velocity, acceleration of the new support sole: first rule.
        swing_actual: (2, 3) actual position and velocity of the new swing sole: second rule.
        swing_pitch: its actual pitch, rad.
    """
    step.stance[0] = stance
    step.last_duration[0] = step.time[0]
    step.time[0] = 0.0
    step.count[0] += 1
    for axis in range(3):
        for order in range(3):
            step.support_start[order, axis] = support_desired[order, axis]
        for order in range(2):
            step.swing_start[order, axis] = swing_actual[order, axis]
    step.swing_pitch_start[0] = swing_pitch


@kernel
def switch_legs(
    step: StepState,
    requested: Gait,
    latched: Gait,
    gains: FootholdGains,
    swing_desired: Matrix,
    stance_actual: Matrix,
    stance_pitch: float,
) -> None:
    """End the step: the swing leg becomes the support leg and the other way round.

    Args:
        swing_desired: (3, 3) desired state of the sole that has just landed.
        stance_actual: (2, 3) actual state of the sole that is about to leave the ground.
        stance_pitch: its pitch, rad.
    """
    finish_step(step, latched, gains)
    ratio = min(max(step.time[0] / latched.period[0], _SHORTEST), _LONGEST)
    step.duration_ratio[0] += 0.5 * (ratio - step.duration_ratio[0])
    at_rest = requested.speed[0] == 0.0 and requested.speed[1] == 0.0
    if not at_rest:
        step.station_kept[0] = 0
    elif step.station_kept[0] == 0 and step.count[0] > 2:
        slow_x = abs(step.last_mean_velocity[0]) < _SETTLED_SPEED
        if slow_x and abs(latched.speed[0]) + abs(latched.speed[1]) == 0.0:
            step.station_kept[0] = 1
    latch(step, requested, latched)
    stance = RIGHT if step.stance[0] == LEFT else LEFT
    begin_step(step, stance, swing_desired, stance_actual, stance_pitch)
