from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitsmith.control.defaults import preset_parameters, robot_scale
from gaitsmith.estimation.filters import (
    correct_axis,
    filter_attitude,
    filter_joints,
    make_estimator_gains,
    make_estimator_state,
    predict_axis,
    turn_to_torso,
)
from gaitsmith.estimation.measurement import make_measurement
from gaitsmith.robots import load_robot

DT = 1e-3
ROUNDING = 1e-12  # absolute; all numbers are of order 1
BHR = load_robot("bhr_b2")
PARAMETERS = preset_parameters(BHR, robot_scale(BHR), "default").estimator
GAINS = make_estimator_gains(PARAMETERS, np.zeros(3), 30.0, 400.0)


def _matrix(row: np.ndarray) -> np.ndarray:
    pp, pv, pb, vv, vb, bb = row
    return np.array([[pp, pv, pb], [pv, vv, vb], [pb, vb, bb]])


def _filled(seed: int):
    rng = np.random.default_rng(seed)
    state = make_estimator_state(4)
    root = rng.normal(size=(3, 3))
    state.motion[1] = rng.normal(size=3)
    state.covariance[1] = (root @ root.T)[np.triu_indices(3)]
    return state, state.motion[1].copy(), _matrix(state.covariance[1])


@given(st.integers(0, 2**31), st.floats(-20.0, 20.0))
def test_prediction_is_the_matrix_formula(seed, acceleration):
    state, x, p = _filled(seed)
    h = 0.5 * DT**2
    transition = np.array([[1.0, DT, -h], [0.0, 1.0, -DT], [0.0, 0.0, 1.0]])
    enters = np.array([h, DT, 0.0])
    predict_axis(GAINS, state, 1, acceleration, DT)
    np.testing.assert_allclose(state.motion[1], transition @ x + enters * acceleration, atol=ROUNDING)
    noise = GAINS.accelerometer**2 * np.outer(enters, enters) + np.diag([0.0, 0.0, GAINS.accelerometer_drift**2 * DT])
    np.testing.assert_allclose(_matrix(state.covariance[1]), transition @ p @ transition.T + noise, atol=ROUNDING)


@given(st.integers(0, 2**31), st.booleans(), st.floats(-5.0, 5.0), st.floats(1e-3, 10.0))
def test_correction_is_the_matrix_formula(seed, of_velocity, measured, variance):
    state, x, p = _filled(seed)
    seen = np.eye(3)[1 if of_velocity else 0]
    gain = p @ seen / (seen @ p @ seen + variance)
    correct_axis(state, 1, of_velocity, measured, variance)
    np.testing.assert_allclose(state.motion[1], x + gain * (measured - seen @ x), atol=1e3 * ROUNDING)
    # Joseph's form: positive semidefinite by construction.
    joseph = (np.eye(3) - np.outer(gain, seen)) @ p @ (np.eye(3) - np.outer(gain, seen)).T
    joseph += variance * np.outer(gain, gain)
    np.testing.assert_allclose(_matrix(state.covariance[1]), joseph, atol=1e3 * ROUNDING)


def test_joint_rates_come_out_right_and_quieter():
    state, rng = make_estimator_state(2), np.random.default_rng(0)
    rate = np.array([0.0, 3.0])
    found = []
    for k in range(3000):
        angles = rate * k * DT + GAINS.encoder * rng.normal(size=2)
        filter_joints(GAINS, state, angles, DT)
        found.append(state.joint_velocity.copy())
    differences = math.sqrt(2.0) * GAINS.encoder / DT
    assert np.max(np.abs(np.mean(found[100:], axis=0) - rate)) < 0.01
    assert np.max(np.std(found[100:], axis=0)) < 0.4 * differences


@pytest.mark.parametrize("spin", [(0.0, 0.0, 0.0), (1.0, -2.0, 0.5)])
def test_attitude_follows_a_turn_and_forgets_a_wrong_start(spin):
    state, measurement = make_estimator_state(0), make_measurement(0)
    state.attitude_variance[0] = GAINS.attitude**2
    state.quaternion[:] = math.cos(0.1), math.sin(0.1), 0.0, 0.0
    measurement.gyro[:] = spin
    angle = np.linalg.norm(spin)
    for k in range(1, 3001):
        half = 0.5 * angle * k * DT
        measurement.base_quaternion[0] = math.cos(half)
        measurement.base_quaternion[1:] = math.sin(half) * np.array(spin) / (angle or 1.0)
        turn_to_torso(GAINS, state, measurement)
        filter_attitude(GAINS, state, measurement, DT)
    same = abs(float(state.quaternion @ measurement.base_quaternion))
    assert 2.0 * math.acos(min(same, 1.0)) < 1e-3
    assert np.linalg.norm(state.quaternion) == pytest.approx(1.0, abs=ROUNDING)
    np.testing.assert_allclose(state.angular_velocity, spin, atol=1e-9)


def test_attitude_variance_settles_where_the_riccati_equation_says():
    state, measurement = make_estimator_state(0), make_measurement(0)
    for _ in range(5000):
        turn_to_torso(GAINS, state, measurement)
        filter_attitude(GAINS, state, measurement, DT)
    q, r = (GAINS.gyro * DT) ** 2, GAINS.attitude**2
    assert state.attitude_variance[0] == pytest.approx((math.sqrt(q * q + 4 * q * r) - q) / 2, rel=1e-6)
