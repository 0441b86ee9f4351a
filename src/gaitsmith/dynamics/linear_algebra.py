"""Cholesky factor and solves for small symmetric matrices, in given storage."""

from __future__ import annotations

import math

from gaitsmith.compiled import Matrix, kernel


@kernel
def cholesky(a: Matrix, l: Matrix, n: int) -> bool:  # noqa: E741
    """Factor the leading n x n block: a = L Lᵀ.

    Args:
        a: (>= n, >= n) symmetric; only its lower triangle is read.
        l: (>= n, >= n) receives L; nothing above the diagonal is written. It may be ``a`` itself.
        n: size.

    Returns:
        False if the block is not positive definite or holds a NaN; ``l`` is then useless.
    """
    for j in range(n):
        pivot = a[j, j]
        for k in range(j):
            pivot -= l[j, k] * l[j, k]
        if not (pivot > 0.0 and pivot < math.inf):
            return False
        pivot = math.sqrt(pivot)
        over = 1.0 / pivot
        l[j, j] = pivot
        i = j + 1
        # Two rows at once: a single sum waits for its own last addition, two overlap.
        while i + 1 < n:
            upper, lower = a[i, j], a[i + 1, j]
            for k in range(j):
                factor = l[j, k]
                upper -= l[i, k] * factor
                lower -= l[i + 1, k] * factor
            l[i, j], l[i + 1, j] = upper * over, lower * over
            i += 2
        if i < n:
            upper = a[i, j]
            for k in range(j):
                upper -= l[i, k] * l[j, k]
            l[i, j] = upper * over
    return True


@kernel
def cholesky_solve_matrix(l: Matrix, b: Matrix, n: int, m: int) -> None:  # noqa: E741
    """Replace the leading n x m block of ``b`` by the solution of L Lᵀ X = b; ``l`` is from :func:`cholesky`."""
    for k in range(n):
        over = 1.0 / l[k, k]
        for j in range(m):
            b[k, j] *= over
        for i in range(k + 1, n):
            factor = l[i, k]
            for j in range(m):
                b[i, j] -= factor * b[k, j]
    for k in range(n - 1, -1, -1):
        over = 1.0 / l[k, k]
        for j in range(m):
            b[k, j] *= over
        for i in range(k):
            factor = l[k, i]
            for j in range(m):
                b[i, j] -= factor * b[k, j]
