"""The solver agrees with an independent one, recognises what has no solution, and survives degenerate problems."""

from typing import NamedTuple

import daqp
import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba.core.runtime import _nrt_python, rtsys
from tests.qp.optimality import residual

from gaitsmith.compiled import Arena, bind, kernel
from gaitsmith.errors import BadInput
from gaitsmith.qp.quadratic_program import (
    INFEASIBLE,
    ITERATION_LIMIT,
    NOT_CONVEX,
    NOT_FINITE,
    OPTIMAL,
    QuadraticProgram,
    make_quadratic_program,
    solve,
)

Array = npt.NDArray[np.float64]

LIMIT = 500  # iterations; ten times what the largest of these problems needs
ERROR = 1e-8  # against the oracle, relative to the solution's size, at condition numbers up to 1e6
OPTIMALITY = 1e-9  # scaled residual of the optimality conditions
CONFLICT = 4e-7  # limits that contradict each other by less than 1e-7 count as rounding
PRIMAL, DUAL = 1e-11, 1e-11  # the oracle's tolerances


class Kind(NamedTuple):
    """What a random problem is like."""

    n: int
    m: int
    seed: int
    conditioning: float  # log10 of the smallest eigenvalue's share
    scaling: float  # log10 of the spread of units
    equalities: float  # share of the rows
    dependent: bool  # duplicated, opposite, and summed rows; many constraints through one point


kinds = st.builds(
    Kind,
    n=st.integers(1, 14),
    m=st.integers(0, 16),
    seed=st.integers(0, 2**32 - 1),
    conditioning=st.sampled_from([0.0, -2.0, -5.0]),
    scaling=st.sampled_from([0.0, 2.0]),
    equalities=st.sampled_from([0.0, 0.2]),
    dependent=st.booleans(),
)


def random_problem(kind: Kind) -> QuadraticProgram:
    """A feasible problem: some point satisfies all limits, several of them exactly."""
    rng = np.random.default_rng(kind.seed)
    n, m = kind.n, kind.m
    qp = make_quadratic_program(n, m)
    units = 10.0 ** rng.uniform(-kind.scaling, kind.scaling, n)
    factor = rng.normal(size=(n, n))
    qp.hessian[:] = (factor @ factor.T + 10.0**kind.conditioning * np.eye(n)) * np.outer(units, units)
    qp.gradient[:] = 3.0 * rng.normal(size=n) * units
    inside = rng.normal(size=n) / units
    qp.rows[:] = rng.normal(size=(m, n)) * units
    if kind.dependent and m >= 4:
        qp.rows[1] = 2.0 * qp.rows[0]
        qp.rows[2] = -qp.rows[0]
        qp.rows[3] = qp.rows[0] + qp.rows[-1]
    slack = [0.0, 0.0, 0.5, np.inf] if kind.dependent else [0.3, 1.0, np.inf]
    at = qp.rows @ inside
    qp.row_lower[:] = at - rng.choice(slack, m)
    qp.row_upper[:] = at + rng.choice(slack, m)
    for row in range(min(int(kind.equalities * m), n - 1)):
        qp.row_lower[row] = qp.row_upper[row] = at[row]
    qp.lower[:] = inside - rng.choice(slack, n) / units
    qp.upper[:] = inside + rng.choice(slack, n) / units
    return qp


def oracle(qp: QuadraticProgram) -> tuple[Array, int]:
    """DAQP's solution and exit flag (positive if solved, -1 if infeasible)."""
    n, m = qp.size
    upper = np.concatenate([qp.upper[:n], qp.row_upper[:m]])
    lower = np.concatenate([qp.lower[:n], qp.row_lower[:m]])
    sense = np.where(upper == lower, 5, 0).astype(np.int32)
    big = 1e30
    x, _, flag, _ = daqp.solve(
        np.ascontiguousarray(qp.hessian[:n, :n]),
        qp.gradient[:n].copy(),
        np.ascontiguousarray(qp.rows[:m, :n]),
        np.clip(upper, -big, big),
        np.clip(lower, -big, big),
        sense,
        primal_tol=PRIMAL,
        dual_tol=DUAL,
        eps_prox=0.0,
    )
    return np.asarray(x), int(flag)


@given(kinds)
def test_agrees_with_the_oracle_and_is_optimal(kind: Kind) -> None:
    """Optimality conditions always; the oracle's point wherever the oracle finds one."""
    qp = random_problem(kind)
    status, _ = solve(qp, LIMIT)
    assert status == OPTIMAL
    assert residual(qp) <= OPTIMALITY
    if kind.dependent or kind.equalities:
        return  # the oracle gives up on some of these; the conditions above are sufficient
    expected, flag = oracle(qp)
    assert flag > 0
    scale = np.sqrt(np.diag(qp.hessian))
    size = max(1.0, float(np.max(np.abs(expected * scale))))
    spread = 10.0 ** (-kind.conditioning / 2.0)
    assert np.max(np.abs((qp.solution - expected) * scale)) <= ERROR * size * spread


@given(kinds)
def test_infeasible_problems_are_recognised(kind: Kind) -> None:
    """Two opposite rows, or a row against the bounds, that leave a gap."""
    qp = random_problem(kind._replace(m=max(kind.m, 2)))
    m = qp.size[1]
    rng = np.random.default_rng(kind.seed)
    if kind.dependent:
        at = float(qp.rows[0] @ np.linalg.solve(qp.hessian, qp.gradient))
        qp.rows[m - 1] = -1.5 * qp.rows[0]
        qp.row_lower[0], qp.row_upper[0] = at + 0.1 + abs(at), np.inf
        qp.row_lower[m - 1], qp.row_upper[m - 1] = -1.5 * at, np.inf
    else:
        qp.lower[:], qp.upper[:] = -1.0 / np.diag(qp.hessian) ** 0.5, 1.0 / np.diag(qp.hessian) ** 0.5
        reach = float(np.abs(qp.rows[0]) @ qp.upper)
        qp.row_lower[0], qp.row_upper[0] = reach * rng.uniform(1.01, 3.0), np.inf
    assert solve(qp, LIMIT)[0] == INFEASIBLE
    assert np.all(qp.solution == 0.0)
    assert np.all(qp.active == 0)


@given(kinds, st.floats(0.0, 0.3))
def test_a_sequence_of_neighbours_stays_optimal_and_warm(kind: Kind, change: float) -> None:
    """Repeating a problem costs no iteration; a neighbour starts warm and ends where a cold start ends."""
    qp = random_problem(kind)
    assert solve(qp, LIMIT)[0] == OPTIMAL
    first = qp.solution.copy()
    assert solve(qp, LIMIT) == (OPTIMAL, 0)
    scale = np.sqrt(np.diag(qp.hessian))
    size = max(1.0, float(np.max(np.abs(first * scale)))) * 10.0 ** (-kind.conditioning)
    assert np.max(np.abs((qp.solution - first) * scale)) <= ERROR * size
    rng = np.random.default_rng(kind.seed + 1)
    for _ in range(5):
        qp.gradient[:] += change * rng.normal(size=kind.n) * scale
        assert solve(qp, LIMIT)[0] == OPTIMAL
        assert residual(qp) <= OPTIMALITY
        warm = qp.solution.copy()
        qp.active[:] = 0
        assert solve(qp, LIMIT)[0] == OPTIMAL
        size = max(1.0, float(np.max(np.abs(warm * scale)))) * 10.0 ** (-kind.conditioning)
        assert np.max(np.abs((qp.solution - warm) * scale)) <= ERROR * size


@given(kinds, st.integers(0, 2**32 - 1))
def test_any_stored_active_set_leads_to_the_solution(kind: Kind, seed: int) -> None:
    """A wrong, contradictory, or nonsensical warm start only costs iterations."""
    qp = random_problem(kind)
    qp.active[:] = np.random.default_rng(seed).integers(-1, 2, qp.active.size)
    assert solve(qp, LIMIT)[0] == OPTIMAL
    assert residual(qp) <= OPTIMALITY


@given(kinds, st.integers(0, 4), st.integers(0, 4))
def test_a_solve_may_use_part_of_the_storage(kind: Kind, spare: int, rows: int) -> None:
    """Leading variables and rows of a larger storage give the same answer; the rest is not read."""
    small = random_problem(kind)
    n, m = kind.n, kind.m
    large = make_quadratic_program(n + spare, m + rows)
    for name in ("hessian", "gradient", "rows", "row_lower", "row_upper", "lower", "upper"):
        getattr(large, name)[...] = np.nan
        getattr(large, name)[tuple(slice(k) for k in getattr(small, name).shape)] = getattr(small, name)
    large.size[:] = n, m
    assert solve(large, LIMIT) == solve(small, LIMIT)
    np.testing.assert_array_equal(large.solution[:n], small.solution)
    np.testing.assert_array_equal(large.multipliers[n + spare : n + spare + m], small.multipliers[n:])
    assert residual(large) == residual(small)


@settings(max_examples=300)
@given(
    st.integers(1, 5),
    st.integers(0, 6),
    st.lists(st.sampled_from([0.0, 1.0, -1.0, 2.0, 0.5, 1e-9, 1e9, np.inf, -np.inf]), min_size=100, max_size=100),
)
def test_no_data_break_it(n: int, m: int, numbers: list[float]) -> None:
    """Small integers make every kind of degeneracy; OPTIMAL always means finite and optimal."""
    stock = iter(numbers * 3)
    qp = make_quadratic_program(n, m)
    finite = (x for x in stock if np.isfinite(x) and abs(x) < 10.0)
    qp.gradient[:] = [next(finite) for _ in range(n)]
    qp.rows[:] = np.reshape([next(finite) for _ in range(n * m)], (m, n))
    for lower, upper in ((qp.lower, qp.upper), (qp.row_lower, qp.row_upper)):
        for k in range(lower.size):
            lower[k], upper[k] = sorted((next(stock), next(stock)))
    status, iterations = solve(qp, LIMIT)
    assert status in (OPTIMAL, INFEASIBLE, NOT_FINITE)
    assert iterations <= LIMIT
    assert np.all(np.isfinite(qp.solution))
    if status == OPTIMAL:
        assert residual(qp) <= CONFLICT


def test_multiplier_signs_and_marks() -> None:
    """minimise ½(x-2)² + ½(y+2)² in [-1, 1]²: x is held by its upper bound (y < 0), y by its lower one (y > 0)."""
    qp = make_quadratic_program(2, 1)
    qp.gradient[:] = -2.0, 2.0
    qp.lower[:], qp.upper[:] = -1.0, 1.0
    qp.rows[0] = 1.0, 1.0
    assert solve(qp, LIMIT)[0] == OPTIMAL
    np.testing.assert_allclose(qp.solution, [1.0, -1.0], atol=1e-15)
    np.testing.assert_allclose(qp.multipliers, [-1.0, 1.0, 0.0], atol=1e-15)
    np.testing.assert_array_equal(qp.active, [1, -1, 0])


def test_reports_what_cannot_be_solved() -> None:
    """NaN, wrong infinities, crossed limits, an indefinite or singular H, too few iterations: each has its status."""
    for field in ("hessian", "gradient", "rows", "row_lower", "row_upper", "lower", "upper"):
        qp = make_quadratic_program(3, 2)
        getattr(qp, field)[0] = np.nan
        assert solve(qp, LIMIT)[0] == NOT_FINITE
    qp = make_quadratic_program(3, 2)
    qp.lower[1] = np.inf
    assert solve(qp, LIMIT)[0] == NOT_FINITE
    qp = make_quadratic_program(3, 2)
    qp.lower[1], qp.upper[1] = 1.0, 0.0
    assert solve(qp, LIMIT)[0] == INFEASIBLE
    qp = make_quadratic_program(2, 0)
    qp.hessian[:] = [[1.0, 2.0], [2.0, 1.0]]
    assert solve(qp, LIMIT)[0] == NOT_CONVEX
    qp.hessian[:] = 1.0
    assert solve(qp, LIMIT)[0] == NOT_CONVEX
    qp = random_problem(Kind(10, 10, 3, 0.0, 0.0, 0.0, False))
    assert solve(qp, 1)[0] == ITERATION_LIMIT
    assert np.all(qp.solution == 0.0)
    assert solve(qp, LIMIT)[0] == OPTIMAL
    for n, m in ((0, 1), (-1, 0), (3, -1), (10**6, 1)):
        with pytest.raises(BadInput):
            make_quadratic_program(n, m)


@kernel
def solve_often(table: int, count: int) -> int:
    """Solve a bound problem again and again, every second time cold; returns how many were optimal."""
    qp = bind(QuadraticProgram, table)
    good = 0
    for k in range(count):
        if k % 2 == 0:
            for i in range(qp.active.shape[0]):
                qp.active[i] = 0
        if solve(qp, 500)[0] == 0:
            good += 1
    return good


def test_solving_allocates_nothing() -> None:
    """numba's allocation counters stand still over a thousand solves of a bound problem."""
    arena = Arena(random_problem(Kind(13, 10, 5, -2.0, 0.0, 0.2, False)))
    solve_often(arena.address, 2)
    _nrt_python.memsys_enable_stats()
    try:
        before = rtsys.get_allocation_stats()
        assert solve_often(arena.address, 1000) == 1000
        after = rtsys.get_allocation_stats()
        assert (after.alloc, after.mi_alloc) == (before.alloc, before.mi_alloc)
    finally:
        _nrt_python.memsys_disable_stats()
