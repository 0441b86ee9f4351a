"""The QP's cost is the documented one, and its solution does what the tasks ask for."""

from __future__ import annotations

from functools import cache

import numpy as np
import numpy.typing as npt
import pytest
from tests.control.walking import ROBOTS, Held, Record, parameters, records, robot
from tests.reference.rigid_body import Instant, RigidBody
from tests.reference.whole_body import Problem, Wishes, assemble

Array = npt.NDArray[np.float64]

STILL = 0.1  # m/s², of a stance sole
SAME = 1e-11  # of the largest entry: sums of products in another order

names = pytest.mark.parametrize("name", ROBOTS)


@cache
def body(name: str) -> RigidBody:
    return RigidBody(robot(name))


def instant(name: str, record: Record) -> Instant:
    return body(name).at(record.groups.control.q, record.groups.control.v)


def wishes(record: Record) -> Wishes:
    """What the compiled tick asked for."""
    targets, step = record.groups.targets, record.groups.step
    asked = Wishes(targets.joint_acceleration.copy(), targets.joint_weight.copy())
    if step.mode[0] == 0:
        asked.body_acceleration = targets.body_acceleration
        return asked
    stance = int(step.stance[0])
    asked.stance = (stance,)
    asked.swing_acceleration = targets.swing_acceleration[1 - stance]
    asked.ankle_torque = float(targets.ankle_torque[stance])
    return asked


def reference(name: str, record: Record) -> Problem:
    """The problem that a tick should have solved."""
    return assemble(robot(name), parameters(name), instant(name, record), wishes(record), record.feedforward)


@names
def test_cost_is_that_of_the_reference(name: str) -> None:
    """Hessian and gradient, entry by entry, of ticks of every kind."""
    for record in records(name)[::4]:
        problem = reference(name, record)
        program = record.groups.program
        n = program.size[0]
        hessian, gradient = program.hessian[:n, :n], program.gradient[:n]
        np.testing.assert_array_equal(hessian, hessian.T)
        scale = float(np.max(np.abs(problem.cost.hessian)))
        np.testing.assert_allclose(hessian, problem.cost.hessian, rtol=0.0, atol=SAME * scale)
        scale = float(np.max(np.abs(problem.cost.gradient)))
        np.testing.assert_allclose(gradient, problem.cost.gradient, rtol=0.0, atol=SAME * 100.0 * scale)
        np.testing.assert_array_equal(program.lower[:n], problem.low)
        np.testing.assert_array_equal(program.upper[:n], problem.high)


@names
def test_stance_soles_do_not_accelerate(name: str) -> None:
    """Eq. 18 in the predicted motion, but where bounds or a push leave no choice."""
    left = []
    for record in records(name):
        now = instant(name, record)
        for leg in range(2):
            if record.groups.targets.in_contact[leg]:
                motion = now.soles[leg].jacobian @ record.groups.whole_body.acceleration + now.soles[leg].bias
                left.append(np.linalg.norm(motion[:3]))
    assert np.median(left) < STILL


@names
def test_swing_sole_accelerates_as_asked(name: str) -> None:
    """Eq. 19: left alone by the joints' references, the sole moves as the template wants, relative to the hips."""
    alone = {**dict.fromkeys(("swing_joint", "swing_ankle"), 1e-4), "swing_foot": 100.0, "regularisation": 1e-6}
    held = Held(name, parameters(name, weights={**alone, "torque_change": 1e-6}))
    held.controller.walk()
    for _ in range(30):
        held.tick()
    swing = 1 - int(held.groups.step.stance[0])
    now = body(name).at(held.groups.control.q, held.groups.control.v)
    acceleration = held.groups.whole_body.acceleration
    motion = (now.soles[swing].jacobian - now.hip.jacobian) @ acceleration + now.soles[swing].bias - now.hip.bias
    target = held.groups.targets.swing_acceleration[swing]
    assert np.linalg.norm(target) > 1.0
    assert np.linalg.norm(now.in_heading(motion[:3]) - target) < 0.02 * np.linalg.norm(target)


@names
def test_torso_is_pulled_upright(name: str) -> None:
    """Eq. 21: the predicted roll and pitch acceleration oppose the tilt where the tilt is large."""
    attitude = parameters(name).attitude
    for record in records(name):
        frames = record.groups.frames
        wanted = -np.array([attitude.roll_stiffness, attitude.pitch_stiffness]) * frames.tilt[:2]
        wanted -= np.array([attitude.roll_damping, attitude.pitch_damping]) * frames.tilt[2:]
        if np.linalg.norm(wanted) > 20.0:
            now = instant(name, record)
            turn = now.in_heading((now.hip.jacobian @ record.groups.whole_body.acceleration + now.hip.bias)[3:])[:2]
            assert turn @ wanted > 0.0


def test_weights_go_to_the_right_joints() -> None:
    """Eqs. 22 and 23: the swing leg's joints, the stance knee, arms always; nothing of a leg while standing."""
    for name in ROBOTS:
        machine, weights = robot(name), parameters(name).weights
        for record in records(name)[::5]:
            step, weight = record.groups.step, record.groups.targets.joint_weight
            for row, leg in enumerate(machine.legs):
                expected = np.zeros(len(leg.joints))
                order = list(leg.joint_indices)
                if step.mode[0] == 1 and row == step.stance[0]:
                    expected[order.index(leg.knee)] = weights.knee
                elif step.mode[0] == 1:
                    expected[:] = weights.swing_joint
                    expected[order.index(leg.ankle_pitch)] = weights.swing_ankle
                np.testing.assert_array_equal(weight[leg.joint_indices], expected)
            others = np.setdiff1d(np.arange(len(weight)), np.concatenate([leg.joint_indices for leg in machine.legs]))
            np.testing.assert_array_equal(weight[others], weights.other_joint)
