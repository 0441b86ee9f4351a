"""Splines: joined C², linear in their control points; quadrature exact for its degree."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitsmith.synthesis.program.curves import JointSpline, bernstein, lobatto, power_basis

ROUNDING = 1e-9


@pytest.mark.parametrize("degree", [4, 5])
def test_spline_is_continuous_to_the_second_derivative(degree):
    rng = np.random.default_rng(0)
    knots = np.cumsum(rng.uniform(0.1, 0.6, 7))
    spline = JointSpline(knots, degree)
    control = rng.normal(size=spline.size)
    for k in range(1, len(knots) - 1):
        for derivative in range(3):
            values = [
                spline.row(s, knots[k], derivative) @ control[spline.first(s) : spline.first(s) + degree + 1]
                for s in (k - 1, k)
            ]
            assert abs(values[0] - values[1]) < ROUNDING * max(1.0, abs(values[0]))


@pytest.mark.parametrize("degree", [4, 5])
def test_constant_control_points_give_a_constant(degree):
    spline = JointSpline(np.array([0.0, 0.2, 0.7, 0.9]), degree)
    for section, t in ((0, 0.1), (1, 0.5), (2, 0.9)):
        assert abs(spline.row(section, t).sum() - 1.0) < ROUNDING
        assert abs(spline.row(section, t, 1).sum()) < ROUNDING


@given(st.integers(1, 6), st.floats(0.0, 1.0), st.integers(0, 10**6))
def test_power_basis_is_the_same_polynomial(degree, s, seed):
    control = np.random.default_rng(seed).normal(size=degree + 1)
    power = power_basis(degree) @ control
    assert abs(bernstein(degree, s) @ control - np.polynomial.polynomial.polyval(s, power)) < 1e-8


@given(st.floats(0.05, 0.95), st.integers(0, 2))
def test_derivatives_of_bernstein_polynomials(s, derivative):
    h = 1e-5
    slope = (bernstein(5, s + h, derivative) - bernstein(5, s - h, derivative)) / (2 * h)
    assert np.abs(bernstein(5, s, derivative + 1) - slope).max() < 1e-4


@pytest.mark.parametrize("count", [3, 5, 8])
def test_lobatto_integrates_polynomials(count):
    nodes, weights = lobatto(count)
    for power in range(2 * count - 2):
        assert abs(weights @ nodes**power - 1.0 / (power + 1)) < ROUNDING
