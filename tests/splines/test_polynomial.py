"""Polynomials: one curve in every form, derivatives, quadrature exact for its degree."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitsmith.splines.polynomial import (
    bernstein,
    bernstein_to_power,
    chebyshev,
    chebyshev_fit,
    hermite,
    lobatto,
    polynomial,
    power_basis,
)

ROUNDING = 1e-9


@given(st.integers(2, 6), st.floats(0.01, 2.0), st.integers(0, 10**6))
def test_powers_are_differentiated(degree, t, seed):
    coefficients = np.random.default_rng(seed).normal(size=degree + 1)
    for derivative in range(3):
        wanted = np.polynomial.polynomial.Polynomial(coefficients).deriv(derivative)(t)
        assert abs(coefficients @ power_basis(degree, t, derivative) - wanted) < ROUNDING * max(1.0, abs(wanted))


def test_hermite_pieces_meet_both_states():
    left, right = np.random.default_rng(0).normal(size=(2, 3, 4))
    found = polynomial(hermite(0.3, left, right), np.array([0.0, 1.0]), 0.3)
    assert np.abs(found - np.stack([left, right], axis=-1)).max() < ROUNDING


def test_a_chebyshev_series_is_the_polynomial_it_was_fitted_to():
    nodes, matrix = chebyshev_fit(8)
    coefficients = np.random.default_rng(0).normal(size=(3, 6))
    s = np.linspace(0.0, 1.0, 11)
    fitted = chebyshev(polynomial(coefficients, nodes, 1.0)[0] @ matrix, s)
    assert np.abs(fitted - polynomial(coefficients, s, 1.0)[0]).max() < ROUNDING


@given(st.integers(1, 6), st.floats(0.0, 1.0), st.integers(0, 10**6))
def test_powers_and_bernstein_form_are_the_same_polynomial(degree, s, seed):
    control = np.random.default_rng(seed).normal(size=degree + 1)
    power = bernstein_to_power(degree) @ control
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
