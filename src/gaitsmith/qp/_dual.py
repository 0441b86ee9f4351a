"""Dual active-set method of Goldfarb and Idnani (Mathematical Programming 27, 1983) for two-sided constraints.

With H = L Lᵀ and an orthogonal Q, the basis J = L⁻ᵀ Q turns the normals N of the working set into Nᵀ J = [Rᵀ 0]. The
solution held by the working set is x = J₁ R⁻ᵀ b - J₂ J₂ᵀ g with multipliers R u = R⁻ᵀ b + J₁ᵀ g. Each step adds the
most violated constraint, dropping those whose multipliers would change sign.
"""

from __future__ import annotations

import numpy as np

from gaitsmith.compiled import IntVector, Matrix, Vector, kernel
from gaitsmith.qp._storage import (
    DEPENDENT,
    DUAL_TOLERANCE,
    FORCE,
    GAP,
    HIGH,
    INFEASIBLE,
    INFEASIBLE_TOLERANCE,
    ITERATION_LIMIT,
    LOW,
    METRIC,
    MULTIPLIER,
    NORMAL,
    NOT_CONVEX,
    OPTIMAL,
    PRIMAL_TOLERANCE,
    SIDE,
    SLOPE,
    STEP,
    QuadraticProgram,
)

_PIVOT = 1e-14
_BLOCKING = 1e-11  # a multiplier that falls slower than this, in scaled units, is only moved by rounding

_FREE, _INEQUALITY, _EQUALITY, _IGNORED = 0, 1, 2, 3


@kernel
def _make_basis(hessian: Matrix, factor: Matrix, basis: Matrix, n: int) -> bool:
    """Rows of ``basis`` become the columns of L⁻ᵀ; False if H is not positive definite."""
    for i in range(n):
        for k in range(i):
            total = hessian[i, k]
            for p in range(k):
                total -= factor[i, p] * factor[k, p]
            factor[i, k] = total * factor[k, k]
        total = hessian[i, i]
        for p in range(i):
            total -= factor[i, p] * factor[i, p]
        if not total > _PIVOT * hessian[i, i]:
            return False
        factor[i, i] = 1.0 / np.sqrt(total)
    for i in range(n):
        for k in range(n):
            basis[i, k] = 0.0
        for p in range(i):
            share = factor[i, p]
            for k in range(p + 1):
                basis[i, k] -= share * basis[p, k]
        for k in range(i):
            basis[i, k] *= factor[i, i]
        basis[i, i] = factor[i, i]
    return True


@kernel
def _project(qp: QuadraticProgram, basis: Matrix, n: int, base: int, k: int, sign: float, into: Vector) -> float:
    """``into`` = Jᵀ times the signed normal of constraint k; returns its squared norm."""
    norm, j = 0.0, k - base
    for i in range(n):
        if k < base:
            total = basis[i, k]
        else:
            total = 0.0
            for p in range(qp.span[j, 0], min(qp.span[j, 1], n)):
                total += basis[i, p] * qp.rows[j, p]
        into[i] = sign * total
        norm += total * total
    return norm


@kernel
def _append(basis: Matrix, triangle: Matrix, d: Vector, sweep: Vector, n: int, q: int) -> None:
    """Make the constraint with d = Jᵀ normal the last of the working set: one reflection of the basis."""
    tail = 0.0
    for k in range(q, n):
        tail += d[k] * d[k]
    corner = -np.sqrt(tail) if d[q] > 0.0 else np.sqrt(tail)
    for k in range(q):
        triangle[q, k] = d[k]
    triangle[q, q] = corner
    head = d[q] - corner
    length = tail - d[q] * d[q] + head * head
    if length <= 0.0:
        return
    for p in range(n):
        sweep[p] = head * basis[q, p]
    for k in range(q + 1, n):
        for p in range(n):
            sweep[p] += d[k] * basis[k, p]
    share = 2.0 / length * head
    for p in range(n):
        basis[q, p] -= share * sweep[p]
    for k in range(q + 1, n):
        share = 2.0 / length * d[k]
        for p in range(n):
            basis[k, p] -= share * sweep[p]


@kernel
def _remove(
    basis: Matrix, triangle: Matrix, working: IntVector, u: Vector, sides: Vector, n: int, q: int, at: int
) -> None:
    """Take entry ``at`` out of a working set of q constraints: plane rotations restore the triangle."""
    for j in range(at, q - 1):
        working[j] = working[j + 1]
        u[j] = u[j + 1]
        sides[j] = sides[j + 1]
        for k in range(j + 2):
            triangle[j, k] = triangle[j + 1, k]
    for k in range(at, q - 1):
        radius = np.hypot(triangle[k, k], triangle[k, k + 1])
        cosine, sine = triangle[k, k] / radius, triangle[k, k + 1] / radius
        triangle[k, k] = radius
        for j in range(k + 1, q - 1):
            first, second = triangle[j, k], triangle[j, k + 1]
            triangle[j, k] = cosine * first + sine * second
            triangle[j, k + 1] = cosine * second - sine * first
        for p in range(n):
            first, second = basis[k, p], basis[k + 1, p]
            basis[k, p] = cosine * first + sine * second
            basis[k + 1, p] = cosine * second - sine * first


@kernel
def _hold(
    gradient: Vector, basis: Matrix, triangle: Matrix, vectors: Matrix, working: IntVector, x: Vector, n: int, q: int
) -> None:
    """Solution and multipliers held by the working set of q constraints."""
    slope, target, u, sides = vectors[SLOPE], vectors[GAP], vectors[MULTIPLIER], vectors[SIDE]
    for p in range(n):
        x[p] = 0.0
    for i in range(n):
        total = 0.0
        for p in range(n):
            total += basis[i, p] * gradient[p]
        slope[i] = total
    for j in range(q):
        k = working[j]
        total = vectors[LOW, k] if sides[j] > 0.0 else -vectors[HIGH, k]
        for p in range(j):
            total -= triangle[j, p] * target[p]
        target[j] = total / triangle[j, j]
        u[j] = target[j] + slope[j]
    for j in range(q - 1, -1, -1):
        u[j] /= triangle[j, j]
        for k in range(j):
            u[k] -= triangle[j, k] * u[j]
    for i in range(n):
        share = target[i] if i < q else -slope[i]
        for p in range(n):
            x[p] += share * basis[i, p]


@kernel
def _seed(qp: QuadraticProgram) -> int:
    """Working set from the equalities and the stored active set, dual feasible; returns its size."""
    n, m, base = qp.size[0], qp.size[1], qp.gradient.shape[0]
    basis, triangle, vectors = qp.squares[1], qp.squares[2], qp.vectors
    low, high, d, u = vectors[LOW], vectors[HIGH], vectors[NORMAL], vectors[MULTIPLIER]
    sides, working, kind = vectors[SIDE], qp.indices[0], qp.indices[2]
    q = 0
    for turn in range(2):
        for i in range(n + m):
            k = i if i < n else base + i - n
            equal = low[k] == high[k]
            if turn == 0:
                kind[k] = _FREE
            if equal != (turn == 0) or (not equal and qp.active[k] == 0) or q == n:
                continue
            sign = -1.0 if qp.active[k] > 0 else 1.0
            if not abs(low[k] if sign > 0.0 else high[k]) < np.inf:
                continue
            norm = _project(qp, basis, n, base, k, sign, d)
            tail = 0.0
            for p in range(q, n):
                tail += d[p] * d[p]
            if tail > DEPENDENT * DEPENDENT * norm:
                _append(basis, triangle, d, vectors[STEP], n, q)
                working[q], sides[q] = k, sign
                kind[k] = _EQUALITY if equal else _INEQUALITY
                q += 1
    while True:
        _hold(qp.gradient, basis, triangle, vectors, working, qp.solution, n, q)
        worst, at = 0.0, -1
        for j in range(q):
            scaled = u[j] / vectors[METRIC, working[j]]
            if kind[working[j]] == _INEQUALITY and scaled < worst:
                worst, at = scaled, j
        if at < 0:
            return q
        kind[working[at]] = _FREE
        _remove(basis, triangle, working, u, sides, n, q, at)
        q -= 1


@kernel
def _most_violated(
    qp: QuadraticProgram, vectors: Matrix, kind: IntVector, x: Vector, n: int, m: int, unit: float
) -> tuple[int, float, float]:
    """Constraint outside the working set with the largest scaled violation, its side, and that violation."""
    metric, low, high = vectors[METRIC], vectors[LOW], vectors[HIGH]
    base = x.shape[0]
    chosen, side, worst = -1, 0.0, PRIMAL_TOLERANCE * unit
    for i in range(n + m):
        k = i if i < n else base + i - n
        if kind[k] != _FREE:
            continue
        if i < n:
            value = x[k]
        else:
            value = 0.0
            for p in range(qp.span[i - n, 0], min(qp.span[i - n, 1], n)):
                value += qp.rows[i - n, p] * x[p]
        below, above = (low[k] - value) * metric[k], (value - high[k]) * metric[k]
        if below > worst:
            chosen, side, worst = k, 1.0, below
        if above > worst:
            chosen, side, worst = k, -1.0, above
    return chosen, side, worst


@kernel
def solve_dual(qp: QuadraticProgram, iteration_limit: int) -> tuple[int, int]:
    """Run the dual method from the stored active set; needs ``prepare``.

    Returns:
        Status and iterations (constraints added or dropped after the start). ``solution``, ``multipliers``, and
        ``active`` describe the last working set, whatever the status (zeros if H is not positive definite).
    """
    n, m, base = qp.size[0], qp.size[1], qp.gradient.shape[0]
    basis, triangle, vectors = qp.squares[1], qp.squares[2], qp.vectors
    metric, r, d, u, sides = vectors[METRIC], vectors[FORCE], vectors[NORMAL], vectors[MULTIPLIER], vectors[SIDE]
    working, kind, x = qp.indices[0], qp.indices[2], qp.solution
    if not _make_basis(qp.hessian, qp.squares[0], basis, n):
        return NOT_CONVEX, 0
    q = _seed(qp)
    iterations = 0
    status = OPTIMAL
    while status == OPTIMAL:
        unit = 0.0
        for i in range(n):
            unit = max(unit, abs(qp.gradient[i]) / metric[i], abs(x[i]) * metric[i])
        entering, side, worst = _most_violated(qp, vectors, kind, x, n, m, unit)
        if entering < 0:
            break
        gain = 0.0
        equal = vectors[LOW, entering] == vectors[HIGH, entering]
        while True:
            iterations += 1
            if iterations > iteration_limit:
                status = ITERATION_LIMIT
                break
            norm = _project(qp, basis, n, base, entering, side, d)
            tail = 0.0
            for k in range(q, n):
                tail += d[k] * d[k]
            for j in range(q):
                r[j] = d[j]
            partial, at = np.inf, -1
            for j in range(q - 1, -1, -1):
                r[j] /= triangle[j, j]
                for k in range(j):
                    r[k] -= triangle[j, k] * r[j]
            for j in range(q):
                k = working[j]
                if kind[k] == _INEQUALITY and r[j] * metric[entering] > _BLOCKING * metric[k]:
                    ratio = max(u[j], 0.0) / r[j]
                    if ratio < partial:
                        partial, at = ratio, j
            violation = worst / metric[entering]
            step = np.inf
            if tail > DEPENDENT * DEPENDENT * norm:
                step = violation / tail
            if at < 0 and not step < np.inf:
                if worst <= INFEASIBLE_TOLERANCE * unit:
                    kind[entering] = _IGNORED
                else:
                    status = INFEASIBLE
                break
            length = min(step, partial)
            for j in range(q):
                u[j] -= length * r[j]
            gain += length
            if step < np.inf:
                for k in range(q, n):
                    share = length * d[k]
                    for p in range(n):
                        x[p] += share * basis[k, p]
                worst = (violation - length * tail) * metric[entering]
            if step <= partial:
                _append(basis, triangle, d, vectors[STEP], n, q)
                working[q], sides[q], u[q] = entering, side, gain
                kind[entering] = _EQUALITY if equal else _INEQUALITY
                q += 1
                break
            kind[working[at]] = _FREE
            _remove(basis, triangle, working, u, sides, n, q, at)
            q -= 1

    if status == OPTIMAL:
        _hold(qp.gradient, basis, triangle, vectors, working, x, n, q)
    for i in range(n + m):
        k = i if i < n else base + i - n
        qp.active[k] = 0
        qp.multipliers[k] = 0.0
    for j in range(q):
        k = working[j]
        multiplier = sides[j] * u[j]
        qp.multipliers[k] = multiplier
        if kind[k] == _EQUALITY:
            qp.active[k] = 1 if multiplier < 0.0 else -1
        else:
            qp.active[k] = -1 if sides[j] > 0.0 else 1
            if u[j] < -DUAL_TOLERANCE * unit * metric[k]:
                status = ITERATION_LIMIT
    return status, iterations
