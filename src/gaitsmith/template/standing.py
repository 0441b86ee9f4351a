"""Standing on both feet as a producer of references: balance over the soles, and the weight shift before a walk."""

from __future__ import annotations

from gaitsmith.compiled import kernel
from gaitsmith.template.balance import divergent_reference, shift_acceleration
from gaitsmith.template.phase import com_over_sole
from gaitsmith.template.state import Template
from gaitsmith.template.step import SHIFT
from gaitsmith.whole_body.frames import to_world
from gaitsmith.whole_body.reference import FLAT


@kernel
def _shift_weight(g: Template) -> None:
    """CoM reference that brings the divergent component to what the first step starts from."""
    step, legs, frames, cop, divergent = g.step, g.body.legs, g.body.frames, g.balance.cop, g.balance.divergent
    stance = step.stance[0]
    swing = legs.other[stance]
    omega, arm = com_over_sole(g, stance), g.forecast.arm
    for axis in range(2):
        step.speed[axis] = g.latched.speed[axis]
    divergent_reference(step, g.latched, g.foothold, arm[2], legs.side[swing], 0.0, divergent)
    for axis in range(2):
        away = frames.relative_position[swing, axis] - frames.relative_position[stance, axis]
        front, back = (legs.toe[stance], legs.heel[stance]) if axis == 0 else (0.0, 0.0)
        low, high = min(away, 0.0) - 0.5 * back, max(away, 0.0) + 0.5 * front
        cop[axis] = shift_acceleration(omega, arm[axis], frames.com_velocity[axis], divergent[axis], low, high)
    to_world(frames, cop[0], cop[1], g.reference.com[2])


@kernel
def refer_standing(g: Template) -> None:
    """All soles bear; CoM over their middle, or on its way to the first stance foot; hips at their height."""
    reference, frames, state = g.reference, g.body.frames, g.body.state
    count = frames.sole_position.shape[0]
    floor = 0.0
    for order in range(3):
        for axis in range(3):
            reference.com[order, axis] = 0.0
    for leg in range(count):
        reference.contact[leg] = FLAT
        reference.cop_weight[leg] = reference.load_weight[leg] = 0.0
        floor += frames.sole_position[leg, 2] / count
        reference.com[0, 0] += frames.sole_position[leg, 0] / count
        reference.com[0, 1] += frames.sole_position[leg, 1] / count
        for axis in range(3):
            for k in range(3):
                reference.sole_rotation[leg, axis, k] = frames.sole_rotation[leg, axis, k]
    reference.com_weight[0] = reference.com_weight[1] = 1.0
    reference.com_weight[2] = 0.0
    reference.hip_height[0] = floor + g.step.standing_height[0]
    reference.hip_height[1] = reference.hip_height[2] = 0.0
    reference.hip_height_weight[0] = 1.0
    if g.step.mode[0] == SHIFT:
        for axis in range(2):
            reference.com[0, axis] = state.com[axis]
            reference.com[1, axis] = state.com_velocity[axis]
        _shift_weight(g)
