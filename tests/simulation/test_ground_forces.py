"""Forces between robot and ground are those of now: they carry the robot, and change its momentum."""

import numpy as np
from tests.simulation.standing import hold, momentum, posture, robot

from gaitsmith.simulation.plant import Plant

GRAVITY = 9.81


def test_ground_forces_carry_a_standing_robot_at_its_soles():
    plant = Plant(robot())
    plant.reset(posture())
    assert plant.zmp() is None  # no torque has acted: what the ground would bear of a limp robot is no ZMP
    hold(plant, 400)
    assert plant.zmp() is not None
    found = plant.ground_forces()
    np.testing.assert_allclose(found[:, 5].sum(), robot().mass * GRAVITY, rtol=0.02)
    assert abs(found[:, :2] @ np.ones(2)).max() < 0.5
    assert abs(found[:, 2]).max() < 2e-3
    hold(plant, 1)
    assert np.linalg.norm(found[:, 3:5].sum(axis=0)) < 0.02 * robot().mass * GRAVITY


def test_ground_forces_change_the_momentum_while_contacts_come_and_go():
    """A robot that collapses: the forces of an instant are those that act in the step after it."""
    plant = Plant(robot(), physics_step=1e-3)
    plant.reset(posture())
    weight, met, counts = np.array([0.0, 0.0, robot().mass * GRAVITY]), [], set()
    for tick in range(300):
        plant.step(20.0 * np.sin(0.3 * tick // 3 + np.arange(8)))
        found, before = plant.ground_forces(), momentum(plant)
        counts.add(len(found))
        plant.step(20.0 * np.sin(0.3 * tick // 3 + np.arange(8)))
        rate = (momentum(plant) - before) / plant.control_step
        met.append(np.linalg.norm(found[:, 3:].sum(axis=0) - rate - weight) / weight[2])
    assert len(counts) > 2
    assert np.median(met) < 0.02
    assert np.mean(np.array(met) > 0.2) < 0.03
