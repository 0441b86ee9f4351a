"""The tick allocates nothing, compiles once for all robots, and gives the same bits for the same input."""

from __future__ import annotations

import numpy as np
import pytest
from numba.core.runtime import _nrt_python, rtsys
from tests.control.walking import ROBOTS, Held, Loop

from gaitsmith.control import Controller
from gaitsmith.control.tick import tick
from gaitsmith.simulation import Plant
from gaitsmith.simulation.sensors import SensorNoise


@pytest.mark.parametrize("state", ["true", "estimated"])
def test_ten_thousand_ticks_allocate_nothing(state: str) -> None:
    """numba's counters stand still over standing, walking, commands, bad measurements."""
    held = Held(state=state)
    forces = np.random.default_rng(0).uniform(0.0, 60.0, size=(10_000, 2))
    held.tick()
    _nrt_python.memsys_enable_stats()
    before = rtsys.get_allocation_stats()
    for k, (left, right) in enumerate(forces):
        if k == 500:
            held.controller.walk()
        held.tick(left, right if k % 1000 else np.nan)
    assert rtsys.get_allocation_stats() == before
    assert held.groups.step.count[0] > 10
    assert held.groups.control.counts[0] == 10


def test_robots_share_one_compilation() -> None:
    for name in ROBOTS:
        Held(name).tick()
    assert len(tick.signatures) == 1


def walk(controller: Controller, plant: Plant, start: np.ndarray) -> np.ndarray:
    """Torques of 0.8 s from rest."""
    plant.reset(start)
    controller.reset()
    controller.walk()
    torques = []
    for _ in range(800):
        plant.measure(controller.measurement)
        torques.append(controller.tick().copy())
        plant.step(torques[-1])
    return np.array(torques)


@pytest.mark.parametrize("state", ["true", "estimated"])
def test_same_seed_same_bits(state: str) -> None:
    """Twice with the same objects, and once with new ones; another seed differs where there is noise."""

    def make(seed: int) -> tuple[Controller, Plant, np.ndarray]:
        loop = Loop("bhr_b2", state=state)
        sensors = SensorNoise() if state == "estimated" else None
        return loop.controller, Plant(loop.robot, sensors=sensors, seed=seed), loop.start

    one = make(3)
    first = walk(*one)
    np.testing.assert_array_equal(walk(*one), first)
    np.testing.assert_array_equal(walk(*make(3)), first)
    assert np.array_equal(walk(*make(4)), first) == (state == "true")
