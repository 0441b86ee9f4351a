from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitsmith.dynamics import cholesky, cholesky_solve_matrix

ROUNDING = 1e-9  # relative; condition numbers here stay below 1e5


def _positive(n: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(n, n))
    return root @ root.T + 0.1 * np.eye(n)


@given(n=st.integers(1, 20), m=st.integers(1, 6), room=st.integers(0, 3), seed=st.integers(0, 2**31))
def test_factor_and_solves(n, m, room, seed):
    a = np.full((n + room, n + room), np.nan)
    a[:n, :n] = _positive(n, seed)
    rng = np.random.default_rng(seed)
    matrix = rng.normal(size=(n + room, m + room))
    factor = np.full_like(a, 7.0)
    assert cholesky(a, factor, n)
    np.testing.assert_allclose(np.tril(factor[:n, :n]), np.linalg.cholesky(a[:n, :n]), rtol=ROUNDING, atol=ROUNDING)
    assert np.all(factor[np.triu_indices(n + room, 1)] == 7.0)
    y = matrix.copy()
    cholesky_solve_matrix(factor, y, n, m)
    np.testing.assert_allclose(a[:n, :n] @ y[:n, :m], matrix[:n, :m], atol=ROUNDING * 1e2)
    np.testing.assert_array_equal(y[n:], matrix[n:])
    np.testing.assert_array_equal(y[:, m:], matrix[:, m:])


def test_in_place():
    a = _positive(7, 0)
    expected = np.linalg.cholesky(a)
    assert cholesky(a, a, 7)
    np.testing.assert_allclose(np.tril(a), expected, rtol=ROUNDING, atol=ROUNDING)


@pytest.mark.parametrize("spoilt", [-1.0, 0.0, np.nan, np.inf])
@pytest.mark.parametrize("at", [0, 3])
def test_not_positive_definite(spoilt, at):
    a = np.eye(4)
    a[at, at] = spoilt
    assert not cholesky(a, np.zeros((4, 4)), 4)
