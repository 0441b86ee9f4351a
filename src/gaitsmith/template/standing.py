"""Standing on both feet as a producer of references: balance over the soles, and the weight shift before a walk."""

from __future__ import annotations

from gaitsmith.compiled import kernel
from gaitsmith.dynamics.tree import TreeState
from gaitsmith.template.balance import divergent_reference, shift_acceleration
from gaitsmith.template.foothold import FootholdGains, Forecast, pendulum_frequency
from gaitsmith.template.phase import com_over_sole
from gaitsmith.template.step import SHIFT, GaitInputs, StepState
from gaitsmith.template.walking import Balance
from gaitsmith.whole_body.frames import Frames, to_world
from gaitsmith.whole_body.legs import Legs
from gaitsmith.whole_body.reference import FLAT, Reference


@kernel
def _shift_weight(
    step: StepState,
    latched: GaitInputs,
    foothold: FootholdGains,
    forecast: Forecast,
    balance: Balance,
    legs: Legs,
    frames: Frames,
    tree_state: TreeState,
    reference: Reference,
) -> None:
    """CoM reference that brings the divergent component to what the first step starts from."""
    stance = step.stance[0]
    swing = legs.other[stance]
    com_over_sole(frames, tree_state.com, stance, forecast.arm)
    omega = pendulum_frequency(foothold, forecast.arm[2])
    for axis in range(2):
        step.speed[axis] = latched.speed[axis]
    divergent_reference(step, latched, foothold, forecast.arm[2], legs.side[swing], 0.0, balance.divergent)
    for axis in range(2):
        away = frames.relative_position[swing, axis] - frames.relative_position[stance, axis]
        front, back = (legs.toe[stance], legs.heel[stance]) if axis == 0 else (0.0, 0.0)
        balance.cop[axis] = shift_acceleration(
            omega,
            forecast.arm[axis],
            frames.com_velocity[axis],
            balance.divergent[axis],
            min(away, 0.0) - 0.5 * back,
            max(away, 0.0) + 0.5 * front,
        )
    to_world(frames, balance.cop[0], balance.cop[1], reference.com[2])


@kernel
def refer_standing(
    step: StepState,
    latched: GaitInputs,
    foothold: FootholdGains,
    forecast: Forecast,
    balance: Balance,
    legs: Legs,
    frames: Frames,
    tree_state: TreeState,
    reference: Reference,
) -> None:
    """All soles bear; CoM over their middle, or on its way to the first stance foot; hips at their height."""
    count = legs.side.shape[0]
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
    reference.hip_height[0] = floor + step.standing_height[0]
    reference.hip_height[1] = reference.hip_height[2] = 0.0
    reference.hip_height_weight[0] = 1.0
    if step.mode[0] == SHIFT:
        for axis in range(2):
            reference.com[0, axis] = tree_state.com[axis]
            reference.com[1, axis] = tree_state.com_velocity[axis]
        _shift_weight(step, latched, foothold, forecast, balance, legs, frames, tree_state, reference)
