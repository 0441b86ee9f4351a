"""Dense convex quadratic programs of a few dozen variables, solved in microseconds, warm from the last solve.

The active set of the last solve is tried first: if the solution that it implies is feasible and its multipliers have
the right signs, that is the answer. Otherwise the dual active-set method of Goldfarb and Idnani (Mathematical
Programming 27, 1983) goes on from the part of that set whose multipliers have the right signs.
"""

from __future__ import annotations

from gaitsmith.compiled import kernel
from gaitsmith.qp._dual import solve_dual
from gaitsmith.qp._guess import accept_guess, is_finite, prepare, row_scale
from gaitsmith.qp._storage import INFEASIBLE as INFEASIBLE
from gaitsmith.qp._storage import ITERATION_LIMIT as ITERATION_LIMIT
from gaitsmith.qp._storage import KEPT_MULTIPLIERS, KEPT_SOLUTION
from gaitsmith.qp._storage import NOT_CONVEX as NOT_CONVEX
from gaitsmith.qp._storage import NOT_FINITE as NOT_FINITE
from gaitsmith.qp._storage import OPTIMAL as OPTIMAL
from gaitsmith.qp._storage import QuadraticProgram as QuadraticProgram
from gaitsmith.qp._storage import make_quadratic_program as make_quadratic_program


@kernel
def _clear(qp: QuadraticProgram) -> None:
    """Zero the result and the warm start."""
    for i in range(qp.solution.shape[0]):
        qp.solution[i] = 0.0
    for k in range(qp.multipliers.shape[0]):
        qp.multipliers[k] = 0.0
        qp.active[k] = 0


@kernel
def _finite(qp: QuadraticProgram) -> bool:
    """Whether solution and multipliers hold finite numbers only."""
    poison = 0.0
    for i in range(qp.size[0]):
        poison += 0.0 * qp.solution[i] + 0.0 * qp.multipliers[i]
    base = qp.gradient.shape[0]
    for j in range(qp.size[1]):
        poison += 0.0 * qp.multipliers[base + j]
    return poison == 0.0


@kernel
def solve(qp: QuadraticProgram, iteration_limit: int) -> tuple[int, int]:
    """Solve the problem in ``qp``; see :class:`QuadraticProgram` for the meaning of its fields.

    Args:
        qp: problem, warm start, and result.
        iteration_limit: constraints that may be added or dropped; 5 (n + m) is ample.

    Returns:
        Status and iterations. OPTIMAL: ``solution``, ``multipliers``, ``active`` are the answer; 0 iterations means
        that the stored active set was right. INFEASIBLE: no x satisfies the limits. ITERATION_LIMIT: the limit was
        reached, or rounding hid the answer. NOT_CONVEX: H is not positive definite. NOT_FINITE: a NaN, an infinite
        H, g, or A, or a limit that is infinite on the wrong side. Unless OPTIMAL, solution, multipliers, and active
        set are zeroed, so the next solve starts cold.
    """
    status = prepare(qp)
    if status == OPTIMAL and accept_guess(qp):
        return OPTIMAL, 0
    if status != NOT_CONVEX and not is_finite(qp):
        status = NOT_FINITE
    if status != OPTIMAL:
        _clear(qp)
        return status, 0
    for j in range(qp.size[1]):
        row_scale(qp, j)
    status, iterations = solve_dual(qp, iteration_limit)
    if status == OPTIMAL:
        # The reduced system of the final set is better conditioned than the path that led to it.
        for i in range(qp.size[0]):
            qp.vectors[KEPT_SOLUTION, i] = qp.solution[i]
        for k in range(qp.multipliers.shape[0]):
            qp.vectors[KEPT_MULTIPLIERS, k] = qp.multipliers[k]
        if not accept_guess(qp):
            for i in range(qp.size[0]):
                qp.solution[i] = qp.vectors[KEPT_SOLUTION, i]
            for k in range(qp.multipliers.shape[0]):
                qp.multipliers[k] = qp.vectors[KEPT_MULTIPLIERS, k]
            if not _finite(qp):
                status = ITERATION_LIMIT
    if status != OPTIMAL:
        _clear(qp)
    return status, iterations
