"""References of soles and joints: frames, pitch interpolation, PD of eqs. 20-22, the ankle's soft torque."""

from __future__ import annotations

from functools import cache

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.control.walking import ROBOTS, Held, Record, parameters, records, robot
from tests.reference.rigid_body import Instant, RigidBody

from gaitsmith.control.references import swing_pitch
from gaitsmith.robots.parameters import GaitParameters
from gaitsmith.template.step import RIGHT, make_gait, make_step_state

Array = npt.NDArray[np.float64]

SAME = 1e-9  # relative, two ways to compute the same

names = pytest.mark.parametrize("name", ROBOTS)


@cache
def body(name: str) -> RigidBody:
    return RigidBody(robot(name))


def instant(name: str, record: Record) -> Instant:
    return body(name).at(record.groups.control.q, record.groups.control.v)


def close(actual: Array, expected: Array) -> None:
    np.testing.assert_allclose(actual, expected, rtol=0.0, atol=SAME * max(1.0, float(np.max(np.abs(expected)))))


@given(st.floats(-0.5, 0.5), st.floats(0.2, 0.8), st.floats(0.2, 1.0), st.floats(0.0, 2.0))
def test_swing_pitch_fades_over_the_lifting_stage(start: float, alpha: float, period: float, share: float) -> None:
    """From the pitch at the switch, at rest, to level at αT; never beyond either."""
    step = make_step_state()
    gait = make_gait(GaitParameters(period=period, alpha=alpha, height=0.7, lift=0.1, width=0.04))
    step.swing_pitch_start[0] = start

    def at(time: float) -> float:
        step.time[0] = time
        return float(swing_pitch(step, gait))

    assert at(0.0) == start
    assert abs(at(share * period)) <= abs(start)
    assert abs(at(alpha * period)) <= 1e-12
    assert at(1.5 * period) == 0.0
    edge = 1e-6 * period
    assert abs(at(edge) - start) <= 1e-9
    assert abs(at(alpha * period - edge)) <= 1e-9


@names
def test_swing_acceleration(name: str) -> None:
    """Eq. 20 with the template's own acceleration."""
    tracking = parameters(name).tracking
    for record in records(name):
        if record.groups.step.mode[0] == 0:
            continue
        swing = 1 - int(record.groups.step.stance[0])
        desired = record.groups.control.foot_desired[3 * swing : 3 * swing + 3]
        actual = instant(name, record).offset(swing)
        expected = desired[2] + tracking.foot_stiffness * (desired[0] - actual[0])
        expected += tracking.foot_damping * (desired[1] - actual[1])
        close(record.groups.targets.swing_acceleration[swing], expected)


@names
def test_joint_acceleration(name: str) -> None:
    """Eq. 22 for the legs' joints; the others go back to zero."""
    machine, tracking, others = robot(name), parameters(name).tracking, parameters(name).other_joints
    for record in records(name):
        control, found = record.groups.control, record.groups.targets.joint_acceleration
        q, v = control.q[7:], control.v[6:]
        own = np.concatenate([leg.joint_indices for leg in machine.legs])
        rest = np.setdiff1d(np.arange(len(q)), own)
        if len(rest):
            close(found[rest], -others.stiffness * q[rest] - others.damping * v[rest])
        if record.groups.step.mode[0] == 1:
            error, rate_error = control.joint_reference - q, control.joint_rate - v
            expected = tracking.joint_stiffness * error + tracking.joint_damping * rate_error
            close(found[own], expected[own])


@names
def test_joint_references_stay_within_limits(name: str) -> None:
    machine = robot(name)
    for record in records(name):
        if record.groups.step.mode[0] == 1:
            for row, leg in enumerate(machine.legs):
                reference, rate = record.groups.control.leg_reference[row], record.groups.control.leg_rate[row]
                own = leg.joint_indices
                assert (reference >= machine.position_low[own]).all()
                assert (reference <= machine.position_high[own]).all()
                assert (np.abs(rate) <= machine.velocity_limit[own] * (1.0 + 1e-9)).all()


@names
def test_swing_reference_reaches_for_the_template(name: str) -> None:
    """In the second half of a step the sole of the reference leg is where the template wants it."""
    missed = []
    for record in records(name):
        step, control = record.groups.step, record.groups.control
        period = record.groups.latched.period[0]
        if step.mode[0] == 1 and 0.6 * period < step.time[0] < period:
            swing = 1 - int(step.stance[0])
            leg, now = robot(name).legs[swing], instant(name, record)
            position, _, _ = body(name).leg_pose(leg, control.leg_reference[swing])
            wanted = now.hip.rotation.T @ now.heading @ control.foot_desired[3 * swing]
            missed.append(np.linalg.norm(position - robot(name).hip_midpoint - wanted))
    assert len(missed) > 10
    assert np.median(missed) < 0.02


@names
def test_standing_targets(name: str) -> None:
    """CoM towards the middle of the soles, hips towards the standing height, both damped."""
    standing = parameters(name).standing
    for record in records(name):
        if record.groups.step.mode[0] == 1:
            continue
        now = instant(name, record)
        middle = 0.5 * (now.soles[0].position + now.soles[1].position)
        error = now.in_heading(middle - now.com.position)
        error[2] = record.groups.control.standing_height[0] - (now.hip.position - middle)[2]
        rate = now.com_velocity
        rate[2] = -0.5 * (now.offset(0)[1, 2] + now.offset(1)[1, 2])
        expected = standing.com_stiffness * error - standing.com_damping * rate
        close(record.groups.targets.body_acceleration, expected)


@pytest.mark.parametrize("speed", [-3.0, -0.3, 0.0, 0.2, 3.0])
def test_ankle_presses_the_toe_down_when_too_fast(speed: float) -> None:
    """Proportional to the speed error, bounded, along the ankle's own sign; nothing while standing."""
    held, ankle = Held(), parameters("bhr_b2").ankle
    held.v[0] = speed
    held.tick()
    assert not np.any(held.groups.targets.ankle_torque)
    held.controller.walk()
    held.tick()
    wanted = float(np.clip(ankle.speed_gain * speed, -ankle.torque_limit, ankle.torque_limit))
    expected = held.groups.legs.ankle_sign * wanted
    np.testing.assert_allclose(held.groups.targets.ankle_torque, expected, atol=1e-9)


def test_stance_sole_is_tracked_as_it_is() -> None:
    """x and y of the support sole follow the robot; only its height is planned."""
    for record in records("bhr_b2"):
        if record.groups.step.mode[0] == 1:
            stance = int(record.groups.step.stance[0])
            desired = record.groups.control.foot_desired[3 * stance : 3 * stance + 3]
            np.testing.assert_array_equal(desired[:2, :2], record.groups.frames.relative[stance, :, :2])
    assert {int(record.groups.step.stance[0]) for record in records("bhr_b2")} == {1 - RIGHT, RIGHT}
