"""Solve a quadratic program whose active set is known, and say whether the guess was right.

Fixed variables are eliminated, the rest is solved in range space: with H_FF = L Lᵀ and V = A_WF L⁻ᵀ, the multipliers
of the active rows W solve V Vᵀ u = b + V w. One refinement step follows where the residual asks for it.
"""

from __future__ import annotations

import numpy as np

from gaitsmith.compiled import IntVector, Matrix, Vector, kernel
from gaitsmith.qp._storage import (
    DEPENDENT,
    DUAL_TOLERANCE,
    FORCE,
    FULL,
    GAP,
    HIGH,
    INFEASIBLE,
    INVERSE,
    LOW,
    METRIC,
    NOT_CONVEX,
    NOT_FINITE,
    OPTIMAL,
    PRIMAL_TOLERANCE,
    SIGN_TOLERANCE,
    SLOPE,
    STEP,
    QuadraticProgram,
)

_PIVOT = 1e-14  # smallest Cholesky pivot relative to its diagonal entry: below it only rounding is left


@kernel
def is_finite(qp: QuadraticProgram) -> bool:
    """Whether H, g and the rows are numbers."""
    n, poison = qp.size[0], 0.0
    for i in range(n):
        poison += 0.0 * qp.gradient[i]
        for k in range(n):
            poison += 0.0 * qp.hessian[i, k]
    for j in range(qp.size[1]):
        for i in range(n):
            poison += 0.0 * qp.rows[j, i]
    return poison == 0.0


@kernel
def _norm(row: Vector, scale: Vector, n: int) -> float:
    """Squared norm of a row in scaled units; four sums, because each waits for its own last addition."""
    a = b = c = d = 0.0
    for i in range(0, n - 3, 4):
        a += (row[i] * scale[i]) ** 2
        b += (row[i + 1] * scale[i + 1]) ** 2
        c += (row[i + 2] * scale[i + 2]) ** 2
        d += (row[i + 3] * scale[i + 3]) ** 2
    for i in range(n // 4 * 4, n):
        a += (row[i] * scale[i]) ** 2
    return (a + b) + (c + d)


@kernel
def _product(row: Vector, x: Vector, n: int) -> float:
    """A row times x, in the same way."""
    a = b = c = d = 0.0
    for i in range(0, n - 3, 4):
        a += row[i] * x[i]
        b += row[i + 1] * x[i + 1]
        c += row[i + 2] * x[i + 2]
        d += row[i + 3] * x[i + 3]
    for i in range(n // 4 * 4, n):
        a += row[i] * x[i]
    return (a + b) + (c + d)


@kernel
def prepare(qp: QuadraticProgram) -> int:
    """Check the limits; gather those of all constraints in LOW and HIGH and their scales in METRIC.

    The scale of a constraint is the inverse norm of its normal in scaled units. H beside its diagonal is not looked
    at: a guess with a number in it that is not finite is not accepted, and :func:`is_finite` tells why.

    Returns:
        OPTIMAL if a solve may start, else NOT_FINITE, NOT_CONVEX, or INFEASIBLE (crossed limits).
    """
    n, m, base = qp.size[0], qp.size[1], qp.gradient.shape[0]
    metric, inverse, low, high = qp.vectors[METRIC], qp.vectors[INVERSE], qp.vectors[LOW], qp.vectors[HIGH]
    poison = 0.0
    convex = True
    for i in range(n):
        diagonal = qp.hessian[i, i]
        convex = convex and not diagonal <= 0.0
        metric[i] = np.sqrt(diagonal)
        inverse[i] = 1.0 / metric[i]
        poison += 0.0 * qp.gradient[i] + 0.0 * diagonal
        low[i], high[i] = qp.lower[i], qp.upper[i]
    for j in range(m):
        total = _norm(qp.rows[j], inverse, n)
        poison += 0.0 * total
        metric[base + j] = 1.0 / np.sqrt(total) if total > 0.0 else 1.0
        low[base + j], high[base + j] = qp.row_lower[j], qp.row_upper[j]
    if not convex:
        return NOT_CONVEX
    if poison != 0.0:
        return NOT_FINITE
    crossed = False
    for i in range(n + m):
        k = i if i < n else base + i - n
        if not (low[k] < np.inf and high[k] > -np.inf):
            return NOT_FINITE
        crossed = crossed or low[k] > high[k]
    return INFEASIBLE if crossed else OPTIMAL


@kernel
def _kkt_step(factor: Matrix, normals: Matrix, schur: Matrix, vectors: Matrix, free: int, held: int) -> None:
    """Change of the free variables (STEP) and of the active rows' multipliers (FORCE) that ends SLOPE and GAP."""
    slope, gap, step, force = vectors[SLOPE], vectors[GAP], vectors[STEP], vectors[FORCE]
    for i in range(free):
        total = slope[i]
        for k in range(i):
            total -= factor[i, k] * step[k]
        step[i] = total * factor[i, i]
    for j in range(held):
        total = gap[j]
        for i in range(free):
            total += normals[j, i] * step[i]
        for k in range(j):
            total -= schur[j, k] * force[k]
        force[j] = total * schur[j, j]
    for j in range(held - 1, -1, -1):
        total = force[j] * schur[j, j]
        force[j] = total
        for k in range(j):
            force[k] -= schur[j, k] * total
    for i in range(free):
        step[i] = -step[i]
    for j in range(held):
        for i in range(free):
            step[i] += normals[j, i] * force[j]
    for i in range(free - 1, -1, -1):
        total = step[i] * factor[i, i]
        step[i] = total
        for k in range(i):
            step[k] -= factor[i, k] * total


@kernel
def _factorise(
    hessian: Matrix,
    rows: Matrix,
    variables: IntVector,
    members: IntVector,
    factor: Matrix,
    normals: Matrix,
    schur: Matrix,
    free: int,
    held: int,
) -> bool:
    """Cholesky factors of H_FF and of V Vᵀ, with inverted diagonals; False if one has no full rank."""
    for k in range(free):
        column = variables[k]
        diagonal = hessian[column, column]
        total = diagonal
        for p in range(k):
            total -= factor[k, p] * factor[k, p]
        if not total > _PIVOT * diagonal:
            return False
        over = 1.0 / np.sqrt(total)
        factor[k, k] = over
        i = k + 1
        while i + 3 < free:  # four rows at once: each sum waits for its own last subtraction
            a, b = hessian[variables[i], column], hessian[variables[i + 1], column]
            c, d = hessian[variables[i + 2], column], hessian[variables[i + 3], column]
            for p in range(k):
                share = factor[k, p]
                a -= factor[i, p] * share
                b -= factor[i + 1, p] * share
                c -= factor[i + 2, p] * share
                d -= factor[i + 3, p] * share
            factor[i, k], factor[i + 1, k], factor[i + 2, k], factor[i + 3, k] = a * over, b * over, c * over, d * over
            i += 4
        while i < free:
            total = hessian[variables[i], column]
            for p in range(k):
                total -= factor[i, p] * factor[k, p]
            factor[i, k] = total * over
            i += 1
    for j in range(held):
        row = members[j]
        for i in range(free):
            total = rows[row, variables[i]]
            for p in range(i):
                total -= factor[i, p] * normals[j, p]
            normals[j, i] = total * factor[i, i]
        for k in range(j + 1):
            total = 0.0
            for i in range(free):
                total += normals[j, i] * normals[k, i]
            diagonal = total
            for p in range(k):
                total -= schur[j, p] * schur[k, p]
            if k < j:
                schur[j, k] = total * schur[k, k]
            else:
                if not total > DEPENDENT * DEPENDENT * diagonal:
                    return False
                schur[j, j] = 1.0 / np.sqrt(total)
    return True


@kernel
def accept_guess(qp: QuadraticProgram) -> bool:
    """Solve with the constraints in ``active`` (and all equalities) held; True if that is the solution.

    ``solution`` and ``multipliers`` are the solution if True and garbage otherwise; ``active`` is left alone. Needs
    :func:`prepare`.
    """
    n, m, base = qp.size[0], qp.size[1], qp.gradient.shape[0]
    variables, members = qp.indices[0], qp.indices[1]
    factor, vectors = qp.squares[0], qp.vectors
    metric, low, high, full = vectors[METRIC], vectors[LOW], vectors[HIGH], vectors[FULL]
    slope, gap, step, force = vectors[SLOPE], vectors[GAP], vectors[STEP], vectors[FORCE]
    x, y, active = qp.solution, qp.multipliers, qp.active
    free = held = 0
    for i in range(n):
        side = active[i]
        y[i] = 0.0
        if low[i] == high[i] or (side < 0 and low[i] > -np.inf):
            x[i] = low[i]
        elif side > 0 and high[i] < np.inf:
            x[i] = high[i]
        else:
            x[i] = 0.0
            variables[free] = i
            free += 1
    for j in range(m):
        k = base + j
        side = active[k]
        y[k] = 0.0
        if low[k] == high[k] or (side < 0 and low[k] > -np.inf) or (side > 0 and high[k] < np.inf):
            members[held] = j
            held += 1
    if held > free or not _factorise(qp.hessian, qp.rows, variables, members, factor, qp.normals, qp.schur, free, held):
        return False

    unit = worst = poison = 0.0
    for attempt in range(4):
        unit = worst = 0.0
        for i in range(n):
            full[i] = qp.gradient[i]
        for k in range(n):
            value = x[k]
            if value != 0.0:
                for i in range(n):
                    full[i] += qp.hessian[k, i] * value
        for i in range(n):
            poison += 0.0 * full[i]
            unit = max(unit, abs(qp.gradient[i]) / metric[i], abs(x[i]) * metric[i])
        for k in range(held):
            row, multiplier = members[k], y[base + members[k]]
            for i in range(n):
                full[i] -= qp.rows[row, i] * multiplier
        for i in range(free):
            slope[i] = full[variables[i]]
            worst = max(worst, abs(slope[i]) / metric[variables[i]])
        for k in range(held):
            at = base + members[k]
            limit = high[at] if active[at] > 0 and high[at] < np.inf else low[at]
            gap[k] = limit - _product(qp.rows[members[k]], x, n)
            worst = max(worst, abs(gap[k]) * metric[at])
        if worst <= 0.1 * DUAL_TOLERANCE * unit or attempt == 3:
            break
        _kkt_step(factor, qp.normals, qp.schur, vectors, free, held)
        for i in range(free):
            x[variables[i]] += step[i]
        for k in range(held):
            y[base + members[k]] += force[k]
    if poison != 0.0 or not worst <= DUAL_TOLERANCE * unit:
        return False

    for i in range(n + m):
        k = i if i < n else base + i - n
        value = x[k] if i < n else _product(qp.rows[i - n], x, n)
        slack = PRIMAL_TOLERANCE * unit / metric[k]
        if not low[k] - slack <= value <= high[k] + slack:
            return False
        if i < n and (low[k] == high[k] or active[k] != 0):
            y[k] = full[k]
        if low[k] < high[k] and active[k] * y[k] > SIGN_TOLERANCE * unit * metric[k]:
            return False
    return True
