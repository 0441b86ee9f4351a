"""Eq. 27: feedforward plus joint PD with the gains of the leg's role, inside the limits, never NaN."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.control.walking import parameters, records, robot

from gaitsmith.control.joint_torque import bounded_torque, make_joint_feedback

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
    gains = parameters("bhr_b2", "paper").joint_gains
    feedback = make_joint_feedback(gains)
    np.testing.assert_array_equal(feedback.stiffness, [gains.swing_stiffness, gains.stance_stiffness])
    np.testing.assert_array_equal(feedback.damping, [gains.swing_damping, gains.stance_damping])


@pytest.mark.parametrize("preset", ["default", "paper"])
def test_pd_of_the_leg_in_its_role(preset: str) -> None:
    """Walking: the gains of stance or swing; standing: the feedforward alone."""
    gains, machine, worked = parameters("bhr_b2", preset).joint_gains, robot("bhr_b2"), 0.0
    for record in records("bhr_b2", preset):
        control, step = record.groups.control, record.groups.step
        expected = record.groups.whole_body.torque.copy()
        if step.mode[0] == 1:
            for row, leg in enumerate(machine.legs):
                role = "stance" if row == step.stance[0] else "swing"
                stiffness, damping = (np.array(getattr(gains, f"{role}_{kind}")) for kind in ("stiffness", "damping"))
                own = leg.joint_indices
                expected[own] += stiffness * (control.joint_reference[own] - control.q[7 + own])
                expected[own] += damping * (control.joint_rate[own] - control.v[6 + own])
        worked = max(worked, float(np.max(np.abs(expected - record.groups.whole_body.torque))))
        expected = np.clip(expected, -machine.torque_limit, machine.torque_limit)
        np.testing.assert_allclose(control.torque, expected, rtol=0.0, atol=1e-10)
    assert (worked > 1.0) == (preset == "paper")
