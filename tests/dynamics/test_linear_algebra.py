"""The factor of a tree's mass matrix: its equation, its zeros, what it refuses."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitsmith.compiled.lanes import padded
from gaitsmith.dynamics import factor_tree, solve_tree

ROUNDING = 1e-9  # relative; condition numbers here stay below 1e5


def some_tree(n: int, seed: int) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float64]]:
    """Parents, and a positive definite matrix that is zero where branches do not touch."""
    rng = np.random.default_rng(seed)
    parent = np.array([int(rng.integers(-1, k)) if k else -1 for k in range(n)], dtype=np.int64)
    root = np.diag(rng.uniform(0.5, 2.0, n))
    for k in range(n):
        i = parent[k]
        while i >= 0:
            root[k, i] = rng.normal()
            i = parent[i]
    return parent, root.T @ root


@given(n=st.integers(1, 20), m=st.integers(1, 12), seed=st.integers(0, 2**31))
def test_factor_and_solves(n: int, m: int, seed: int) -> None:
    parent, a = some_tree(n, seed)
    matrix = np.random.default_rng(seed).normal(size=(n, padded(m) + 1))
    given_lower, factor = np.where(np.tri(n) > 0.0, a, np.nan), np.zeros((n, padded(n)))
    assert factor_tree(given_lower, parent, factor)
    whole = np.tril(factor[:, :n])
    np.fill_diagonal(whole, 1.0)
    np.testing.assert_allclose(whole.T @ np.diag(1.0 / np.diag(factor)) @ whole, a, rtol=ROUNDING, atol=ROUNDING)
    y = matrix.copy()
    solve_tree(factor, parent, y, m)
    np.testing.assert_allclose(a @ y[:, :m], matrix[:, :m], atol=ROUNDING * 1e2)
    np.testing.assert_array_equal(y[:, padded(m) :], matrix[:, padded(m) :])


@pytest.mark.parametrize("spoilt", [-1.0, 0.0, np.nan, np.inf])
@pytest.mark.parametrize("at", [0, 3])
def test_not_positive_definite(spoilt: float, at: int) -> None:
    a = np.eye(4)
    a[at, at] = spoilt
    assert not factor_tree(a, np.arange(-1, 3), np.zeros((4, 8)))
