"""Solve a quadratic program whose active set is known, and say whether the guess was right.

Fixed variables are eliminated, the rest is solved in range space: with H_FF = L Lᵀ and V = A_WF L⁻ᵀ, the multipliers
of the active rows W solve V Vᵀ u = b + V w. One refinement step follows where the residual asks for it.
"""

from __future__ import annotations

import numpy as np

from gaitsmith.compiled import Matrix, Vector, kernel
from gaitsmith.compiled.lanes import LANES, entry, none, plus, put, take, times
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
    PIVOT,
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
        for i in range(qp.span[j, 0], min(qp.span[j, 1], n)):
            poison += 0.0 * qp.rows[j, i]
    return poison == 0.0


@kernel
def _forward(factor: Matrix, over: Vector, x: Matrix, row: int, out: Vector, free: int) -> None:
    """``out = L⁻¹ x`` for a row of x; it is lost.

    What is written one by one is not read eight at a time soon after: the processor would wait.
    """
    for i in range(free):
        value = x[row, i] * over[i]
        for c in range(i // LANES * LANES, free, LANES):
            put(x, row, c, plus(take(x, row, c), -value, take(factor, i, c)))
        out[i] = value


@kernel
def _span_product(qp: QuadraticProgram, row: int, n: int) -> float:
    """A row of the problem times x."""
    first, end = qp.span[row, 0], min(qp.span[row, 1], n)
    coefficients, x, value = qp.rows[row, first:end], qp.solution[first:end], 0.0
    for i in range(end - first):
        value += coefficients[i] * x[i]
    return value


@kernel
def prepare(qp: QuadraticProgram) -> int:
    """Check the limits; gather those of all constraints in LOW and HIGH, and the bounds' scales in METRIC.

    H beside its diagonal is not looked at, nor are the rows: a guess with a number in it that is not finite is not
    accepted, and :func:`is_finite` tells why.

    Returns:
        OPTIMAL if a solve may start, else NOT_FINITE, NOT_CONVEX, or INFEASIBLE (crossed limits).
    """
    n, m, base = qp.size[0], qp.size[1], qp.gradient.shape[0]
    metric, inverse, low, high = qp.vectors[METRIC], qp.vectors[INVERSE], qp.vectors[LOW], qp.vectors[HIGH]
    poison = 0.0
    convex = True
    unbounded = crossed = False
    for i in range(n):
        diagonal = qp.hessian[i, i]
        convex = convex and not diagonal <= 0.0
        metric[i] = np.sqrt(diagonal)
        inverse[i] = 1.0 / metric[i]
        poison += 0.0 * qp.gradient[i] + 0.0 * diagonal
        below, above = qp.lower[i], qp.upper[i]
        unbounded, crossed = unbounded or not (below < np.inf and above > -np.inf), crossed or below > above
        low[i], high[i] = below, above
    for j in range(m):
        below, above = qp.row_lower[j], qp.row_upper[j]
        unbounded, crossed = unbounded or not (below < np.inf and above > -np.inf), crossed or below > above
        low[base + j], high[base + j] = below, above
    if not convex:
        return NOT_CONVEX
    if poison != 0.0 or unbounded:
        return NOT_FINITE
    return INFEASIBLE if crossed else OPTIMAL


@kernel
def row_scale(qp: QuadraticProgram, j: int) -> float:
    """The inverse norm of a row's normal in scaled units, also into METRIC."""
    first, end = qp.span[j, 0], min(qp.span[j, 1], qp.size[0])
    coefficients, units, norm = qp.rows[j, first:end], qp.vectors[INVERSE, first:end], 0.0
    for i in range(end - first):
        norm += (coefficients[i] * units[i]) ** 2
    scale = 1.0 / np.sqrt(norm) if norm > 0.0 else 1.0
    qp.vectors[METRIC, qp.gradient.shape[0] + j] = scale
    return float(scale)


@kernel
def _kkt_step(qp: QuadraticProgram, free: int, held: int) -> None:
    """Change of the free variables and of the active rows' multipliers (FORCE) that ends the slope and GAP.

    STEP is L⁻¹ times the slope before, and that change afterwards.
    """
    factor, schur, over = qp.squares[0], qp.schur, qp.vectors[PIVOT]
    gap, step, force = qp.vectors[GAP], qp.vectors[STEP], qp.vectors[FORCE]
    for j in range(held):
        found = 0.0
        for i in range(free):
            found += factor[i, free + j] * step[i]
        found += gap[j]
        for k in range(j):
            found -= schur[j, k] * force[k]
        force[j] = found * schur[j, j]
    for j in range(held - 1, -1, -1):
        found = force[j] * schur[j, j]
        force[j] = found
        for k in range(j):
            force[k] -= schur[j, k] * found
    for i in range(free):
        value = -step[i]
        for j in range(held):
            value += factor[i, free + j] * force[j]
        step[i] = value
    for i in range(free - 1, -1, -1):
        value, more, count = step[i], 0.0, free - 1 - i
        for k in range(count // 2):  # the neighbours come last: they have just been found
            last = free - 1 - 2 * k
            value -= entry(factor, i, last) * entry(qp.vectors, STEP, last)
            more -= entry(factor, i, last - 1) * entry(qp.vectors, STEP, last - 1)
        if count % 2 == 1:
            value -= factor[i, i + 1] * step[i + 1]
        step[i] = (value + more) * over[i]


@kernel
def _factorise(qp: QuadraticProgram, free: int, held: int) -> bool:
    """Factors of H_FF = L Lᵀ and of V Vᵀ; STEP becomes L⁻¹ SLOPE, which is lost. False if one has no full rank.

    Kept are Lᵀ without its diagonal, with nothing of use in front of it, and the inverted diagonals. The columns behind
    Lᵀ are Vᵀ = L⁻¹ A_WFᵀ: they come with the elimination.
    """
    variables, members, factor, over = qp.indices[0], qp.indices[1], qp.squares[0], qp.vectors[PIVOT]
    gram, schur, vectors, step, width = qp.gram, qp.schur, qp.vectors, qp.vectors[STEP], free + held
    for k in range(free):
        first = k // LANES * LANES
        column, line, which = qp.hessian[variables[k]], factor[k, first:free], variables[first:free]
        if free == qp.size[0]:
            column = column[first:free]
            for i in range(free - first):
                line[i] = column[i]
        else:
            for i in range(free - first):
                line[i] = column[which[i]]
        for j in range(held):
            factor[k, free + j] = qp.rows[members[j], variables[k]]
        for i in range(width, (width + LANES - 1) // LANES * LANES):
            factor[k, i] = 0.0
        over[k] = factor[k, k]
    for k in range(free):
        pivot = factor[k, k]
        if not pivot > _PIVOT * over[k]:
            return False
        inverse = 1.0 / pivot
        slope = entry(vectors, SLOPE, k)
        for c in range((k + 1) // LANES * LANES, width, LANES):
            line = times(take(factor, k, c), -inverse)
            for i in range(k + 1, min(free, c + LANES)):
                put(factor, i, c, plus(take(factor, i, c), entry(factor, k, i), line))
        for c in range((k + 1) // LANES * LANES, free, LANES):
            put(vectors, SLOPE, c, plus(take(vectors, SLOPE, c), -inverse * slope, take(factor, k, c)))
        over[k] = np.sqrt(inverse)
        step[k] = slope * over[k]
    for k in range(free):
        for c in range(k // LANES * LANES, width, LANES):
            put(factor, k, c, times(take(factor, k, c), over[k]))
    for j in range(held):
        for c in range(0, held, LANES):
            found = none()
            for k in range(free):
                found = plus(found, entry(factor, k, free + j), take(factor, k, free + c))
            put(gram, j, c, found)
    for j in range(held):
        for k in range(j + 1):
            rest = gram[j, k]
            for p in range(k):
                rest -= schur[j, p] * schur[k, p]
            if k < j:
                schur[j, k] = rest * schur[k, k]
            else:
                if not rest > DEPENDENT * DEPENDENT * gram[j, j]:
                    return False
                schur[j, j] = 1.0 / np.sqrt(rest)
    return True


@kernel
def _holds(vectors: Matrix, k: int, value: float, multiplier: float, side: int, unit: float) -> bool:
    """Whether constraint k is met and its multiplier has the right sign."""
    low, high, metric, slack = vectors[LOW, k], vectors[HIGH, k], vectors[METRIC, k], PRIMAL_TOLERANCE * unit
    if not ((low - value) * metric <= slack and (value - high) * metric <= slack):
        return False
    return not (low < high and side * multiplier > SIGN_TOLERANCE * unit * metric)


@kernel
def accept_guess(qp: QuadraticProgram) -> bool:
    """Solve with the constraints in ``active`` (and all equalities) held; True if that is the solution.

    ``solution`` and ``multipliers`` are the solution if True and garbage otherwise; ``active`` is left alone. Needs
    :func:`prepare`.
    """
    n, m, base = qp.size[0], qp.size[1], qp.gradient.shape[0]
    variables, members, vectors = qp.indices[0], qp.indices[1], qp.vectors
    metric, inverse, low, high, full = vectors[METRIC], vectors[INVERSE], vectors[LOW], vectors[HIGH], vectors[FULL]
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
            row_scale(qp, j)
            held += 1
    if held > free:
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
            unit = max(unit, abs(qp.gradient[i]) * inverse[i], abs(x[i]) * metric[i])
        for k in range(held):
            row, multiplier = members[k], y[base + members[k]]
            for i in range(n):
                full[i] -= qp.rows[row, i] * multiplier
        for i in range(free):
            slope[i] = full[variables[i]]
            worst = max(worst, abs(slope[i]) * inverse[variables[i]])
        for k in range(held):
            at = base + members[k]
            limit = high[at] if active[at] > 0 and high[at] < np.inf else low[at]
            gap[k] = limit - _span_product(qp, members[k], n)
            worst = max(worst, abs(gap[k]) * metric[at])
        if attempt == 0 and not _factorise(qp, free, held):
            return False
        if worst <= 0.1 * DUAL_TOLERANCE * unit or attempt == 3:
            break
        if attempt > 0:
            _forward(qp.squares[0], vectors[PIVOT], vectors, SLOPE, step, free)
        _kkt_step(qp, free, held)
        for i in range(free):
            x[variables[i]] += step[i]
        for k in range(held):
            y[base + members[k]] += force[k]
    if poison != 0.0 or not worst <= DUAL_TOLERANCE * unit:
        return False

    for i in range(n):
        if low[i] == high[i] or active[i] != 0:
            y[i] = full[i]
        elif low[i] < x[i] < high[i] and abs(x[i]) < np.inf:
            continue
        if not _holds(vectors, i, x[i], y[i], active[i], unit):
            return False
    for j in range(m):
        k, value = base + j, _span_product(qp, j, n)
        if low[k] < value < high[k] and abs(value) < np.inf and active[k] == 0:
            continue
        row_scale(qp, j)
        if not _holds(vectors, k, value, y[k], active[k], unit):
            return False
    return True
