"""A robot that is thrown off the ground in the middle of a step does not push against air."""

import math

import numpy as np
import pytest

from gaitsmith.robots import load_robot
from gaitsmith.simulation import Scenario
from gaitsmith.simulation.disturbances import Push
from gaitsmith.simulation.episode import Simulation

THROWN = 0.6  # √(g z): speed upwards of what is pushed


@pytest.fixture(scope="module")
def flight():
    """Rows of a walk in place that is thrown up, its summary, and what a sole bears at least in contact, N."""
    robot = load_robot("bhr_b2")
    weight = 9.81 * robot.mass
    jump = robot.mass * THROWN * math.sqrt(9.81 * 0.6)
    push = Push(time=2.0, impulse=(0.0, 0.0, jump), duration=0.05)
    run = Simulation(Scenario(duration=4.0, rest_before=0.5, pushes=(push,)), robot=robot).run()
    return run.log, run.summary, 0.01 * weight


def column(log, name):
    return np.stack([log.column(f"{name.format(side)}") for side in ("left", "right")], axis=1)


def test_nothing_is_planned_to_be_borne_in_the_air(flight):
    log, _, least = flight
    flies = (column(log, "true.{}_force") < 1e-9).all(axis=1) & (column(log, "true.{}_sole_z") > 2e-3).all(axis=1)
    assert flies.sum() > 5
    planned = np.abs(column(log, "wrench.{}.fz"))[flies].sum(axis=1)
    assert np.mean(planned < least) > 0.9


def test_it_lands_on_its_feet_and_walks_on(flight):
    _, summary, _ = flight
    assert not summary.fell
