"""Whatever the sensors say, the torques are finite and within limits, the controller says so, and it goes on."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.control.walking import Loop

from gaitsmith.control import Measurement

WALK = 150  # ticks with faults
AFTER = 60  # ticks without, at the end of which all is well
READ = {
    "true": ("base_position", "base_quaternion", "base_velocity", "joint_position", "joint_velocity", "sole_force"),
    "estimated": ("base_quaternion", "joint_position", "accelerometer", "gyro", "sole_force"),
}
MISSING = (float("nan"), float("inf"), float("-inf"))
HUGE = (1e308, -1e308, 1e155, 1e100, -1e30, 1e10, 1e4, -1e3, 0.0)
states = pytest.mark.parametrize("state", ["true", "estimated"])


@cache
def loop(state: str) -> Loop:
    return Loop("bhr_b2", state=state)


def restart(state: str) -> Loop:
    """The same loop from the start, walking."""
    again = loop(state)
    again.restart()
    again.controller.walk()
    return again


def run(state: str, faults: list[tuple[int, str, int, float]]) -> tuple[np.ndarray, Loop]:
    """Torques (ticks, nj) of a walk with faults (tick, field, entry, value)."""
    walk, torques = restart(state), []
    for tick in range(WALK + AFTER):
        walk.plant.measure(walk.controller.measurement)
        for _, field, entry, value in (fault for fault in faults if fault[0] == tick):
            array = getattr(walk.controller.measurement, field)
            array[entry % len(array)] = value
        torques.append(walk.controller.tick().copy())
        walk.plant.step(torques[-1])
    return np.array(torques), walk


def remembered(walk: Loop) -> dict[str, np.ndarray]:
    """All arrays that one tick leaves for the next."""
    found: dict[str, np.ndarray] = {}

    def gather(name: str, value: Any) -> None:
        if isinstance(value, np.ndarray):
            found[name] = value
        for field in getattr(value, "_fields", ()):
            gather(f"{name}.{field}", getattr(value, field))

    for name in ("template", "control", "estimation", "motors", "reference", "telemetry"):
        gather(name, getattr(walk.groups, name))
    return found


def assert_bounded(torques: np.ndarray, walk: Loop) -> None:
    assert np.isfinite(torques).all()
    assert (np.abs(torques) <= walk.robot.torque_limit).all()


def assert_recovered(walk: Loop) -> None:
    """Nothing that is remembered is poisoned, and the whole-body QP solves again."""
    poisoned = [name for name, array in remembered(walk).items() if not np.isfinite(array).all()]
    assert not poisoned
    assert walk.groups.whole_body.solution.status[0] == 0


def faults(state: str, values: tuple[float, ...]) -> st.SearchStrategy[Any]:
    fault = st.tuples(
        st.integers(0, WALK - 1), st.sampled_from(READ[state]), st.integers(0, 50), st.sampled_from(values)
    )
    return st.lists(fault, min_size=1, max_size=4)


@states
@settings(max_examples=40)
@given(data=st.data())
def test_missing_readings(state: str, data: st.DataObject) -> None:
    """NaN and infinity are counted and replaced, and the walk goes on as if nothing had been."""
    chosen = data.draw(faults(state, MISSING))
    torques, walk = run(state, chosen)
    assert_bounded(torques, walk)
    assert_recovered(walk)
    assert walk.groups.control.refused_ticks[0] >= len({fault[0] for fault in chosen})
    assert np.max(np.abs(walk.controller.telemetry.tilt[:2])) < 0.05
    seen = {(fault[0], fault[1]) for fault in chosen}
    for name, count in zip(Measurement._fields, walk.groups.control.refused, strict=True):
        assert count >= len([tick for tick, field in seen if field == name])


@states
@settings(max_examples=60)
@given(data=st.data())
def test_absurd_readings(state: str, data: st.DataObject) -> None:
    """Numbers that cannot be: torques stay finite and within limits."""
    torques, walk = run(state, data.draw(faults(state, HUGE + MISSING)))
    assert_bounded(torques, walk)


@states
def test_absurd_readings_are_forgotten(state: str) -> None:
    """One tick of nonsense must not stay in memory."""
    for field in READ[state]:
        for value in HUGE:
            torques, walk = run(state, [(100, field, 1, value)])
            assert_bounded(torques, walk)
            assert_recovered(walk)


@states
def test_what_cannot_be_done_without_ends_in_braking(state: str) -> None:
    """With every reading lost the model stands in for a time; then the joints are braked until told to go on."""
    walk = restart(state)
    for _ in range(50):
        walk.step()
    measurement, torques, states_seen = walk.controller.measurement, [], []
    for _ in range(1500):
        for array in measurement:
            array[:] = np.nan
        torques.append(walk.controller.tick().copy())
        states_seen.append(walk.controller.state)
    assert_bounded(np.array(torques), walk)
    assert states_seen[0] != "fault"
    assert states_seen[-1] == "fault"
    assert walk.controller.telemetry.reading_lost[0] >= 0.0
    walk.controller.stand()
    walk.plant.measure(measurement)
    walk.controller.tick()
    assert walk.controller.state != "fault"


@states
def test_what_is_not_read_does_not_matter(state: str) -> None:
    """Fields that a state does not use may hold anything: the torques are the same, bit for bit."""
    unread = [field for field in Measurement._fields if field not in READ[state]]
    expected, _ = run(state, [])
    actual, walk = run(state, [(tick, field, 1, float("nan")) for tick in range(20, 100) for field in unread])
    np.testing.assert_array_equal(actual, expected)
    assert walk.groups.control.refused_ticks[0] == 0
