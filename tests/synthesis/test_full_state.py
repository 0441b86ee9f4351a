"""A gait's full state: the support sole stands still, and velocities and accelerations are the derivatives in time."""

import mujoco
import numpy as np
import pytest

from gaitsmith.synthesis.gaits.full_state import StateFinder

STEP = 1e-4  # s
SLOPE = 1e-6  # relative, of differences over twice the step
PLACE = (0.3, -0.1)


@pytest.fixture(scope="module")
def motion(robot):
    """Joint angles, velocities and accelerations (n,) at a time, s."""
    rng = np.random.default_rng(0)
    size, rate = rng.normal(size=(2, len(robot.joint_names))) * [[0.3], [2.0]]
    return lambda t: (size * np.sin(rate * t), size * rate * np.cos(rate * t), -size * rate**2 * np.sin(rate * t))


@pytest.mark.parametrize("support", ["left", "right"])
def test_the_support_sole_stands_flat_at_its_foothold(robot, motion, support):
    finder = StateFinder(robot)
    finder.find(support, PLACE, *motion(0.3))
    place, speed, pull, rotation, spin, turn = finder.foot(support, np.zeros(3))
    assert np.abs(place - [*PLACE, 0.0]).max() < 1e-12
    assert np.abs(rotation - np.eye(3)).max() < 1e-12
    assert max(np.abs(part).max() for part in (speed, pull, spin, turn)) < 1e-10


@pytest.mark.parametrize("support", ["left", "right"])
def test_velocity_and_acceleration_are_derivatives(robot, motion, support):
    finder, model = StateFinder(robot), robot.model
    before, now, after = (finder.find(support, PLACE, *motion(0.3 + k * STEP)) for k in (-1, 0, 1))
    velocity = np.zeros(model.nv)
    mujoco.mj_differentiatePos(model, velocity, 2.0 * STEP, before.position, after.position)
    assert np.abs(velocity - now.velocity).max() < SLOPE * np.abs(now.velocity).max()
    acceleration = (after.velocity - before.velocity) / (2.0 * STEP)
    assert np.abs(acceleration - now.acceleration).max() < SLOPE * np.abs(now.acceleration).max()


def test_a_root_of_zeros_stands_still(robot, motion):
    finder = StateFinder(robot)
    still, zeros = (finder.find("left", PLACE, *motion(0.3), root) for root in (None, np.zeros((3, 6))))
    for name in ("position", "velocity", "acceleration"):
        assert (getattr(still, name) == getattr(zeros, name)).all()
