"""The speed integral: it removes a bias of the mean speed, and learns neither from sway nor from a push."""

import numpy as np
import pytest

from gaitsmith.control.defaults import preset_parameters, robot_scale
from gaitsmith.robots import load_robot
from gaitsmith.template.foothold import finish_step, make_speed_gains, observe_motion
from gaitsmith.template.step import make_gait_inputs, make_step_state

ROUNDING = 1e-12  # m/s
ALWAYS = 0.15  # of √(g z): what any number of steps may do


@pytest.fixture(params=["bhr_b2", "thbip_ii"])
def walk(request):
    """A function from step to mean CoM velocity (2,) to what is added to the commanded speed after every step.

    Its last argument is the speed beside the commanded one that the steps are taken for.
    """
    robot = load_robot(request.param)
    scale = robot_scale(robot)
    gains = make_speed_gains(preset_parameters(robot, scale, "default").speed)

    def integrals(velocity, steps, home=0.0):
        step, gait = make_step_state(2, 4), make_gait_inputs(robot.card.gait)
        step.settling[0] = 1  # the first step has no stride
        found = []
        for k in range(steps):
            step.speed[:] = gait.speed + step.integral + home
            for _ in range(10):
                observe_motion(step, gait.speed + velocity(k), np.zeros(2))
            finish_step(step, gait, gains)
            found.append(step.integral.copy())
        return np.array(found)

    return scale.speed, integrals


def test_a_bias_is_worked_off(walk):
    speed, integrals = walk
    found = integrals(lambda _: np.array([-0.01, 0.005]) * speed, 4)
    assert np.all(np.diff(found[:, 0]) > 0.0)  # too slow: more is commanded
    assert np.all(np.diff(found[:, 1]) < 0.0)


def test_sway_that_is_opposite_on_the_two_legs_is_no_bias(walk):
    speed, integrals = walk
    found = integrals(lambda k: np.array([0.0, 0.02 if k % 2 else -0.02]) * speed, 7)
    assert np.abs(found).max() < ROUNDING


@pytest.mark.parametrize("shares", [(1.0,), (1.0, 0.6, 0.2), (0.4, 1.0, 1.0, 0.6, 0.3)])
def test_a_push_says_nothing_about_the_bias(walk, shares):
    """However many steps it takes to come to rest again."""
    speed, integrals = walk
    for size in (0.2, 0.5):
        course = dict(enumerate(shares, 2))
        found = integrals(lambda k, size=size, course=course: np.full(2, size * course.get(k, 0.0)) * speed, 10)
        assert np.abs(found).max() < ROUNDING


def test_a_push_that_begins_at_the_end_of_a_step_is_unlearnt(walk):
    """The little that it moved in its first step looked like a bias."""
    speed, integrals = walk
    course = {2: 0.05, 3: 0.5, 4: 0.2}
    found = integrals(lambda k: np.full(2, course.get(k, 0.0)) * speed, 10)
    assert np.abs(found[2]).max() > ROUNDING
    assert np.abs(found[-1]).max() < ROUNDING


def test_the_way_home_is_no_bias(walk):
    """A robot that goes home at the speed that station keeping wants learns nothing from it."""
    speed, integrals = walk
    home = np.array([0.02, -0.01]) * speed
    assert np.abs(integrals(lambda _: home, 6, home)).max() < ROUNDING


def test_what_is_added_to_the_command_stays_small(walk):
    speed, integrals = walk
    found = integrals(lambda _: np.full(2, -1.0) * speed, 60)
    assert np.abs(found).max() < ALWAYS * speed
