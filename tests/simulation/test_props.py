"""Balls obey mechanics, tell how they move, and are no part of the robot."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.robots.samples import bhr_text, build_model
from tests.simulation.standing import hold, posture, robot

from gaitsmith.robots import load_robot
from gaitsmith.simulation.plant import Plant
from gaitsmith.simulation.props import Ball

FAR = Ball((1.5, 0.4, 0.05))


def test_a_ball_at_rest_stays_and_is_not_the_robot_s():
    plant, alone = Plant(robot(), props=(FAR,), joint_friction=1.0), Plant(robot(), joint_friction=1.0)
    for each in (plant, alone):
        each.reset(posture())
        hold(each, 200)
    assert plant.q.shape == alone.q.shape
    np.testing.assert_allclose(plant.truth_buffer, alone.truth_buffer, atol=1e-9)
    assert plant.balls[0].travel < 1e-3
    assert plant.balls[0].top_speed < 0.05


def test_a_ball_that_rolls_tells_its_speed_and_travel():
    plant = Plant(robot(), props=(FAR, Ball((2.0, 1.0, 2.0), 0.1, 0.5)))
    plant.reset(posture())
    plant.balls[0].velocity[:] = (2.0, 0.0, 0.0)
    hold(plant, 300)
    rolled, fallen = plant.balls
    # A sliding sphere comes to roll at 5/7 of its speed.
    assert rolled.velocity[0] == pytest.approx(2.0 * 5 / 7, rel=0.02)
    assert 1.9 < rolled.top_speed <= 2.0  # it slides at first
    assert 0.42 < rolled.travel < 0.6
    assert fallen.top_speed == pytest.approx(9.81 * 0.3, rel=0.01)
    plant.reset(posture())
    assert plant.balls[0].top_speed == 0.0
    assert plant.balls[0].travel == 0.0


def test_masses_are_changed_on_the_robot_alone():
    plant = Plant(robot(), props=(FAR,), mass_factor=1.2)
    model, bodies = plant._model, robot().model.nbody
    np.testing.assert_allclose(model.body_mass[:bodies], 1.2 * robot().model.body_mass)
    assert model.body_mass[bodies] == FAR.mass


def test_bodies_of_the_robots_own_scene_are_in_the_plant(tmp_path: Path) -> None:
    crate = '<worldbody><body name="crate" pos="3 0 1"><freejoint/><geom type="box" size=".1 .1 .1"/>'
    crate += '<inertial pos="0 0 0" mass="2" diaginertia=".01 .01 .01"/></body>'
    with_crate = build_model(bhr_text().replace("<worldbody>", crate), tmp_path)
    plant, alone = (Plant(each, props=(FAR,)) for each in (with_crate, load_robot("bhr_b2")))
    assert plant.q.shape == alone.q.shape
    for each in (plant, alone):
        each.reset(posture())
        for _ in range(100):
            each.step(np.zeros(8))
    np.testing.assert_allclose(plant.truth_buffer, alone.truth_buffer, atol=1e-9)
    assert plant.balls[0].position == pytest.approx(alone.balls[0].position, abs=1e-9)
