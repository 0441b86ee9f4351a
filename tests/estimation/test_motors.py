"""A motor that gives less than it is told is named, and no other; a push, a landing and good motors name none."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from tests.control.walking import Loop

from gaitsmith.simulation.sensors import SensorNoise

BEFORE, LENGTH, AFTER = 1500, 400, 600  # ticks


@cache
def loop(state: str) -> Loop:
    return Loop("bhr_b2", state=state, plant={"sensors": SensorNoise()} if state == "estimated" else {})


def named(state: str, joint: str, share: float, push: float = 0.0) -> tuple[set[str], Loop]:
    """Walk; then one motor gives a share of its torque for a time, or the torso is pushed, N; which were named."""
    found = loop(state)
    found.restart()
    found.controller.walk()
    found.controller.command(speed=(0.12 * np.sqrt(9.81 * found.gait.height), 0.0))
    names, seen = found.robot.joint_names, set()
    j = list(names).index(joint)
    for tick in range(BEFORE + LENGTH + AFTER):
        bad = BEFORE <= tick < BEFORE + LENGTH
        found.plant.push((0.0, push if BEFORE <= tick < BEFORE + 100 else 0.0, 0.0))
        found.plant.measure(found.controller.measurement)
        torque = found.controller.tick().copy()
        torque[j] *= share if bad else 1.0
        found.plant.step(torque)
        seen |= {names[k] for k in np.flatnonzero(found.groups.motors.what)}
    return seen, found


@pytest.mark.parametrize("state", ["true", "estimated"])
@pytest.mark.parametrize(("joint", "share"), [("left_hip_pitch", 0.0), ("left_hip_pitch", 0.3), ("right_knee", 0.3)])
def test_a_motor_that_gives_less_is_named(state, joint, share):
    """It is good again once it gives what it is told, and the walk goes on."""
    seen, found = named(state, joint, share)
    assert seen == {joint}
    assert not found.groups.motors.what.any()
    assert found.controller.state == "walking"


@pytest.mark.parametrize("state", ["true", "estimated"])
@pytest.mark.parametrize("push", [0.0, 200.0, -200.0])
def test_good_motors_are_not_named(state, push):
    """Not in walking, and not when the torso is pushed by 20 N·s."""
    seen, found = named(state, "right_knee", 1.0, push)
    assert seen == set()
    assert found.controller.state == "walking"
