"""The IMU measures in its own axes, and a controller that knows its mounting does not notice."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from tests.simulation.standing import posture, robot

from gaitsmith.estimation.measurement import make_measurement
from gaitsmith.simulation.episode import run_episode
from gaitsmith.simulation.plant import Plant
from gaitsmith.simulation.scenario import make_scenario

QUARTER = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
EXACT = dict.fromkeys(["gyro", "accelerometer", "accelerometer_bias", "encoder", "encoder_step", "attitude"], 0.0)


def _turned():
    return dataclasses.replace(robot(), imu_rotation=QUARTER)


def test_a_turned_imu_reads_in_its_own_axes():
    rng, readings = np.random.default_rng(2), []
    torques = rng.uniform(-20.0, 20.0, (40, 8))
    for made in (robot(), _turned()):
        plant, measured = Plant(made), make_measurement(8)
        plant.reset(posture())
        for torque in torques:
            plant.step(torque)
        plant.measure(measured)
        readings.append((measured.accelerometer.copy(), measured.gyro.copy()))
    for straight, turned in zip(*readings, strict=True):
        np.testing.assert_allclose(QUARTER @ turned, straight, atol=1e-9)
        assert np.linalg.norm(straight - turned) > 0.05


def test_a_turned_imu_gives_the_same_walk():
    fields = {"duration": 1.5, "rest_before": 0.2, "state": "estimated", "sensors": EXACT, "speed": 0.1}
    straight, turned = (run_episode(make_scenario(fields), robot=made).log for made in (robot(), _turned()))
    assert straight.column("mode")[-1] == 1.0
    # Rotating readings there and back rounds; a walk does not amplify it much within a second.
    assert np.abs(straight.rows - turned.rows)[:, 0:1].max() == 0.0
    assert turned.column("true.torso_x") == pytest.approx(straight.column("true.torso_x"), abs=1e-6)
    assert turned.column("tilt.pitch") == pytest.approx(straight.column("tilt.pitch"), abs=1e-6)
