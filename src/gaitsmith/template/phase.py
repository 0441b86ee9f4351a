"""When to stand, shift the weight, step, and switch legs: the event-triggered side of the gait template."""

from __future__ import annotations

import math

from gaitsmith.compiled import kernel
from gaitsmith.template.balance import divergent_reference
from gaitsmith.template.foothold import SETTLING_STEPS, pendulum_frequency
from gaitsmith.template.ground import stand_on
from gaitsmith.template.state import Template
from gaitsmith.template.step import SHIFT, STAND, WALK
from gaitsmith.template.switching import begin_step, latch, switch_legs
from gaitsmith.template.touchdown import FORCED, NONE, detect_touchdown
from gaitsmith.whole_body.frames import to_heading
from gaitsmith.whole_body.legs import Legs

_SHIFTED = 0.15  # of the half width: how near ξ must come to what the first step starts from


@kernel
def com_over_sole(g: Template, leg: int) -> float:
    """CoM relative to a sole's pivot, heading frame, into the forecast's arm; returns ω of the pendulum there, 1/s."""
    frames, com, arm = g.body.frames, g.body.state.com, g.forecast.arm
    place = frames.sole_position[leg]
    to_heading(frames, com[0] - place[0], com[1] - place[1], arm)
    if g.step.mode[0] == WALK:
        arm[0] -= g.ground.pivot[0]
        arm[1] -= g.ground.pivot[1]
    arm[2] = com[2] - place[2]
    return pendulum_frequency(g.foothold, arm[2])


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
def _leave_rest(g: Template) -> None:
    """Take the first step."""
    step, frames, com = g.step, g.body.frames, g.body.state.com
    latch(step, g.requested, g.latched, g.foothold)
    stance = step.stance[0]
    desired = step.foot_desired[stance]
    for axis in range(3):
        desired[0, axis] = frames.relative_position[stance, axis]
        desired[1, axis] = 0.0
        desired[2, axis] = 0.0
    for axis in range(2):
        g.ground.moved[axis] = g.ground.pivot[axis] = 0.0
    g.ground.stumble[0] = g.ground.start[0] = 0.0
    step.station_kept[0] = 0
    if g.requested.speed[0] == 0.0 and g.requested.speed[1] == 0.0:
        step.station_kept[0] = 1
        step.station[0], step.station[1] = com[0], com[1]
    begin_step(step, stance, g.body.legs.other[stance], desired, frames)
    step.last_duration[0] = 0.0
    step.settling[0] = SETTLING_STEPS
    step.mode[0] = WALK


@kernel
def _shifted(g: Template) -> bool:
    """Whether the divergent component has come to what the first step starts from."""
    stance, wanted = g.step.stance[0], g.balance.divergent
    omega, arm = com_over_sole(g, stance), g.forecast.arm
    side = g.body.legs.side[g.body.legs.other[stance]]
    divergent_reference(g.step, g.latched, g.foothold, arm[2], side, 0.0, wanted)
    xi = arm[1] + g.body.frames.com_velocity[1] / omega
    return bool(abs(xi - wanted[1]) < _SHIFTED * g.latched.width[0])


@kernel
def _escaped(g: Template) -> int:
    """Leg that has to step at once, because the divergent component has left the soles; -1 while it has not."""
    legs, velocity = g.body.legs, g.body.frames.com_velocity
    beyond, swing, farthest = True, 0, -1.0
    for leg in range(legs.side.shape[0]):
        omega, arm = com_over_sole(g, leg), g.forecast.arm
        forward, aside = arm[0] + velocity[0] / omega, legs.side[leg] * (arm[1] + velocity[1] / omega)
        if aside > legs.half_width[leg]:
            return leg
        beyond = beyond and (forward > legs.toe[leg] or forward < -legs.heel[leg])
        if abs(aside) > farthest:
            swing, farthest = leg, abs(aside)
    return swing if beyond else -1


@kernel
def _may_rest(g: Template) -> bool:
    """Whether all soles are side by side and the CoM is slow enough to be caught without a step."""
    place, fastest = g.body.frames.relative_position, g.rest.entry_speed
    first = last = place[0, 0]
    for leg in range(place.shape[0]):
        first, last = min(first, place[leg, 0]), max(last, place[leg, 0])
    slow = abs(g.step.last_mean_velocity[0]) < fastest and abs(g.body.frames.com_velocity[0]) < fastest
    return bool(slow and last - first < g.rest.straddle)


@kernel
def within_turn(angle: float) -> float:
    """The same angle between -π and π, rad."""
    return angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi) + 0.5)


@kernel
def turn_heading(g: Template, dt: float) -> None:
    """Turn the wanted heading by the commanded rate while walking; from standing it starts as it is."""
    step = g.step
    if step.heading_set[0] == 0:
        step.heading[0] = g.body.frames.yaw[0]
        step.heading_set[0] = 1
    if step.mode[0] == WALK:
        step.heading[0] += g.latched.yaw_rate[0] * dt
    step.heading[0] = within_turn(step.heading[0])


@kernel
def _stand(g: Template, dt: float) -> bool:
    """One tick before a walk: on both feet, or shifting the weight; True if the first step begins."""
    step, rest = g.step, g.rest
    if step.mode[0] == STAND:
        latch(step, g.requested, g.latched, g.foothold)
        if step.walk_requested[0] == 0:
            step.station_kept[0] = 0
            limit = rest.height_rate * dt
            step.standing_height[0] += min(max(g.latched.height[0] - step.standing_height[0], -limit), limit)
            return False
        step.stance[0] = _first_stance(g.body.legs, g.requested.speed[1])
        step.mode[0] = SHIFT
        step.time[0] = 0.0
    step.time[0] += dt
    if step.walk_requested[0] == 0:
        step.mode[0] = STAND
        return False
    if rest.weight_shift == 1.0 and step.time[0] <= rest.longest_shift:
        latch(step, g.requested, g.latched, g.foothold)
        swing = _escaped(g)
        if swing >= 0:
            step.stance[0] = g.body.legs.other[swing]
        elif not _shifted(g):
            return False
    _leave_rest(g)
    return True


@kernel
def advance_phase(g: Template, dt: float) -> bool:
    """Advance the step's clock by one tick and switch legs on touchdown.

    Returns:
        True if the swing leg changed, so that its references must restart from the measured joints.
    """
    step, frames = g.step, g.body.frames
    if step.mode[0] != WALK:
        return _stand(g, dt)
    step.time[0] += dt
    swing = g.body.legs.other[step.stance[0]]
    event = detect_touchdown(g.touchdown, step.time[0], step.period[0], g.sole_force[swing])
    if event == NONE:
        return False
    if event == FORCED:
        step.forced[0] += 1
    switch_legs(step, g.requested, g.latched, g.foothold, g.speed, swing, step.foot_desired[swing], frames)
    climbed = frames.sole_position[swing, 2] - frames.sole_position[g.body.legs.other[swing], 2]
    stand_on(g.ground, climbed, g.forecast.arm[2])
    if step.walk_requested[0] == 0 and event != FORCED and _may_rest(g):
        step.mode[0] = STAND
        step.count[0] -= 1
        height = 0.0
        for leg in range(frames.relative_position.shape[0]):
            height -= frames.relative_position[leg, 2] / frames.relative_position.shape[0]
        step.standing_height[0] = height
        return False
    return True
