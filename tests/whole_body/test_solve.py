"""The whole-body QP's solution obeys the dynamics, is the optimum, keeps to its bounds, and a failure is counted."""

from __future__ import annotations

import daqp
import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.control.walking import ROBOTS, Held, records, robot
from tests.qp.optimality import residual
from tests.whole_body.bodies import CONTACTS, Body, Engine, moving, standing

from gaitsmith.whole_body.reference import FLAT, NONE

Array = npt.NDArray[np.float64]

DYNAMICS = 1e-9  # of the largest force in the equation
OPTIMALITY = 1e-8  # scaled residual of the optimality conditions
ORACLE = 1e-6  # of the largest variable; the problems have condition numbers up to 1e8
BOUND = 1e-9  # of the limit: the solver's own tolerance

names = pytest.mark.parametrize("name", ROBOTS)
contacts = pytest.mark.parametrize("kinds", CONTACTS, ids=str)


def assert_dynamics(name: str, q: Array, v: Array, torque: Array, wrench: Array, acceleration: Array) -> None:
    """M q̈ + h = Sᵀ τ + Σ Jᵀ λ, with MuJoCo's M and h, and its Jacobians at the soles' origins."""
    engine = Engine(name, q, v)
    applied = np.concatenate([np.zeros(6), torque])
    for leg, felt in enumerate(wrench):
        applied += engine.sole(leg).jacobian.T @ felt
    inertial = engine.mass_matrix @ acceleration
    scale = max(float(np.max(np.abs(part))) for part in (applied, inertial, engine.bias))
    np.testing.assert_allclose(inertial + engine.bias, applied, rtol=0.0, atol=DYNAMICS * scale)


@names
@contacts
def test_equations_of_motion(name: str, kinds: tuple[int, int]) -> None:
    """Eq. 17, for soles that bear on the whole sole, on a line, on an edge, or not at all."""
    body = Body(name)
    for seed in range(5):
        q, v = moving(name, seed)
        assert body.place(q, v).solve(*kinds)
        result = body.result
        assert_dynamics(name, q, v, result.torque, result.wrench, result.acceleration)
        for leg, kind in enumerate(kinds):
            assert np.any(result.wrench[leg]) == (kind != NONE)


@names
def test_equations_of_motion_on_a_walk(name: str) -> None:
    """The same for what the tick leaves behind."""
    for record in records(name)[::4]:
        body, found = record.groups.body, record.groups.whole_body.solution
        assert_dynamics(name, body.q, body.v, found.torque, found.wrench, found.acceleration)


@names
@contacts
def test_the_solution_is_the_optimum(name: str, kinds: tuple[int, int]) -> None:
    body = Body(name)
    for seed in range(5):
        assert body.place(*moving(name, seed)).solve(*kinds)
        assert residual(body.program) < OPTIMALITY


@names
def test_problems_of_a_walk_have_the_oracles_solution(name: str) -> None:
    """Another solver finds the same torques and wrenches."""
    for record in records(name)[::6]:
        program = record.groups.whole_body.program
        n, m = program.size
        assert residual(program) < OPTIMALITY
        upper = np.concatenate([program.upper[:n], program.row_upper[:m]])
        lower = np.concatenate([program.lower[:n], program.row_lower[:m]])
        x, _, flag, _ = daqp.solve(
            np.ascontiguousarray(program.hessian[:n, :n]),
            program.gradient[:n].copy(),
            np.ascontiguousarray(program.rows[:m, :n]),
            np.minimum(upper, 1e30),
            np.maximum(lower, -1e30),
            np.zeros(n + m, dtype=np.int32),
            primal_tol=1e-11,
            dual_tol=1e-11,
        )
        assert flag == 1
        # Compared where it counts: by cost, in units of each variable's own curvature.
        unit = np.sqrt(np.diag(program.hessian)[:n])
        scale = float(np.max(np.abs(unit * x)))
        np.testing.assert_allclose(unit * program.solution[:n], unit * x, rtol=0.0, atol=ORACLE * scale)


@names
@settings(max_examples=15)
@given(seed=st.integers(0, 2**31), step=st.floats(0.0, 3.0))
def test_torques_keep_their_limits_and_their_rate(name: str, seed: int, step: float) -> None:
    """However wild the state: within the limit, and no further from the last torque than one step."""
    body, rng = Body(name), np.random.default_rng(seed)
    body.place(*moving(name, seed, 3.0))
    limit = body.robot.torque_limit
    last = body.result.torque[:] = rng.uniform(-1.0, 1.0, body.nj) * limit
    body.joints = body.joints._replace(torque_step=step)
    assert body.solve(FLAT, NONE, fresh=False)
    assert (np.abs(body.result.torque) <= limit * (1.0 + BOUND)).all()
    assert (np.abs(body.result.torque - last) <= step + BOUND * limit).all()


def test_the_first_torque_is_not_bound_to_the_one_before() -> None:
    """A robot that is switched on while it stands is held up at once."""
    body = Body("thbip_ii")
    body.joints = body.joints._replace(torque_step=1e-3)
    body.place(standing("thbip_ii"), np.zeros(body.robot.model.nv))
    assert body.solve(FLAT, FLAT, fresh=True)
    assert np.max(np.abs(body.result.torque)) > 1.0
    assert body.result.fresh[0] == 0


@names
def test_standing_bears_the_weight(name: str) -> None:
    """Both soles together carry the weight, each half of it, and nothing accelerates."""
    body = Body(name)
    body.reference.com_weight[:2] = body.reference.hip_height_weight[:] = 1.0
    body.reference.joint_weight[body.legs.leg_of_joint < 0] = 1.0
    body.place(standing(name), np.zeros(body.robot.model.nv))
    assert body.solve(FLAT, FLAT)
    weight = body.robot.mass * 9.81
    assert abs(np.sum(body.result.wrench[:, 2]) - weight) < 0.01 * weight
    assert abs(body.result.wrench[0, 2] - body.result.wrench[1, 2]) < 0.01 * weight
    assert np.max(np.abs(body.result.acceleration)) < 0.2


@names
def test_every_tick_of_a_walk_is_solved(name: str) -> None:
    last = records(name)[-1].groups.whole_body.solution
    assert last.solves[0] > 3000
    assert (last.fallbacks[0], last.infeasible[0]) == (0, 0)


def test_failure_is_counted_and_the_torque_fades() -> None:
    """A mass matrix that is not positive definite: the last torque decays, and the next good tick solves."""
    held = Held()
    for _ in range(20):
        held.tick()
    good, body = held.controller.telemetry.torque.copy(), held.groups.whole_body.solution
    mass = held.groups.body.tree.mass.copy()
    held.groups.body.tree.mass[:] = -mass
    for k in range(1, 11):
        torque = held.tick()
        assert (np.abs(torque) <= np.abs(good) * 0.98**k * (1.0 + 1e-12)).all()
        assert np.any(torque)
        assert (body.solves[0], body.fallbacks[0], body.infeasible[0]) == (20 + k, k, 0)
        assert held.controller.telemetry.qp_fallbacks[0] == k
        assert held.controller.telemetry.qp_status[0] != 0.0
    held.groups.body.tree.mass[:] = mass
    for _ in range(50):
        torque = held.tick()
    assert body.status[0] == 0
    knees = [leg.knee for leg in robot("bhr_b2").legs]
    np.testing.assert_allclose(torque[knees], good[knees], rtol=0.02)


def test_infeasible_is_told_apart() -> None:
    """Friction that no force can have: no solution, and counted as such."""
    body = Body("bhr_b2")
    body.place(standing("bhr_b2"), np.zeros(body.robot.model.nv))
    body.bounds = body.bounds._replace(friction=-1.0)
    assert not body.solve(FLAT, FLAT)
    assert (body.result.fallbacks[0], body.result.infeasible[0], body.result.stops_dropped[0]) == (1, 1, 0)
