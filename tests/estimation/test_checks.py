"""A bad reading is named and replaced by what the rest says; a good one never is; the walk goes on."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from tests.control.walking import Loop

from gaitsmith.estimation.measurement import all_of, make_measurement
from gaitsmith.estimation.readings import (
    CONTRADICTION,
    HIGH,
    JUMP,
    MISSING,
    STUCK,
    UNLOADED,
    WHAT,
    channel_names,
)
from gaitsmith.simulation.sensors import SensorNoise
from gaitsmith.simulation.terrain import parse_terrain

BEFORE, LENGTH, AFTER = 700, 300, 300  # ticks
SPEED = 0.12  # √(gH)


@cache
def loop(state: str) -> Loop:
    return Loop("bhr_b2", state=state, plant={"sensors": SensorNoise()} if state == "estimated" else {})


def walk(state: str, name: str, spoil, length: int = LENGTH):
    """Walk, spoil one channel's numbers for a time, walk on; what was wrong with every channel, and the loop."""
    found = loop(state)
    found.restart()
    found.controller.walk()
    found.controller.command(speed=(SPEED * np.sqrt(9.81 * found.gait.height), 0.0))
    readings, names = found.groups.checking.readings, found.controller.telemetry_columns
    names = tuple(entry.removeprefix("reading.") for entry in names if entry.startswith("reading."))
    c = names.index(name) if name else 0
    entries = slice(int(readings.first[c]), int(readings.first[c + 1]))
    seen, held = {}, None
    for tick in range(BEFORE + length + AFTER):
        found.plant.measure(found.controller.measurement)
        values = all_of(found.controller.measurement)
        if name and BEFORE <= tick < BEFORE + length:
            held = values[entries].copy() if held is None else held
            values[entries] = spoil(values[entries], held)
        found.plant.step(found.controller.tick())
        assert np.isfinite(found.controller.telemetry.torque).all()
        for k in np.flatnonzero(readings.what):
            seen.setdefault(names[k], set()).add(int(readings.what[k]))
    return seen, found


def assert_walks(found: Loop) -> None:
    assert found.controller.state == "walking"
    assert np.max(np.abs(found.controller.telemetry.tilt[:2])) < 0.1
    assert not found.groups.checking.readings.what.any()


@pytest.mark.parametrize("state", ["true", "estimated"])
def test_good_readings_are_left_alone(state):
    seen, found = walk(state, "", None)
    assert seen == {}
    assert found.groups.control.refused_ticks[0] == 0


NAN = lambda now, held: now * np.nan  # noqa: E731
HELD = lambda now, held: held  # noqa: E731
ZERO = lambda now, held: 0.0 * now  # noqa: E731


@pytest.mark.parametrize(
    ("state", "name", "spoil", "what"),
    [
        ("true", "base_position", NAN, MISSING),
        ("true", "base_velocity", lambda now, _: now + 0.5, CONTRADICTION),
        ("true", "attitude", ZERO, MISSING),
        ("true", "left_knee.angle", HELD, STUCK),
        ("true", "left_knee.angle", lambda now, _: now + 0.1, JUMP),
        ("true", "left_knee.rate", lambda now, _: now + 2.0, CONTRADICTION),
        ("estimated", "gyro", lambda now, _: now - 1.0, CONTRADICTION),
        ("estimated", "gyro", lambda now, _: now + 1.0, CONTRADICTION),
        ("estimated", "gyro", HELD, STUCK),
        ("estimated", "accelerometer", ZERO, STUCK),
        ("estimated", "attitude", NAN, MISSING),
        ("estimated", "left.force", NAN, MISSING),
    ],
)
def test_a_bad_sensor_is_named_and_the_walk_goes_on(state, name, spoil, what):
    """For 300 ms each; what is wrong with it is found, nothing else is blamed, and the sensor is believed again."""
    seen, found = walk(state, name, spoil)
    assert set(seen) == {name}, {key: [WHAT[k] for k in kinds] for key, kinds in seen.items()}
    assert what in seen[name]
    assert_walks(found)


@pytest.mark.parametrize(
    ("spoil", "what"),
    [(lambda now, _: now + 200.0, STUCK), (ZERO, UNLOADED), (lambda now, _: 200.0 + now * 0.0, STUCK)],
)
def test_a_sole_that_contradicts_its_swing_is_named(spoil, what):
    """A force that does not change in the air; none though the sole has landed."""
    seen, found = walk("true", "right.force", spoil, length=1000)
    assert set(seen) == {"right.force"}
    assert seen["right.force"] & {what, HIGH}
    assert_walks(found)


def test_a_sole_that_finds_no_ground_yet_is_not_blamed():
    """Boxes that it does not know of, some lower than the sole's swing ends: the force sensors are good."""
    found = Loop("bhr_b2", plant={"terrain": parse_terrain("boxes:0.05", 3)})
    found.controller.walk()
    found.controller.command(speed=(SPEED * np.sqrt(9.81 * found.gait.height), 0.0))
    seen = set()
    for _ in range(4500):
        found.step()
        seen |= set(np.flatnonzero(found.groups.checking.readings.what[-2:]))
    assert not seen
    assert found.controller.state == "walking"


def test_an_encoder_of_a_joint_that_is_struck_is_believed():
    """An impact sets a swinging ankle in motion within one tick: the model did not foresee it, but it is true."""
    seen, found = strike(50.0, lambda values, j: None)
    assert not {name for name in seen if name.endswith(".angle")}
    assert_walks(found)


def test_an_encoder_that_jumps_once_is_not_believed():
    """By as much as the struck joint goes in its first tick, and then along with the true angle."""

    def spoil(values, j):
        values[13 + j] += 0.05

    seen = strike(0.0, spoil)[0]
    assert {name for name in seen if name.endswith(".angle")} == {"left_ankle.angle"}


def strike(speed: float, spoil) -> tuple[set[str], Loop]:
    """Walk; in a swing of the left leg its ankle gets a speed, rad/s, or its encoder breaks; names of bad channels."""
    found = loop("estimated")
    found.restart()
    found.controller.walk()
    found.run(BEFORE)
    j, step = list(found.robot.joint_names).index("left_ankle"), found.groups.template.step
    while step.stance[0] != 1 or not 0.1 < step.time[0] < 0.15:
        found.step()
    found.plant.v[6 + j] += speed
    seen, names = set(), channel_names(tuple(found.robot.joint_names), tuple(leg.name for leg in found.robot.legs))
    for _ in range(AFTER):
        found.plant.measure(found.controller.measurement)
        spoil(all_of(found.controller.measurement), j)
        found.plant.step(found.controller.tick())
        seen |= {names[k] for k in np.flatnonzero(found.groups.checking.readings.what)}
    return seen, found


def test_the_measurement_is_one_array():
    measurement = make_measurement(3)
    all_of(measurement)[:] = np.arange(27)
    np.testing.assert_array_equal(np.concatenate(measurement), np.arange(27))
    assert len(channel_names(("a", "b", "c"), ("left", "right"))) == 3 + 6 + 2 + 2


def test_missed_ticks_advance_the_clock_and_too_many_brake():
    found = loop("true")
    found.restart()
    found.controller.walk()
    found.run(500)
    before = float(found.groups.control.time[0])
    found.controller.missed(20)
    found.step()
    assert found.groups.control.time[0] == pytest.approx(before + 21e-3)
    assert found.controller.state == "walking"
    found.controller.missed(2000)
    found.step()
    assert found.controller.state == "fault"
    assert found.controller.telemetry.missed_ticks[0] == 2020
