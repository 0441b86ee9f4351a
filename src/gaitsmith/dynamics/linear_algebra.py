"""Factor and solves for the mass matrix of a tree: nothing is computed where two branches do not touch.

M = Lᵀ D L with L lower triangular and a diagonal of ones (Featherstone, Rigid Body Dynamics Algorithms, 2008, section
6.5): L[k, i] differs from zero only where i is k or lies on the way from k to the root, as in M itself.
"""

from __future__ import annotations

import math

from gaitsmith.compiled import IntVector, Matrix, kernel
from gaitsmith.compiled.lanes import LANES, entry, plus, put, take, times


@kernel
def factor_tree(a: Matrix, parent: IntVector, l: Matrix) -> bool:  # noqa: E741
    """Factor a = Lᵀ D L.

    Args:
        a: (n, n) symmetric, zero where branches do not touch; only its lower triangle is read.
        parent: (n,) the degree of freedom before each on the way to the root, -1 if none.
        l: (n, :func:`~gaitsmith.compiled.lanes.padded` n) receives L, and D⁻¹ on its diagonal; above it there
            is nothing of use.

    Returns:
        False if ``a`` is not positive definite or holds a NaN; ``l`` is then useless.
    """
    n = parent.shape[0]
    for k in range(n):
        for i in range(k + 1):
            l[k, i] = a[k, i]
        for i in range(k + 1, l.shape[1]):
            l[k, i] = 0.0
    for k in range(n - 1, -1, -1):
        if not (l[k, k] > 0.0 and l[k, k] < math.inf):
            return False
        over = 1.0 / l[k, k]
        i = parent[k]
        while i >= 0:
            share = -entry(l, k, i) * over
            for c in range(0, i + 1, LANES):
                put(l, i, c, plus(take(l, i, c), share, take(l, k, c)))
            i = parent[i]
        for c in range(0, k, LANES):
            put(l, k, c, times(take(l, k, c), over))
        l[k, k] = over
    return True


@kernel
def solve_tree(l: Matrix, parent: IntVector, b: Matrix, m: int) -> None:  # noqa: E741
    """Replace the first m columns of ``b`` by the solution of Lᵀ D L X = b; ``l`` is from :func:`factor_tree`.

    ``b`` has :func:`~gaitsmith.compiled.lanes.padded` columns; those between m and the next multiple of eight are lost.
    """
    n = parent.shape[0]
    for k in range(n - 1, -1, -1):
        i = parent[k]
        while i >= 0:
            share = -entry(l, k, i)
            for c in range(0, m, LANES):
                put(b, i, c, plus(take(b, i, c), share, take(b, k, c)))
            i = parent[i]
    for k in range(n):
        above = parent[k]
        for c in range(0, m, LANES):
            x = times(take(b, k, c), entry(l, k, k))
            if above >= 0:  # comes last: it has just been found
                i = parent[above]
                while i >= 0:
                    x = plus(x, -entry(l, k, i), take(b, i, c))
                    i = parent[i]
                x = plus(x, -entry(l, k, above), take(b, above, c))
            put(b, k, c, x)
