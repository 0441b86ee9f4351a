"""Sensor errors have the statistics that they claim, and nothing leaks that sensors cannot know."""

from __future__ import annotations

import numpy as np
import pytest
from tests.simulation.standing import posture, robot

from gaitsmith.estimation.measurement import make_measurement
from gaitsmith.simulation.plant import Plant
from gaitsmith.simulation.sensors import SensorNoise

SAMPLES = 20_000
SPREAD = 0.03  # relative: a standard deviation from 20,000 samples is known to 0.5 %


@pytest.fixture(scope="module")
def readings():
    """True and noisy measurements of a robot that doesn't move."""
    noise, true, noisy = SensorNoise(), Plant(robot()), Plant(robot(), sensors=SensorNoise(), seed=5)
    exact, measured = make_measurement(8), make_measurement(8)
    true.reset(posture())
    noisy.reset(posture())
    true.measure(exact)
    rows = []
    for _ in range(SAMPLES):
        noisy.measure(measured)
        rows.append(np.concatenate([np.copy(part) for part in measured]))
    return noise, exact, np.array(rows)


def _part(rows, name):
    sizes = dict(zip(make_measurement(8)._fields, (len(p) for p in make_measurement(8)), strict=True))
    start = 0
    for field, size in sizes.items():
        if field == name:
            return rows[:, start : start + size]
        start += size
    raise KeyError(name)


def test_gyro_and_accelerometer_noise(readings):
    noise, exact, rows = readings
    for name, deviation in (("gyro", noise.gyro), ("accelerometer", noise.accelerometer)):
        np.testing.assert_allclose(np.std(_part(rows, name), axis=0), deviation, rtol=SPREAD)
    bias = np.mean(_part(rows, "accelerometer"), axis=0) - exact.accelerometer
    assert np.linalg.norm(bias) == pytest.approx(noise.accelerometer_bias, rel=SPREAD)
    np.testing.assert_allclose(np.mean(_part(rows, "gyro"), axis=0), exact.gyro, atol=5 * noise.gyro / SAMPLES**0.5)


def test_encoders_are_noisy_and_quantised(readings):
    noise, exact, rows = readings
    angles = _part(rows, "joint_position")
    expected = np.hypot(noise.encoder, noise.encoder_step / 12**0.5)
    np.testing.assert_allclose(np.std(angles, axis=0), expected, rtol=SPREAD)
    np.testing.assert_allclose(np.mean(angles, axis=0), exact.joint_position, atol=1e-5)
    steps = angles / noise.encoder_step
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)


def test_attitude_is_a_unit_quaternion_off_by_a_small_rotation(readings):
    noise, exact, rows = readings
    attitude = _part(rows, "base_quaternion")
    np.testing.assert_allclose(np.linalg.norm(attitude, axis=1), 1.0, atol=1e-12)
    # The posture is upright, so twice the vector part is the rotation vector.
    np.testing.assert_allclose(np.std(2 * attitude[:, 1:], axis=0), noise.attitude, rtol=SPREAD)
    np.testing.assert_allclose(exact.base_quaternion, [1, 0, 0, 0], atol=1e-12)


def test_what_no_sensor_measures_is_not_given_away(readings):
    _, _, rows = readings
    for name in ("base_position", "base_velocity", "joint_velocity"):
        assert not np.any(_part(rows, name))


def test_sole_forces_are_noisy_in_shares_of_the_weight(readings):
    noise, _, rows = readings
    forces = _part(rows, "sole_force")
    loaded = forces[:, forces.mean(axis=0) > 50.0]
    weight = robot().model.body_subtreemass[robot().torso_body] * 9.81
    np.testing.assert_allclose(np.std(loaded, axis=0), noise.sole_force * weight, rtol=SPREAD)
    assert np.all(forces >= 0.0)


def test_noise_is_white(readings):
    _, _, rows = readings
    gyro = _part(rows, "gyro")[:, 0]
    gyro = (gyro - gyro.mean()) / gyro.std()
    # The estimate's own standard deviation is 1/sqrt(n) = 0.007.
    assert abs(np.mean(gyro[1:] * gyro[:-1])) < 0.03


def test_the_same_seed_gives_the_same_noise_after_a_reset():
    plant, measured = Plant(robot(), sensors=SensorNoise(), seed=9), make_measurement(8)
    runs = []
    for _ in range(2):
        plant.reset(posture())
        rows = []
        for _ in range(1100):
            plant.measure(measured)
            rows.append(measured.gyro.copy())
        runs.append(rows)
    np.testing.assert_array_equal(*runs)
