"""A robot standing under a joint PD: enough control to test the plant without the controller."""

from __future__ import annotations

from functools import cache

import mujoco
import numpy as np

from gaitsmith.kinematics.posture import standing_posture
from gaitsmith.robots import Robot, load_robot
from gaitsmith.simulation.plant import Plant

HEIGHT, WIDTH = 0.66, 0.0875


@cache
def robot() -> Robot:
    return load_robot("bhr_b2")


def posture() -> np.ndarray:
    return standing_posture(robot(), HEIGHT, WIDTH)


def hold(plant: Plant, ticks: int, stiffness: float = 400.0, damping: float = 10.0) -> None:
    """Hold the standing posture for some control ticks."""
    wanted = posture()[7:]
    for _ in range(ticks):
        plant.step(stiffness * (wanted - plant.q[7:]) - damping * plant.v[6:])


def floating(**options) -> Plant:
    """A plant whose robot is in the air, with nothing to touch for a second."""
    plant = Plant(robot(), **options)
    plant.reset(posture())
    plant.q[2] += 20.0
    plant.refresh()
    return plant


def energy(plant: Plant) -> float:
    """Kinetic and potential energy, J, by the engine."""
    model, data = plant._model, plant._data
    mujoco.mj_energyPos(model, data)
    mujoco.mj_energyVel(model, data)
    return float(np.sum(data.energy))


def momentum(plant: Plant) -> np.ndarray:
    """Linear momentum, world, N·s, by the engine."""
    mujoco.mj_subtreeVel(plant._model, plant._data)
    return plant._data.subtree_linvel[0] * robot().mass


def ground_height(plant: Plant, x: float, y: float) -> float:
    """Height of whatever lies under a point, by a ray straight down, m."""
    hit = np.zeros(1, dtype=np.int32)
    start, down = np.array([x, y, 50.0]), np.array([0.0, 0.0, -1.0])
    return 50.0 - mujoco.mj_ray(plant._model, plant._data, start, down, None, 1, -1, hit, None)
