"""The whole-body QP's solution obeys the dynamics and its bounds, and a failure is counted, bounded, and passes."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from tests.control.walking import ROBOTS, Held, records, robot
from tests.reference.rigid_body import RigidBody

DYNAMICS = 1e-9  # of the largest force in the equation
BOUND = 1e-9  # of the torque limit: the solver's own tolerance

names = pytest.mark.parametrize("name", ROBOTS)


@names
def test_equations_of_motion(name: str) -> None:
    """M q̈ + h = Sᵀ τ + Jᵀ λ (eq. 17), with MuJoCo's M, h, and J."""
    body = RigidBody(robot(name))
    for record in records(name):
        control, solved = record.groups.control, record.groups.whole_body
        now = body.at(control.q, control.v)
        applied = np.concatenate([np.zeros(6), solved.torque])
        for leg, sole in enumerate(now.soles):
            applied += sole.jacobian.T @ solved.wrench[leg]
        inertial = now.mass_matrix @ solved.acceleration
        scale = max(np.max(np.abs(part)) for part in (applied, inertial, now.bias))
        np.testing.assert_allclose(inertial + now.bias, applied, rtol=0.0, atol=DYNAMICS * scale)


@names
def test_inverse_dynamics_of_the_engine(name: str) -> None:
    """MuJoCo's inverse dynamics needs exactly these torques and wrenches for the predicted acceleration."""
    model = robot(name).model
    data = mujoco.MjData(model)
    for record in records(name)[::10]:
        control, solved, frames = record.groups.control, record.groups.whole_body, record.groups.frames
        data.qpos[:], data.qvel[:], data.qacc[:] = control.q, control.v, solved.acceleration
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        needed = np.zeros(model.nv)
        mujoco.mj_rne(model, data, 1, needed)
        needed += model.dof_armature * solved.acceleration
        for leg in range(2):
            needed -= frames.sole_jacobian[leg].T @ solved.wrench[leg]
        expected = np.concatenate([np.zeros(6), solved.torque])
        np.testing.assert_allclose(needed, expected, atol=1e-6)


@names
def test_torques_are_within_limits(name: str) -> None:
    limit = robot(name).torque_limit
    for record in records(name):
        assert (np.abs(record.groups.whole_body.torque) <= limit * (1.0 + BOUND)).all()
        assert (np.abs(record.groups.control.torque) <= limit).all()


@names
def test_a_sole_in_the_air_feels_nothing(name: str) -> None:
    """Two soles bear the robot while it stands, the stance sole alone while it walks."""
    seen = set()
    for record in records(name):
        step, solved, targets = record.groups.step, record.groups.whole_body, record.groups.targets
        bearing = [True, True] if step.mode[0] == 0 else [step.stance[0] == 0, step.stance[0] == 1]
        assert targets.in_contact.tolist() == bearing
        for leg in range(2):
            assert np.any(solved.wrench[leg]) == bearing[leg]
        seen.add(tuple(bearing))
    assert {(True, False), (False, True), (True, True)} <= seen


@names
def test_every_tick_is_solved(name: str) -> None:
    last = records(name)[-1].groups.whole_body
    assert last.counts[0] > 3000
    assert last.counts[1:].tolist() == [0, 0, 0]


def test_failure_is_counted_and_the_torque_fades() -> None:
    """A mass matrix that is not positive definite: the last torque decays, and the next good tick solves."""
    held = Held()
    for _ in range(20):
        held.tick()
    good = held.controller.telemetry.torque.copy()
    mass = held.groups.tree.mass.copy()
    held.groups.tree.mass[:] = -mass
    for k in range(1, 11):
        torque = held.tick()
        assert (np.abs(torque) <= np.abs(good) * 0.98**k * (1.0 + 1e-12)).all()
        assert np.isfinite(torque).all()
        assert held.groups.whole_body.counts.tolist() == [20 + k, k, 0, k]
        assert held.controller.telemetry.qp_fallbacks[0] == k
        assert held.controller.telemetry.qp_status[0] != 0.0
    held.groups.tree.mass[:] = mass
    for _ in range(50):
        torque = held.tick()
    assert held.groups.whole_body.counts[3] == 0
    knees = [leg.knee for leg in held.robot.legs]
    np.testing.assert_allclose(torque[knees], good[knees], rtol=0.02)


def test_infeasible_is_told_apart() -> None:
    """Limits that no torque satisfies count as infeasible."""
    held = Held()
    held.tick()
    held.groups.targets.torque_limit[0] = -1.0
    held.tick()
    assert held.groups.whole_body.counts.tolist() == [2, 1, 1, 1]
    assert held.controller.telemetry.qp_infeasible[0] == 1.0


def test_standing_still_bears_the_weight() -> None:
    """Both soles together carry the weight, each half of it, and nothing accelerates much."""
    held = Held()
    for _ in range(200):
        held.tick()
    solved = held.groups.whole_body
    weight = held.robot.mass * 9.81
    assert abs(np.sum(solved.wrench[:, 2]) - weight) < 0.01 * weight
    assert abs(solved.wrench[0, 2] - solved.wrench[1, 2]) < 0.01 * weight
    assert np.max(np.abs(solved.acceleration)) < 0.5
