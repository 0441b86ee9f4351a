"""A walk ends in standing only where it can: soles side by side, CoM slow, and both soles really on the ground."""

import pytest

from gaitsmith.compiled import Arena
from gaitsmith.control import Controller
from gaitsmith.robots import load_robot
from gaitsmith.template.phase import advance_phase
from gaitsmith.template.step import STAND, WALK


@pytest.fixture(scope="module", params=["bhr_b2", "thbip_ii"])
def controller(request):
    return Controller(load_robot(request.param))


def ends_standing(controller, ahead=0.0, speed=0.0, force=1.0, time=1.0):
    """Whether a walk that is asked to end does so at this touchdown.

    ``ahead`` is how far one sole stands before the other over the CoM's height, ``speed`` that of the CoM over √(g z),
    ``force`` that of the landing sole over the weight, ``time`` that of the step over its period.
    """
    controller.reset()
    g, scale = controller._g.template, controller.scale
    g.step.mode[0], g.step.walk_requested[0], g.step.stance[0] = WALK, 0, 0
    g.step.time[0] = time * g.latched.period[0]
    half = 0.5 * ahead * scale.height
    g.body.frames.relative_position[:] = [[half, 0.1, -0.5], [-half, -0.1, -0.5]]
    g.body.frames.com_velocity[:] = speed * scale.speed, 0.0, 0.0
    swing = int(g.body.legs.other[0])
    g.sole_force[:] = 0.0
    g.sole_force[swing] = force * scale.weight
    advance_phase(Arena(g), 1e-3)
    return g.step.mode[0] == STAND


def test_it_ends_where_both_soles_stand_side_by_side(controller):
    assert ends_standing(controller)


@pytest.mark.parametrize("ahead", [-0.15, 0.15])
def test_it_goes_on_while_one_sole_is_ahead_of_the_other(controller, ahead):
    assert not ends_standing(controller, ahead=ahead)
    assert ends_standing(controller, ahead=0.2 * ahead)


@pytest.mark.parametrize("speed", [-0.1, 0.1])
def test_it_goes_on_while_the_com_moves(controller, speed):
    assert not ends_standing(controller, speed=speed)


def test_it_goes_on_while_the_swing_sole_is_in_the_air(controller):
    assert not ends_standing(controller, force=0.0)
    assert not ends_standing(controller, force=0.0, time=3.0)  # a step ended by the clock
