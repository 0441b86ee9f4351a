"""Factor and solves for the mass matrix of a tree: nothing is computed where two branches do not touch.

M = Lᵀ L with L lower triangular (Featherstone, Rigid Body Dynamics Algorithms, 2008, section 6.5): L[k, i] differs from
zero only where i is k or lies on the way from k to the root, as in M itself.
"""

from __future__ import annotations

import math

from gaitsmith.compiled import IntVector, Matrix, kernel
from gaitsmith.compiled.lanes import LANES, plus, put, take, times


@kernel
def factor_tree(a: Matrix, parent: IntVector, l: Matrix) -> bool:  # noqa: E741
    """Factor a = Lᵀ L.

    Args:
        a: (n, n) symmetric; only its lower triangle is read.
        parent: (n,) the degree of freedom before each on the way to the root, -1 if none.
        l: (n, n) receives L, with the inverse of its diagonal; elsewhere than on the branches nothing is written.

    Returns:
        False if ``a`` is not positive definite or holds a NaN; ``l`` is then useless.
    """
    n = parent.shape[0]
    for k in range(n):
        i = k
        while i >= 0:
            l[k, i] = a[k, i]
            i = parent[i]
    for k in range(n - 1, -1, -1):
        if not (l[k, k] > 0.0 and l[k, k] < math.inf):
            return False
        over = 1.0 / math.sqrt(l[k, k])
        l[k, k] = over
        i = parent[k]
        while i >= 0:
            l[k, i] *= over
            i = parent[i]
        i = parent[k]
        while i >= 0:
            j = i
            while j >= 0:
                l[i, j] -= l[k, i] * l[k, j]
                j = parent[j]
            i = parent[i]
    return True


@kernel
def solve_tree(l: Matrix, parent: IntVector, b: Matrix, m: int) -> None:  # noqa: E741
    """Replace the first m columns of ``b`` by the solution of Lᵀ L X = b; ``l`` is from :func:`factor_tree`.

    ``b`` has :func:`~gaitsmith.compiled.lanes.padded` columns; those between m and the next multiple of eight are lost.
    """
    n = parent.shape[0]
    for c in range(0, m, LANES):
        for k in range(n - 1, -1, -1):
            x = times(take(b, k, c), l[k, k])
            put(b, k, c, x)
            i = parent[k]
            while i >= 0:
                put(b, i, c, plus(take(b, i, c), -l[k, i], x))
                i = parent[i]
        for k in range(n):
            x = take(b, k, c)
            above = parent[k]
            if above >= 0:  # comes last: it has just been found
                i = parent[above]
                while i >= 0:
                    x = plus(x, -l[k, i], take(b, i, c))
                    i = parent[i]
                x = plus(x, -l[k, above], take(b, above, c))
            put(b, k, c, times(x, l[k, k]))
