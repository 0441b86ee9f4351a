from __future__ import annotations

from typing import NamedTuple

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba.core.runtime import _nrt_python, rtsys
from tests.dynamics.pinocchio_model import evaluate
from tests.dynamics.trees import NAMES, model_of, random_state, relative_error, shifted

from gaitsmith.compiled import Arena, Matrix, Vector, bind, kernel
from gaitsmith.dynamics import Tree, TreeState, make_tree_state, point_bias, point_jacobian, read_tree, update_dynamics

ORACLE = 1e-9  # relative; what the specification asks, rounding is near 1e-15
STEP = 1e-5  # s; central differences of second order, so their own error is near 1e-9
DIFFERENCE = 1e-6  # relative, truncation and rounding of the above on fast random states

names = pytest.mark.parametrize("name", NAMES)
seeds = st.integers(0, 2**31)


@names
@settings(max_examples=25)
@given(seed=seeds)
def test_agrees_with_mujoco(name, seed):
    model, data, _, state, _, v = random_state(name, seed)
    mass_matrix = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass_matrix)
    com_jacobian, com_rate = np.zeros((3, model.nv)), np.zeros((3, model.nv))
    part, part_rate = np.zeros((3, model.nv)), np.zeros((3, model.nv))
    for body in range(1, model.nbody):
        share = model.body_mass[body] / np.sum(model.body_mass)
        mujoco.mj_jac(model, data, part, None, data.xipos[body], body)
        mujoco.mj_jacDot(model, data, part_rate, None, data.xipos[body], body)
        com_jacobian += share * part
        com_rate += share * part_rate
    assert relative_error(state.body_position, data.xpos) < ORACLE
    assert relative_error(state.body_rotation.reshape(-1, 9), data.xmat) < ORACLE
    assert relative_error(state.mass_matrix, mass_matrix) < ORACLE
    assert relative_error(state.bias, data.qfrc_bias) < ORACLE
    assert relative_error(state.com, data.subtree_com[0]) < ORACLE
    assert relative_error(state.com_velocity, data.subtree_linvel[0]) < ORACLE
    assert relative_error(state.com_jacobian, com_jacobian) < ORACLE
    assert relative_error(state.com_bias, com_rate @ v) < ORACLE


@names
@settings(max_examples=10)
@given(seed=seeds)
def test_agrees_with_pinocchio(name, seed):
    model, _, _, state, q, v = random_state(name, seed)
    oracle = evaluate(model, q, v, model.nbody - 1, np.zeros(3))
    assert relative_error(state.body_position[-1], oracle.pose.translation) < ORACLE
    assert relative_error(state.body_rotation[-1], oracle.pose.rotation) < ORACLE
    assert relative_error(state.mass_matrix, oracle.mass_matrix) < ORACLE
    assert relative_error(state.bias, oracle.bias) < ORACLE
    assert relative_error(state.com, oracle.com) < ORACLE
    assert relative_error(state.com_velocity, oracle.com_velocity) < ORACLE
    assert relative_error(state.com_jacobian, oracle.com_jacobian) < ORACLE
    assert relative_error(state.com_bias, oracle.com_bias) < ORACLE


@names
def test_mass_matrix_is_symmetric_and_positive_definite(name):
    state = random_state(name, 1).state
    np.testing.assert_array_equal(state.mass_matrix, state.mass_matrix.T)
    assert np.min(np.linalg.eigvalsh(state.mass_matrix)) > 0.0


@names
def test_bias_does_the_work_that_the_kinetic_energy_gains(name):
    """While v is constant, d/dt (½ vᵀ M v) = vᵀ (bias - gravity)."""
    model, _, tree, state, q, v = random_state(name, 2)
    bias = state.bias.copy()
    update_dynamics(tree, state, q, np.zeros(model.nv))
    gained = v @ (bias - state.bias)
    energy = []
    for step in (-STEP, STEP):
        update_dynamics(tree, state, shifted(model, q, v, step), v)
        energy.append(0.5 * v @ state.mass_matrix @ v)
    assert gained == pytest.approx((energy[1] - energy[0]) / (2.0 * STEP), rel=DIFFERENCE)


@names
def test_gravity_pulls_at_the_centre_of_mass(name):
    model, _, tree, state, q, _ = random_state(name, 3)
    update_dynamics(tree, state, q, np.zeros(model.nv))
    assert relative_error(state.bias, -tree.total_mass * state.com_jacobian.T @ tree.gravity) < ORACLE


@names
def test_centre_of_mass_moves_as_its_jacobian_says(name):
    model, _, tree, state, q, v = random_state(name, 4)
    velocity, bias = state.com_jacobian @ v, state.com_bias.copy()
    places, velocities = [], []
    for step in (-STEP, STEP):
        update_dynamics(tree, state, shifted(model, q, v, step), v)
        places.append(state.com.copy())
        velocities.append(state.com_jacobian @ v)
    assert relative_error((places[1] - places[0]) / (2.0 * STEP), velocity) < DIFFERENCE
    assert relative_error((velocities[1] - velocities[0]) / (2.0 * STEP), bias) < DIFFERENCE


def test_far_from_the_origin_nothing_is_lost():
    near = random_state("bhr_b2", 5)
    q = near.q.copy()
    q[:2] += 1000.0
    far = make_tree_state(near.tree)
    update_dynamics(near.tree, far, q, near.v)
    assert relative_error(far.mass_matrix, near.state.mass_matrix) < ORACLE
    assert relative_error(far.bias, near.state.bias) < ORACLE


def test_quaternions_of_any_length_mean_the_same():
    _model, _, tree, state, q, v = random_state("bhr_b2", 6)
    scaled = q.copy()
    scaled[3:7] *= 7.0
    other = make_tree_state(tree)
    update_dynamics(tree, other, scaled, v)
    assert relative_error(other.mass_matrix, state.mass_matrix) < ORACLE
    scaled[3:7] = 0.0
    update_dynamics(tree, other, scaled, v)
    np.testing.assert_array_equal(other.body_rotation[1], np.eye(3))


def test_a_new_robot_compiles_nothing():
    random_state(NAMES[0], 0)
    known = len(update_dynamics.signatures)
    for name in NAMES:
        random_state(name, 0)
    assert len(update_dynamics.signatures) == known == 1


class Call(NamedTuple):
    """What the allocation test passes besides the tree."""

    q: Vector
    v: Vector
    point: Vector
    jacobian: Matrix
    bias: Vector


class Bound(NamedTuple):
    """All that the allocation test binds."""

    tree: Tree
    state: TreeState
    work: Call


@kernel
def call(address: int, body: int, times: int) -> None:
    g = bind(Bound, address)
    for _ in range(times):
        update_dynamics(g.tree, g.state, g.work.q, g.work.v)
        point_jacobian(g.tree, g.state, body, g.work.point, g.work.jacobian)
        point_bias(g.tree, g.state, body, g.work.point, g.work.bias)


def test_allocates_nothing():
    model = model_of("bhr_b2")
    tree = read_tree(model)
    work = Call(model.qpos0.copy(), np.ones(model.nv), np.ones(3), np.zeros((6, model.nv)), np.zeros(6))
    arena = Arena(Bound(tree, make_tree_state(tree), work))
    arguments = (arena.address, model.nbody - 1)
    call(*arguments, 1)
    _nrt_python.memsys_enable_stats()
    before = rtsys.get_allocation_stats()
    call(*arguments, 1000)
    assert rtsys.get_allocation_stats() == before
