"""The weight shift before a walk is left at once when the divergent component leaves the soles."""

import numpy as np
import pytest

from gaitsmith.compiled import Arena
from gaitsmith.control import Controller
from gaitsmith.robots import load_robot
from gaitsmith.template.phase import advance_phase
from gaitsmith.template.step import SHIFT, WALK

W, Z = 0.065, 0.33  # m, of soles beside and of the CoM above


@pytest.fixture(scope="module")
def controller():
    return Controller(load_robot("thbip_ii"))


def first_step(controller, place, velocity=(0.0, 0.0)):
    """Swing leg's side, +1 for the left, of the step that begins with the CoM there (m, m/s); 0 if none begins."""
    controller.reset()
    controller.walk()
    g = controller._g.template
    g.step.mode[0], g.step.stance[0] = SHIFT, 1
    frames, legs = g.body.frames, g.body.legs
    frames.cos_yaw[0], frames.sin_yaw[0] = 1.0, 0.0
    for leg in range(2):
        frames.sole_position[leg] = 0.0, W * legs.side[leg], 0.0
        frames.relative_position[leg] = 0.0, W * legs.side[leg], -0.36
    g.body.state.com[:] = (*place, Z)
    frames.com_velocity[:] = (*velocity, *np.zeros(len(frames.com_velocity) - 2))
    advance_phase(Arena(g), 1e-3)
    return int(legs.side[legs.other[g.step.stance[0]]]) if g.step.mode[0] == WALK else 0


def test_between_the_soles_the_shift_goes_on(controller):
    assert first_step(controller, (0.0, 0.0)) == 0
    assert first_step(controller, (0.0, 0.0), (0.2, 0.2)) == 0


@pytest.mark.parametrize("side", [-1, 1])
def test_beyond_a_sole_its_own_leg_steps(controller, side):
    assert first_step(controller, (0.0, side * (W + 0.05))) == side
    assert first_step(controller, (0.0, 0.0), (0.0, side * 0.8)) == side


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("speed", [-1.0, 1.0])
def test_before_or_behind_both_soles_the_leg_that_is_farther_off_steps(controller, side, speed):
    assert first_step(controller, (0.0, -side * 0.02), (speed, 0.0)) == side
