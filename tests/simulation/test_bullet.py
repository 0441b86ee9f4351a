"""The second engine: the same laws of physics, the same walks, the same measurements."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from tests.simulation.standing import posture, robot

from gaitsmith.errors import BadInput
from gaitsmith.robots import load_robot
from gaitsmith.simulation import Simulation, run_episode
from gaitsmith.simulation.plant import Plant
from gaitsmith.simulation.props import Ball
from gaitsmith.simulation.scenario import make_scenario
from gaitsmith.simulation.terrain import parse_terrain

pytest.importorskip("pybullet")  # has no wheels for Python 3.12 and later
from gaitsmith.simulation.bullet import BulletPlant

GRAVITY = 9.81


def in_the_air(kind=BulletPlant, **options):
    plant = kind(robot(), **options)
    plant.reset(posture())
    plant.q[2] += 20.0
    plant.refresh()
    return plant


def test_in_the_air_the_centre_of_mass_falls_and_turns_nothing():
    plant = in_the_air()
    began = plant.com.copy()
    for _ in range(200):
        plant.step(np.zeros(8))
    expected = began - [0.0, 0.0, 0.5 * GRAVITY * 0.2**2]
    assert plant.com == pytest.approx(expected, abs=2e-3)
    assert np.abs(plant.v[3:6]).max() < 1e-6


def test_torques_inside_the_robot_move_both_engines_alike():
    found = []
    for kind in (Plant, BulletPlant):
        plant = in_the_air(kind)
        for _ in range(20):
            plant.step(np.array([0.0, 4.0, 6.0, 0.0, 0.0, -4.0, 2.0, 0.0]))
        found.append(plant.v.copy())
    assert np.abs(found[0][6:]).max() > 0.5
    assert np.abs(found[1] - found[0]).max() < 0.02 * np.abs(found[0][6:]).max()


def test_what_the_ground_does_changes_the_momentum():
    simulation = Simulation(make_scenario({"engine": "bullet", "speed": [0.4, 0.0], "duration": 2.2}), record=False)
    plant, before, errors = simulation.plant, None, []
    while simulation.step():
        velocity = plant.truth.com_velocity.copy()
        if before is not None and simulation.time > 1.5:
            rate = (velocity - before) / plant.control_step + [0.0, 0.0, GRAVITY]
            errors.append(robot().mass * rate - plant.ground_forces()[:, 3:].sum(axis=0))
        before = velocity
    assert np.median(np.abs(errors), axis=0).max() < 2.0


@pytest.mark.parametrize(("name", "speed"), [("bhr_b2", 0.5), ("thbip_ii", 0.3)])
def test_both_robots_walk(name, speed):
    scenario = make_scenario({"robot": name, "engine": "bullet", "speed": [speed, 0.0], "duration": 5.0})
    summary = run_episode(scenario, record=False).summary
    assert summary.fall is None
    assert abs(summary.stages[-1].vx_error) < 0.02
    assert any("rotor" in warning for warning in summary.warnings)


def test_standing_soles_carry_the_weight_and_the_sensors_say_so():
    simulation = Simulation(
        make_scenario({"engine": "bullet", "state": "estimated", "duration": 1.0, "speed": [0.0, 0.0]}), record=False
    )
    while simulation.step():
        pass
    measured = simulation.controller.measurement
    assert measured.sole_force.sum() == pytest.approx(robot().mass * GRAVITY, rel=0.05)
    assert measured.accelerometer[2] == pytest.approx(GRAVITY, abs=1.0)


def test_a_push_is_felt_and_the_same_seed_gives_the_same_bits():
    push = {"time": 1.5, "impulse": [0.0, 10.0, 0.0]}
    fields = {"engine": "bullet", "speed": [0.0, 0.0], "duration": 2.0}
    found = []
    for pushes in ([push], [push], []):
        simulation = Simulation(make_scenario({**fields, "pushes": pushes}), record=False)
        while simulation.step():
            pass
        found.append(simulation.plant.q.copy())
    np.testing.assert_array_equal(found[0], found[1])
    assert np.abs(found[0] - found[2]).max() > 0.01


def test_it_stands_on_the_ground_that_is_there():
    plant = BulletPlant(robot(), terrain=parse_terrain("stairs:-0.05,0.2,0.12,3"))
    plant.reset(posture())
    for _ in range(30):
        plant.step(400.0 * (posture()[7:] - plant.q[7:]) - 10.0 * plant.v[6:])
    assert plant.ground_forces()[:, 2] == pytest.approx(0.15, abs=5e-3)


def test_what_it_cannot_do_is_said(monkeypatch):
    with pytest.raises(BadInput, match="ball"):
        BulletPlant(load_robot("bhr_b2"), props=(Ball((1.0, 0.0, 0.05)),))
    monkeypatch.setitem(sys.modules, "pybullet", None)
    with pytest.raises(BadInput, match="pip install 'gaitsmith"):
        BulletPlant(robot())
