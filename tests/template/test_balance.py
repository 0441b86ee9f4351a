"""The divergent component's reference is a periodic walk's; the centre of pressure and the weight shift lead to it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.template.steps import HEIGHT, OMEGA, Array, a_step, gains, inputs, swing

from gaitsmith.template.balance import CopGains, divergent_reference, shift_acceleration, stance_cop

sides = st.sampled_from([-1.0, 1.0])
speeds = st.tuples(st.floats(-0.4, 0.4), st.floats(-0.2, 0.2))
periods = st.floats(0.25, 0.6)
widths = st.floats(0.03, 0.1)


def reference(speed: tuple[float, float], period: float, width: float, side: float, time: float) -> Array:
    """ξ relative to the stance sole that the walk is to have."""
    gait, out = inputs(speed=speed, period=period, width=width), np.zeros(2)
    divergent_reference(a_step(gait), gait, gains(), HEIGHT, side, time, out)
    return out


@given(speeds, periods, widths, sides)
def test_the_reference_is_that_of_a_periodic_walk(
    speed: tuple[float, float], period: float, width: float, side: float
) -> None:
    """A pendulum that starts with it, its pivot at the sole, has it all the time, step after step.

    The stride is v T forward, and the soles are 2 W ± v T apart.
    """
    for _ in range(4):
        arm = np.array([-0.5 * period * speed[0], 0.0])  # any: ξ alone diverges
        start = reference(speed, period, width, side, 0.0)
        velocity = OMEGA * (start - arm)
        for time in np.linspace(0.0, period, 5):
            here, rate = swing(arm, velocity, float(time))
            np.testing.assert_allclose(
                here + rate / OMEGA, reference(speed, period, width, side, float(time)), atol=1e-9
            )
        # The next sole: one stride ahead and on the other side; ξ relative to it is that side's start.
        stride = np.array([period * speed[0], side * 2.0 * width + period * speed[1]])
        end = reference(speed, period, width, side, period) - stride
        np.testing.assert_allclose(end, reference(speed, period, width, -side, 0.0), atol=1e-9)
        side = -side


@given(speeds, periods)
def test_the_reference_waits_for_a_late_sole(speed: tuple[float, float], period: float) -> None:
    """Past the step's end it stays where it was."""
    late, end = (reference(speed, period, 0.06, 1.0, time) for time in (1.5 * period, period))
    np.testing.assert_array_equal(late, end)


@settings(max_examples=20)
@given(st.tuples(st.floats(-0.02, 0.02), st.floats(-0.02, 0.02)), st.floats(0.5, 4.0), st.floats(0.5, 4.0))
def test_the_centre_of_pressure_brings_the_divergent_component_back(error: Array, x: float, y: float) -> None:
    """A gain above zero makes ξ̇ = ω (ξ - p) converge: p = k e gives ė = ω (1 - k) e beside the reference's own."""
    law, out = CopGains(1.0 + x, 1.0 + y, 0.0), np.zeros(2)
    period, width, dt = 0.4, 0.06, 5e-4
    start = reference((0.2, 0.05), period, width, 1.0, 0.0) + error
    arm, velocity = np.zeros(2), OMEGA * start
    for k in range(400):
        wanted = reference((0.2, 0.05), period, width, 1.0, k * dt)
        stance_cop(law, OMEGA, arm, velocity, wanted, out)
        acceleration = OMEGA**2 * (arm - out)
        arm, velocity = arm + dt * velocity, velocity + dt * acceleration
    left = arm + velocity / OMEGA - reference((0.2, 0.05), period, width, 1.0, 0.2)
    expected = np.abs(error) * np.exp(-OMEGA * np.array([x, y]) * 0.2)
    assert (np.abs(left) <= 1.1 * expected + 2e-3).all()


def test_the_centre_of_pressure_is_at_the_sole_on_the_reference() -> None:
    """And on the side to which ξ is too far: the pressure pushes it back."""
    law, out = CopGains(2.0, 3.0, 0.0), np.zeros(2)
    wanted = np.array([0.03, 0.05])
    stance_cop(law, OMEGA, np.array([0.02, 0.04]), np.array([0.01, 0.01]) * OMEGA, wanted, out)
    np.testing.assert_allclose(out, 0.0, atol=1e-15)
    stance_cop(law, OMEGA, np.array([0.03, 0.04]), np.array([0.01, 0.02]) * OMEGA, wanted, out)
    np.testing.assert_allclose(out, [0.02, 0.03])


@pytest.mark.parametrize("wanted", [0.01, 0.03, 0.05])
@pytest.mark.parametrize("start", [0.03, 0.065, 0.08])
def test_the_weight_is_shifted_to_where_the_first_step_starts(start: float, wanted: float) -> None:
    """From rest between the soles ξ falls to its value like e^{-ωt}, the pressure between the soles all the while."""
    arm, velocity, dt, low, high = start, 0.0, 1e-4, 0.0, 0.13
    for _ in range(round(2.5 / OMEGA / dt)):
        acceleration = shift_acceleration(OMEGA, arm, velocity, wanted, low, high)
        assert low - 1e-12 <= arm - acceleration / OMEGA**2 <= high + 1e-12
        arm, velocity = arm + dt * velocity, velocity + dt * acceleration
    assert abs(arm + velocity / OMEGA - wanted) < 0.1 * abs(start - wanted) + 1e-3


@pytest.mark.parametrize("wanted", [-5.0, 5.0])
def test_the_shift_keeps_to_the_soles(wanted: float) -> None:
    """Whatever is wanted, the pressure stays on them."""
    pressure = 0.05 - shift_acceleration(OMEGA, 0.05, 0.0, wanted, -0.01, 0.13) / OMEGA**2
    assert pressure == pytest.approx(0.13 if wanted < 0.0 else -0.01)
