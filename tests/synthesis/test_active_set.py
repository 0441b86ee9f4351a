"""The quadratic program of an SQP step: DAQP's solution, from good and from bad guesses."""

import daqp
import numpy as np
import pytest
import scipy.sparse as sp

from gaitsmith.synthesis.solution.active_set import active_set_step

SAME = 1e-5  # relative to the step: rows in doubt are softened a little so that dependent ones do no harm
N, EQUAL, BOUNDS = 30, 8, 40


def _problem(seed):
    """A convex program whose rows are banded, with a point well inside all bounds."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(N, N)) * (np.abs(np.subtract.outer(np.arange(N), np.arange(N))) < 5)
    H = root @ root.T + 0.1 * np.eye(N)
    rows = np.zeros((EQUAL + BOUNDS, N))
    for row in rows:
        first = rng.integers(0, N - 5)
        row[first : first + 5] = rng.normal(size=5)
    inside = rows @ rng.normal(size=N)
    low, high = inside - rng.uniform(0.05, 1.0, len(rows)), inside + rng.uniform(0.05, 1.0, len(rows))
    low[:EQUAL] = high[:EQUAL] = inside[:EQUAL]
    return H, rng.normal(size=N) * 5.0, rows, low, high


def _oracle(H, gradient, rows, low, high):
    sense = np.where(high - low <= 0.0, 5, 0).astype(np.int32)
    step, _, flag, info = daqp.solve(H, gradient, rows, high, low, sense)
    assert flag == 1
    return step, info["lam"]


@pytest.mark.parametrize("seed", range(12))
def test_the_step_is_daqps(seed):
    H, gradient, rows, low, high = _problem(seed)
    step, multipliers = _oracle(H, gradient, rows, low, high)
    rng = np.random.default_rng(seed + 100)
    for guess in (multipliers, multipliers * (rng.random(len(low)) < 0.8), np.zeros(len(low))):
        found = active_set_step(H, gradient, sp.csr_matrix(rows), low, high, guess)
        assert found is not None
        assert np.abs(found.step - step).max() < SAME * max(1.0, np.abs(step).max())


@pytest.mark.parametrize("seed", range(4))
def test_optimality_holds(seed):
    H, gradient, rows, low, high = _problem(seed)
    found = active_set_step(H, gradient, sp.csr_matrix(rows), low, high, np.zeros(len(low)))
    change = rows @ found.step
    assert (change <= high + SAME).all()
    assert (change >= low - SAME).all()
    assert np.abs(H @ found.step + gradient + rows.T @ found.multipliers).max() < 1e-6 * np.abs(gradient).max()
    bounded = high > low
    slack = np.minimum(high - change, change - low)
    assert (np.abs(found.multipliers[bounded]) * slack[bounded]).max() < 1e-5
    assert set(np.flatnonzero(found.multipliers)) <= set(found.held)


def test_where_the_curvature_goes_down_the_step_still_keeps_the_bounds():
    H, gradient, rows, low, high = _problem(0)
    found = active_set_step(-H, gradient, sp.csr_matrix(rows), low, high, np.zeros(len(low)))
    assert found is not None
    assert found.curved
    assert (rows @ found.step <= high + SAME).all()
    assert (rows @ found.step >= low - SAME).all()


def test_bounds_that_nothing_keeps_give_no_step():
    H, gradient, rows, low, high = _problem(2)
    rows[-1], low[-1], high[-1] = rows[-2], high[-2] + 1.0, high[-2] + 2.0
    assert active_set_step(H, gradient, sp.csr_matrix(rows), low, high, np.zeros(len(low))) is None


def test_a_row_that_equalities_determine_is_not_a_bound():
    H, gradient, rows, low, high = _problem(3)
    step, _ = _oracle(H, gradient, rows, low, high)
    more = np.vstack([rows, rows[:1]]), np.append(low, low[0] - 1e-9), np.append(high, high[0] - 1e-9 + 1e-10)
    found = active_set_step(H, gradient, sp.csr_matrix(more[0]), *more[1:], np.zeros(len(low) + 1))
    assert np.abs(found.step - step).max() < SAME * max(1.0, np.abs(step).max())


def test_equal_rows_given_twice_do_no_harm():
    H, gradient, rows, low, high = _problem(1)
    step, _ = _oracle(H, gradient, rows, low, high)
    twice = [np.concatenate([values[:3], values]) for values in (rows, low, high)]
    found = active_set_step(H, gradient, sp.csr_matrix(twice[0]), *twice[1:], np.zeros(len(low) + 3))
    assert np.abs(found.step - step).max() < SAME * max(1.0, np.abs(step).max())


def test_where_bounds_contradict_each_other_a_step_may_exceed_them_all_alike():
    rows, H = np.array([[1.0, 0.0], [1.0, 0.0]]), np.eye(2)
    low, high = np.array([1.0, -np.inf]), np.array([np.inf, -1.0])
    given = H, np.array([0.0, 1.0]), sp.csr_matrix(rows), low, high, np.zeros(2)
    assert active_set_step(*given) is None
    found = active_set_step(*given, nearly=True)
    assert found is not None
    assert found.step == pytest.approx([0.0, -1.0], abs=1e-6)
