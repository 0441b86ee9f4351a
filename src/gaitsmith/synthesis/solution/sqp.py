"""Sequential quadratic programming from a warm start: exact Hessian and a sparse active set."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from gaitsmith.synthesis.program.derivatives import Derivatives
from gaitsmith.synthesis.program.program import Program
from gaitsmith.synthesis.solution.active_set import ActiveStep, active_set_step
from gaitsmith.synthesis.solution.ipopt import Progress, Solution, progress_of

Array = npt.NDArray[np.float64]
_GAIN = 1e-4  # relative decrease of the objective that is not worth another step
_ROWS = 1e-3  # violation from which the last rows are settled without the objective
_SETTLED = 1e-7
_SETTLING = 12  # steps of that
_FAR = 0.03  # violation from which the curvature of what is violated says nothing: the steps are convex ones
_PROXIMAL = 1e-2  # curvature added per unknown: directions that cost nothing are not worth a long step
_LONG = 0.05  # change from near a solution that only a curvature of nearly nothing asks for: a convex step again
_STEP = 1.0  # largest change of an unknown in one step


def solve_sqp(
    program: Program,
    start: Array,
    last: Solution | None,
    max_iterations: int,
    rough: bool,
    report: Callable[[Progress], None] | None = None,
) -> Solution:
    """Solve a program from nearby: objective to about 1e-6, rows to about 1e-9.

    Args:
        program: the program.
        start: unknowns to start from.
        last: of a program nearby with the first of these rows, whose multipliers to start from.
        max_iterations: before it gives up.
        rough: a step from where all rows nearly hold is enough: the bounds are to be looked at first.
        report: called at every iteration.

    Returns:
        A solution whose ``solved`` is False when the start was too far away; the caller then solves it cold.
    """
    begin = time.perf_counter()
    derivatives = Derivatives(program)
    ready = time.perf_counter()
    x, lam, independent = start.copy(), np.zeros(program.rows), None
    if last is not None:
        known = last.multipliers[: program.rows]
        lam[: len(known)], independent = known, last.independent
    status, solved, iteration, previous = "Maximum_Iterations_Exceeded", False, 0, np.inf
    for iteration in range(max_iterations + 1):
        gradient, rows, jacobian = derivatives.first_order(x)
        violation = float(program.violation(rows).max(initial=0.0))
        z, o = derivatives.evaluate(x)
        objective, cost = program.objective(z, o), program.cost(z, o) * program.scale
        if report is not None:
            report(progress_of(program, iteration, objective, rows))
        bounds = program.low - rows, program.high - rows
        far = violation > _FAR
        H = derivatives.curvature(x, 0.0 if far else 1.0, 0.0 if far else lam, _PROXIMAL)
        found = active_set_step(H, gradient, jacobian, *bounds, lam, independent, far)
        near = not (far or rough) and last is not None
        if near and found is not None and np.abs(found.step).max() > _LONG:
            H = derivatives.curvature(x, 0.0, 0.0, _PROXIMAL)
            found = active_set_step(H, gradient, jacobian, *bounds, lam, independent, far)
        if found is None:
            status = "Quadratic_Program_Failed"
            break
        step, lam, independent = found.step, found.multipliers, found.independent
        size = float(np.abs(step).max())
        gain = abs(float(gradient @ step) + 0.5 * float(step @ H @ step))
        if violation < _ROWS and gain < _GAIN * abs(cost):
            nearer, left = _settled(program, x + step, found)
            solved = left < _SETTLED
            if solved or iteration == max_iterations:
                x, status = nearer, "Solve_Succeeded" if solved else "Restoration_Failed"
                break  # else these bounds are not the ones that are met: another step tells which are
        if not np.isfinite(size) or (size > 4.0 * previous and size > 0.05):
            status = "Diverged"
            break
        previous = size
        x = x + step * min(1.0, _STEP / size)
        if rough and not far:
            solved, status, iteration = True, "Rough", iteration + 1
            break
    return Solution(x, solved, status, iteration, ready - begin, lam, independent)


def _settled(program: Program, x: Array, found: ActiveStep) -> tuple[Array, float]:
    """Small changes of ``x`` until the equalities and the active bounds hold; and what is left of them."""
    held, left = found.held, np.inf
    side = np.sign(found.multipliers[held])
    goal = np.where(side < 0, program.low[held], program.high[held])
    for _ in range(_SETTLING):
        _, o = program.evaluate(x)
        gap = goal - program.constraint(x, o)[held]
        left = float(np.abs(gap).max(initial=0.0))
        if left < 0.01 * _SETTLED:
            break
        x = x + found.towards(gap)  # the rows are nearly straight here: one factorisation serves all steps
    return x, left
