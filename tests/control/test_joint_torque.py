"""Eq. 27: feedforward plus joint PD with the gains of the leg's role, inside the limits, never NaN."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.control.walking import Held, parameters

from gaitsmith.control.joint_torque import bounded_torque, braked_torque, held_torque, make_joint_feedback

anything = st.floats(allow_nan=True, allow_infinity=True)
limits = st.floats(0.0, 1e4)


@given(anything, anything, limits)
def test_always_a_number_within_limits(feedforward: float, feedback: float, limit: float) -> None:
    torque = bounded_torque(feedforward, feedback, limit)
    assert math.isfinite(torque)
    assert abs(torque) <= limit


@given(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3), limits)
def test_sum_clipped(feedforward: float, feedback: float, limit: float) -> None:
    expected = float(np.clip(feedforward + feedback, -limit, limit))
    assert bounded_torque(feedforward, feedback, limit) == expected


def test_what_is_not_a_number_is_no_torque() -> None:
    assert bounded_torque(math.nan, 1.0, 50.0) == 0.0
    assert bounded_torque(math.inf, -math.inf, 50.0) == 0.0
    assert bounded_torque(math.inf, 0.0, 50.0) == 50.0


def test_rows_are_swing_and_stance() -> None:
    """An empty list is no gain."""
    gains = parameters("bhr_b2", "paper").joint_gains
    feedback = make_joint_feedback(gains, 4)
    np.testing.assert_array_equal(feedback.stiffness, [gains.swing_stiffness, gains.stance_stiffness])
    np.testing.assert_array_equal(feedback.damping, [gains.swing_damping, gains.stance_damping])
    silent = make_joint_feedback(parameters("thbip_ii").joint_gains, 6)
    assert not np.any([silent.stiffness, silent.damping])


def test_pd_of_the_leg_in_its_role() -> None:
    """The gains of swing or stance on the difference from the reference, on top of the feedforward; none at a stand."""
    held = Held(chosen=parameters("bhr_b2", "paper", standing={"weight_shift": False}))
    for _ in range(3):
        held.q[10] += 1e-3
        np.testing.assert_allclose(held.tick(), held.groups.whole_body.solution.torque)
    held.controller.walk()
    rng = np.random.default_rng(0)
    for _ in range(20):
        held.stance_only()
    gains, control, body = held.controller.parameters.joint_gains, held.groups.control, held.groups.body
    last = control.torque.copy()
    held.q[7:] += rng.uniform(-0.01, 0.01, 8)
    held.stance_only()
    expected = held.groups.whole_body.solution.torque.copy()
    for row, leg in enumerate(held.robot.legs):
        role = "stance" if row == held.groups.template.step.stance[0] else "swing"
        stiffness, damping = (np.array(getattr(gains, f"{role}_{kind}")) for kind in ("stiffness", "damping"))
        own, joint = leg.joint_indices, held.groups.reference.joint
        expected[own] += stiffness * (joint[0, own] - body.q[7 + own]) + damping * (joint[1, own] - body.v[6 + own])
    assert np.max(np.abs(expected - held.groups.whole_body.solution.torque)) > 1.0
    step = float(held.groups.whole_body.joint_bounds.torque_step[0])
    limit = held.robot.torque_limit
    np.testing.assert_allclose(control.torque, np.clip(np.clip(expected, -limit, limit), last - step, last + step))


@given(limits, st.floats(-100.0, 100.0), st.floats(-3.0, 3.0))
def test_brakes_and_holds_act_against_the_motion(limit: float, speed: float, error: float) -> None:
    """Inside the limit; a joint that is held is drawn back with a torque that grows with the error."""
    brake, hold = 0.05, 0.5
    assert braked_torque(limit, speed, brake) * speed <= 0.0
    assert abs(braked_torque(limit, speed, brake)) == pytest.approx(limit * min(brake * abs(speed), 1.0))
    held = held_torque(limit, error, 0.0, hold, brake)
    assert held == pytest.approx(limit * float(np.clip(error / hold, -1.0, 1.0)))
    assert abs(held_torque(limit, error, speed, hold, brake)) <= limit
