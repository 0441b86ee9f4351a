"""Solve a quadratic program whose active set is known, and say whether the guess was right.

Fixed variables are eliminated, the rest is solved in range space: with H_FF = L Lᵀ and V = A_WF L⁻ᵀ, the multipliers
of the active rows W solve V Vᵀ u = b + V w. One refinement step follows where the residual asks for it.
"""

from __future__ import annotations

import numpy as np

from gaitsmith.compiled import kernel
from gaitsmith.control._qp_storage import (
    DEPENDENT,
    DUAL_TOLERANCE,
    INFEASIBLE,
    NOT_CONVEX,
    NOT_FINITE,
    OPTIMAL,
    PRIMAL_TOLERANCE,
    QuadraticProgram,
)

_PIVOT = 1e-14  # smallest Cholesky pivot relative to its diagonal entry: below it only rounding is left


@kernel
def prepare(qp: QuadraticProgram) -> int:
    """Check the data and fill ``vectors[0]``: the inverse norm of every constraint's normal in scaled units.

    Returns:
        OPTIMAL if a solve may start, else NOT_FINITE, NOT_CONVEX, or INFEASIBLE (crossed limits).
    """
    n, m, base = qp.size[0], qp.size[1], qp.gradient.shape[0]
    metric, inverse = qp.vectors[0], qp.vectors[1]
    poison = 0.0
    positive = True
    crossed = False
    for i in range(n):
        diagonal = qp.hessian[i, i]
        positive = positive and diagonal > 0.0
        metric[i] = np.sqrt(diagonal)
        inverse[i] = 1.0 / metric[i]
        poison += 0.0 * qp.gradient[i]
        for k in range(n):
            poison += 0.0 * qp.hessian[i, k]
        low, high = qp.lower[i], qp.upper[i]
        if not (low < np.inf and high > -np.inf):
            poison = np.nan
        crossed = crossed or low > high
    for j in range(m):
        total = 0.0
        for i in range(n):
            entry = qp.rows[j, i] * inverse[i]
            total += entry * entry
        poison += 0.0 * total
        metric[base + j] = 1.0 / np.sqrt(total) if total > 0.0 else 1.0
        low, high = qp.row_lower[j], qp.row_upper[j]
        if not (low < np.inf and high > -np.inf):
            poison = np.nan
        crossed = crossed or low > high
    if not positive:
        for i in range(n):
            if qp.hessian[i, i] != qp.hessian[i, i]:
                return NOT_FINITE
        return NOT_CONVEX
    if poison != 0.0:
        return NOT_FINITE
    return INFEASIBLE if crossed else OPTIMAL


@kernel
def _kkt_step(qp: QuadraticProgram, free: int, held: int) -> None:
    """Solve for the free variables and the active rows' multipliers from the residuals in vectors[3] and vectors[4].

    On return vectors[5][:free] is the change of x and vectors[6][:held] that of the multipliers.
    """
    factor, normals, schur = qp.squares[0], qp.normals, qp.schur
    slope, gap, step, force = qp.vectors[3], qp.vectors[4], qp.vectors[5], qp.vectors[6]
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
def _factorise(qp: QuadraticProgram, free: int, held: int) -> bool:
    """Cholesky factors of H_FF and of V Vᵀ, with inverted diagonals; False if one has no full rank."""
    factor, normals, schur = qp.squares[0], qp.normals, qp.schur
    variables, members = qp.indices[0], qp.indices[1]
    for i in range(free):
        row = variables[i]
        for k in range(i):
            total = qp.hessian[row, variables[k]]
            for p in range(k):
                total -= factor[i, p] * factor[k, p]
            factor[i, k] = total * factor[k, k]
        diagonal = qp.hessian[row, row]
        total = diagonal
        for p in range(i):
            total -= factor[i, p] * factor[i, p]
        if not total > _PIVOT * diagonal:
            return False
        factor[i, i] = 1.0 / np.sqrt(total)
    for j in range(held):
        row = members[j]
        for i in range(free):
            total = qp.rows[row, variables[i]]
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
    metric, full = qp.vectors[0], qp.vectors[2]
    slope, gap, step, force = qp.vectors[3], qp.vectors[4], qp.vectors[5], qp.vectors[6]
    x, y, active = qp.solution, qp.multipliers, qp.active
    free = held = 0
    for i in range(n):
        side = active[i]
        y[i] = 0.0
        if qp.lower[i] == qp.upper[i] or (side < 0 and qp.lower[i] > -np.inf):
            x[i] = qp.lower[i]
        elif side > 0 and qp.upper[i] < np.inf:
            x[i] = qp.upper[i]
        else:
            x[i] = 0.0
            variables[free] = i
            free += 1
    for j in range(m):
        side = active[base + j]
        y[base + j] = 0.0
        if (
            qp.row_lower[j] == qp.row_upper[j]
            or (side < 0 and qp.row_lower[j] > -np.inf)
            or (side > 0 and qp.row_upper[j] < np.inf)
        ):
            members[held] = j
            held += 1
            if held > free:
                return False
    if not _factorise(qp, free, held):
        return False

    for attempt in range(4):
        unit = 0.0
        for i in range(n):
            total = qp.gradient[i]
            for k in range(n):
                total += qp.hessian[i, k] * x[k]
            full[i] = total
            unit = max(unit, abs(qp.gradient[i]) / metric[i], abs(x[i]) * metric[i])
        for k in range(held):
            row, multiplier = members[k], y[base + members[k]]
            for i in range(n):
                full[i] -= qp.rows[row, i] * multiplier
        for j in range(m):
            total = 0.0
            for i in range(n):
                total += qp.rows[j, i] * x[i]
            full[base + j] = total
        worst = 0.0
        for i in range(free):
            slope[i] = full[variables[i]]
            worst = max(worst, abs(slope[i]) / metric[variables[i]])
        for k in range(held):
            row = members[k]
            at_upper = active[base + row] > 0 and qp.row_upper[row] < np.inf
            limit = qp.row_upper[row] if at_upper else qp.row_lower[row]
            gap[k] = limit - full[base + row]
            worst = max(worst, abs(gap[k]) * metric[base + row])
        if worst <= 0.1 * DUAL_TOLERANCE * unit or attempt == 3:
            break
        _kkt_step(qp, free, held)
        for i in range(free):
            x[variables[i]] += step[i]
        for k in range(held):
            y[base + members[k]] += force[k]
    if not worst <= DUAL_TOLERANCE * unit:
        return False

    for i in range(n):
        low, high = qp.lower[i], qp.upper[i]
        slack = PRIMAL_TOLERANCE * unit / metric[i]
        if not low - slack <= x[i] <= high + slack:
            return False
        if low < high:
            if active[i] < 0 and low > -np.inf:
                y[i] = full[i]
                if y[i] < -DUAL_TOLERANCE * unit * metric[i]:
                    return False
            elif active[i] > 0 and high < np.inf:
                y[i] = full[i]
                if y[i] > DUAL_TOLERANCE * unit * metric[i]:
                    return False
        else:
            y[i] = full[i]
    for j in range(m):
        k = base + j
        slack = PRIMAL_TOLERANCE * unit / metric[k]
        if not qp.row_lower[j] - slack <= full[k] <= qp.row_upper[j] + slack:
            return False
        if qp.row_lower[j] < qp.row_upper[j] and active[k] * y[k] > DUAL_TOLERANCE * unit * metric[k]:
            return False
    return True
