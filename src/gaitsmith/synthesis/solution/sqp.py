"""Sequential quadratic programming from a warm start: exact Hessian, a sparse active set, DAQP where that fails."""

from __future__ import annotations

import time
from collections.abc import Callable

import daqp
import numpy as np
import numpy.typing as npt
import scipy.linalg as sl
import scipy.sparse as sp

from gaitsmith.synthesis.point.caller import Caller
from gaitsmith.synthesis.program.assembly import Assembly
from gaitsmith.synthesis.program.curvature import Curvature
from gaitsmith.synthesis.program.program import OBJECTIVE_SCALE, Program
from gaitsmith.synthesis.solution.active_set import ActiveStep, active_set_step
from gaitsmith.synthesis.solution.ipopt import Progress, Solution, progress_of

Array = npt.NDArray[np.float64]
_NEAR = 0.1  # inequality rows this close to a bound take part in the quadratic program (shares of their range)
_RANK = 1e-9  # relative; equality rows that depend on others
_GAIN = 1e-4  # relative decrease of the objective that is not worth another step
_ROWS = 1e-3  # violation from which the last rows are settled without the objective
_SETTLED = 1e-7
_SETTLING = 12  # steps of that
_PROXIMAL = 1e-2  # curvature added per unknown: directions that cost nothing are not worth a long step
_STEP = 1.0  # largest change of an unknown in one step


def solve_sqp(
    program: Program,
    start: Array,
    multipliers: Array,
    max_iterations: int,
    deadline: float,
    new_bounds: bool,
    report: Callable[[Progress], None] | None = None,
) -> Solution:
    """Solve a program from nearby: objective to about 1e-6, rows to about 1e-9.

    Args:
        program: the program.
        start: unknowns to start from.
        multipliers: of the rows, to start from.
        max_iterations: before it gives up.
        deadline: reading of ``time.perf_counter`` at which it gives up.
        new_bounds: the program has bounds that the start violates: the first step is then a convex one.
        report: called at every iteration.

    Returns:
        A solution whose ``solved`` is False when the start was too far away; the caller then solves it cold.
    """
    begin = time.perf_counter()
    first_order, curvature = Caller(Assembly(program).first_order), Curvature(program)
    ready = time.perf_counter()
    x, lam, fallbacks = start.copy(), multipliers.copy(), 0
    status, solved, iteration, previous = "Maximum_Iterations_Exceeded", False, 0, np.inf
    for iteration in range(max_iterations + 1):
        gradient, rows, _ = first_order(x)
        jacobian = first_order.matrix(2).tocsr()
        violation = float(program.violation(rows).max(initial=0.0))
        z, o = program.evaluate(x)
        objective = program.objective(z, o) * OBJECTIVE_SCALE
        if report is not None:
            report(progress_of(program, iteration, objective / OBJECTIVE_SCALE, rows))
        bounds = program.low - rows, program.high - rows
        found = None
        if iteration or not new_bounds:
            H = _lifted(curvature.exact(x, lam))
            found = active_set_step(H, gradient, jacobian, *bounds, lam)
        if found is None:  # new bounds, or a curvature that does not fit them: a convex step finds which are met
            H = _lifted(curvature.convex(x))
            found = active_set_step(H, gradient, jacobian, *bounds, lam)
        if found is not None:
            step, lam = found.step, found.multipliers
        else:
            fallbacks += 1
            dense = _dense_step(program, gradient, rows, jacobian, _lifted(curvature.exact(x, lam)))
            if dense is None:
                status = "Quadratic_Program_Failed"
                break
            step, lam = dense
        size = float(np.abs(step).max())
        gain = abs(float(gradient @ step) + 0.5 * float(step @ H @ step))
        if violation < _ROWS and gain < _GAIN * abs(objective) and found is not None:
            x, left = _settled(program, x + step, found)
            solved = left < _SETTLED
            status = "Solve_Succeeded" if solved else "Restoration_Failed"
            break
        if not np.isfinite(size) or (size > 4.0 * previous and size > 0.05):
            status = "Diverged"
            break
        previous = size
        x = x + step * min(1.0, _STEP / size)
        if time.perf_counter() > deadline:
            status = "Maximum_Time_Exceeded"
            break
    spent = time.perf_counter() - ready
    return Solution(x, solved, status, iteration, ready - begin, spent, lam, fallbacks)


def _lifted(H: sp.coo_matrix) -> sp.coo_matrix:
    """A Hessian with a little curvature added."""
    along = np.arange(H.shape[0])
    values = np.concatenate([H.data, np.full(len(along), _PROXIMAL)])
    places = np.concatenate([H.row, along]), np.concatenate([H.col, along])
    return sp.coo_matrix((values, places), shape=H.shape)


def _settled(program: Program, x: Array, found: ActiveStep) -> tuple[Array, float]:
    """Small changes of ``x`` until the equalities and the active bounds hold; and what is left of them."""
    held, left, conditions = found.held, np.inf, found.conditions()
    side = np.sign(found.multipliers[held])
    goal = np.where(side < 0, program.low[held], program.high[held])
    for _ in range(_SETTLING):
        _, o = program.evaluate(x)
        gap = goal - program.constraint(x, o)[held]
        left = float(np.abs(gap).max(initial=0.0))
        if left < 0.01 * _SETTLED:
            break
        x = x + conditions.towards(gap)  # the rows are nearly straight here: one factorisation serves all steps
    return x, left


def _dense_step(
    program: Program,
    gradient: Array,
    rows: Array,
    jacobian: sp.csr_matrix,
    H: sp.spmatrix,
) -> tuple[Array, Array] | None:
    """Step and multipliers of the quadratic program in the null space of the equalities; None without a solution."""
    equal = program.high - program.low <= 0.0
    bounded = np.flatnonzero(~equal).astype(np.int64)
    A, b = jacobian[np.flatnonzero(equal)].toarray(), program.low[equal] - rows[equal]
    # Column-pivoted QR of Aᵀ: the range of Aᵀ, and the null space in which the step is free.
    Q, R, order = sl.qr(A.T, mode="full", pivoting=True)
    diagonal = np.abs(np.diag(R))
    rank = int(np.sum(diagonal > _RANK * diagonal[0]))
    Y, Z = Q[:, :rank], Q[:, rank:]
    triangle = R[:rank, :rank]
    particular = Y @ sl.solve_triangular(triangle, b[order[:rank]], trans="T")
    J = jacobian[bounded]
    ahead = rows[bounded] + J @ particular
    low, high = program.low[bounded], program.high[bounded]
    near = np.flatnonzero((ahead - low < _NEAR) | (high - ahead < _NEAR))
    reduced, free = _convex(Z.T @ (H @ Z)), Z.T @ (gradient + H @ particular)
    inner = J[near] @ Z
    upper, lower = np.minimum(high[near] - ahead[near], 1e20), np.maximum(low[near] - ahead[near], -1e20)
    sense = np.zeros(len(near), dtype=np.int32)
    y, _, flag, info = daqp.solve(
        np.ascontiguousarray(reduced), free, np.ascontiguousarray(inner), upper, lower, sense, iter_limit=5000
    )
    if flag < 0 or not np.isfinite(y).all():
        return None
    step = particular + Z @ y
    lam = np.zeros(len(rows))
    lam[bounded[near]] = info["lam"]
    pull = gradient + H @ step + J.T @ lam[bounded]
    on_equal = np.zeros(int(equal.sum()))
    on_equal[order[:rank]] = -sl.solve_triangular(triangle, Y.T @ pull)
    lam[equal] = on_equal
    return step, lam


def _convex(H: Array) -> Array:
    """The matrix with a little curvature added, and more where it is not positive."""
    H = 0.5 * (H + H.T) + _PROXIMAL * np.eye(len(H))
    try:
        np.linalg.cholesky(H)
        return H
    except np.linalg.LinAlgError:
        values, vectors = np.linalg.eigh(H)
        return np.asarray((vectors * np.maximum(np.abs(values), _PROXIMAL)) @ vectors.T)
