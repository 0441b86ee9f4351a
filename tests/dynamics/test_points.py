from __future__ import annotations

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.dynamics.pinocchio_model import evaluate
from tests.dynamics.trees import NAMES, State, random_state, relative_error, shifted

from gaitsmith.dynamics import point_bias, point_jacobian, point_velocity, sole_pose, update_dynamics

ORACLE = 1e-9  # relative; what the specification asks, rounding is near 1e-15
STEP = 1e-5  # s; central differences of second order, so their own error is near 1e-9
DIFFERENCE = 1e-6  # relative, truncation and rounding of the above on fast random states

names = pytest.mark.parametrize("name", NAMES)
INSIDE = np.array([0.1, -0.05, 0.2])  # the point, in body axes


def _point(now: State, body: int) -> np.ndarray:
    return now.state.body_position[body] + now.state.body_rotation[body] @ INSIDE


def _jacobian(now: State, body: int) -> np.ndarray:
    out = np.full((6, now.model.nv), np.nan)
    point_jacobian(now.tree, now.state, body, _point(now, body), out)
    return out


def _bias(now: State, body: int) -> np.ndarray:
    out = np.full(6, np.nan)
    point_bias(now.tree, now.state, body, _point(now, body), out)
    return out


@names
@settings(max_examples=20)
@given(seed=st.integers(0, 2**31), data=st.data())
def test_agrees_with_mujoco_and_pinocchio(name, seed, data):
    now = random_state(name, seed)
    model, nv = now.model, now.model.nv
    body = data.draw(st.integers(1, model.nbody - 1))
    point = _point(now, body)
    jacobian, rate = np.zeros((6, nv)), np.zeros((6, nv))
    mujoco.mj_jac(model, now.data, jacobian[:3], jacobian[3:], point, body)
    mujoco.mj_jacDot(model, now.data, rate[:3], rate[3:], point, body)
    oracle = evaluate(model, now.q, now.v, body, INSIDE)
    for expected in (jacobian, oracle.jacobian):
        assert relative_error(_jacobian(now, body), expected) < ORACLE
    for expected in (rate @ now.v, oracle.point_bias):
        assert relative_error(_bias(now, body), expected) < ORACLE


@names
def test_velocity_is_the_jacobian_times_v(name):
    now = random_state(name, 1)
    other = np.random.default_rng(1).normal(size=now.model.nv)
    for body in range(now.model.nbody):
        out = np.zeros(6)
        point_velocity(now.tree, now.state, body, _point(now, body), other, out)
        assert relative_error(out, _jacobian(now, body) @ other) < ORACLE


@names
def test_jacobian_and_bias_are_the_derivatives(name):
    now = random_state(name, 2)
    for body in range(1, now.model.nbody):
        update_dynamics(now.tree, now.state, now.q, now.v)
        velocity, bias = _jacobian(now, body) @ now.v, _bias(now, body)
        turn = now.state.body_rotation[body].copy()
        places, turns, velocities = [], [], []
        for step in (-STEP, STEP):
            update_dynamics(now.tree, now.state, shifted(now.model, now.q, now.v, step), now.v)
            places.append(_point(now, body))
            turns.append(now.state.body_rotation[body].copy())
            velocities.append(_jacobian(now, body) @ now.v)
        spin = (turns[1] - turns[0]) / (2.0 * STEP) @ turn.T
        got = np.concatenate([(places[1] - places[0]) / (2.0 * STEP), [spin[2, 1], spin[0, 2], spin[1, 0]]])
        assert relative_error(got, velocity) < DIFFERENCE
        assert relative_error((velocities[1] - velocities[0]) / (2.0 * STEP), bias) < DIFFERENCE


def test_the_world_does_not_move():
    now = random_state("bhr_b2", 3)
    assert not np.any(_jacobian(now, 0))
    assert not np.any(_bias(now, 0))


@pytest.mark.parametrize("name", ["bhr_b2", "planar", "with_arms"])
def test_sole_pose_agrees_with_mujoco(name):
    model, data, tree, state, _, _ = random_state(name, 0)
    for site in range(model.nsite):
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, model.site_quat[site])
        position, rotation = np.zeros(3), np.zeros((3, 3))
        body = int(model.site_bodyid[site])
        sole_pose(tree, state, body, model.site_pos[site].copy(), turn.reshape(3, 3), position, rotation)
        np.testing.assert_allclose(position, data.site_xpos[site], rtol=ORACLE, atol=ORACLE)
        np.testing.assert_allclose(rotation.ravel(), data.site_xmat[site], atol=ORACLE)
