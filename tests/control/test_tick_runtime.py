"""The tick allocates nothing, compiles once for all robots, and gives the same bits for the same input."""

from __future__ import annotations

import numpy as np
import pytest
from numba.core.runtime import _nrt_python, rtsys
from tests.control.walking import ROBOTS, Held, Loop

from gaitsmith.control.tick import tick
from gaitsmith.simulation.sensors import SensorNoise


@pytest.mark.parametrize("name", ["bhr_b2", "thbip_ii"])
@pytest.mark.parametrize("state", ["true", "estimated"])
def test_ten_thousand_ticks_allocate_nothing(name: str, state: str) -> None:
    """numba's counters stand still over standing, walking, commands, bad measurements, and all other states."""
    held = Held(name, state=state)
    forces = np.random.default_rng(0).uniform(0.0, 60.0, size=(10_000, 2))
    plan = {
        500: held.controller.walk,
        8000: held.controller.damp,
        8100: held.controller.off,
        8200: held.controller.walk,
    }
    held.tick()
    _nrt_python.memsys_enable_stats()
    before = rtsys.get_allocation_stats()
    for k, (left, right) in enumerate(forces):
        plan.get(k, lambda: None)()
        if k % 50 == 49:
            held.controller.command(height=held.gait.height - 0.01 * (k % 3))
        unloaded = k > 9000
        held.tick(0.0 if unloaded else left, np.nan if k % 1000 == 0 else 0.0 if unloaded else right)
    assert rtsys.get_allocation_stats() == before
    assert held.groups.template.step.count[0] > 10
    assert held.groups.control.refused_ticks[0] == 10
    assert held.controller.state == "airborne"


def test_robots_share_one_compilation() -> None:
    for name in ROBOTS:
        Held(name).tick()
    assert len(tick.signatures) == 1


@pytest.mark.parametrize("state", ["true", "estimated"])
def test_same_seed_same_bits(state: str) -> None:
    """Twice with the same objects, and once with new ones; another seed differs where there is noise."""

    def make(seed: int) -> Loop:
        noise = SensorNoise() if state == "estimated" else None
        return Loop("bhr_b2", state=state, plant={"sensors": noise, "seed": seed})

    def walk(loop: Loop) -> np.ndarray:
        loop.restart()
        loop.controller.walk()
        return loop.run(800)

    one = make(3)
    first = walk(one)
    np.testing.assert_array_equal(walk(one), first)
    np.testing.assert_array_equal(walk(make(3)), first)
    assert np.array_equal(walk(make(4)), first) == (state == "true")
