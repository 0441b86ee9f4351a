"""The quadratic program of an SQP step, started from a good guess of the active set.

min ½ dᵀHd + gᵀd subject to A d = b and low <= J d <= high. The splines make H and the rows banded in time. Equalities
and the surely active bounds are therefore held by one sparse factorisation of the optimality conditions. The few
doubtful bounds, at which the guess proves wrong, make a small dense quadratic program on top of it. The doubtful set
only grows, so the iteration terminates.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import daqp
import numpy as np
import numpy.typing as npt
import scipy.sparse as sp
import scipy.sparse.linalg as sl

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]
_SOFT = 1e-10  # of a row per unit of its multiplier: rows that depend on others do not make the matrix singular
_BEYOND = 1e-8  # of a row's range; what counts as beyond a bound
_RIDGE = 1e-9  # relative; doubtful bounds that depend on each other
_TRIFLE = 1e-9  # share of the largest multiplier
_ROUNDS = 30
_DOUBTS = 1000


@dataclass(frozen=True, eq=False)
class ActiveStep:
    """A step and what it rests on.

    Attributes:
        step: (n,) change of the unknowns.
        multipliers: (rows,) of equalities and bounds; positive at an upper bound.
        held: (k,) rows that hold with equality; doubtful ones to about 1e-6.
        H, jacobian: of the program.
        factor: of the optimality conditions with the held rows, where the last one is that.
    """

    step: Array
    multipliers: Array
    held: Indices
    H: sp.spmatrix
    jacobian: sp.csr_matrix
    factor: KktFactor | None

    def conditions(self) -> KktFactor:
        """The optimality conditions with the held rows, factorised."""
        return self.factor or KktFactor(self.H, self.jacobian[self.held])


class KktFactor:
    """Optimality conditions with some rows held: factorised once, solved often.

    Args:
        H: (n, n) curvature.
        rows: (k, n) rows that are held.

    Raises:
        RuntimeError: the matrix is singular.
    """

    def __init__(self, H: sp.spmatrix, rows: sp.csr_matrix) -> None:
        self.size, count = H.shape[0], rows.shape[0]
        left = sp.vstack([sp.csr_matrix(H), rows], format="csr").tocsc()
        right = sp.csc_matrix((rows.data, rows.indices, rows.indptr), shape=rows.shape[::-1])  # their transpose
        ends = right.indptr[1:]
        data = np.insert(right.data, ends, -_SOFT)
        places = np.insert(right.indices, ends, self.size + np.arange(count))
        starts = left.indptr[-1] + right.indptr + np.arange(count + 1)
        self._matrix = sp.csc_matrix(
            (
                np.concatenate([left.data, data]),
                np.concatenate([left.indices, places]),
                np.concatenate([left.indptr, starts[1:]]),
            ),
            shape=(self.size + count, self.size + count),
        )
        self._factors: Any = sl.splu(self._matrix)

    def solve(self, right: Array) -> Array:
        """Unknowns and multipliers for a right-hand side (n + k,), refined once."""
        found = self._factors.solve(right)
        return np.asarray(found + self._factors.solve(right - self._matrix @ found))

    def pushed(self, rows: sp.csr_matrix) -> Array:
        """(n + k, j) what a unit of multiplier on each of further rows (j, n) does."""
        right = np.zeros((self._matrix.shape[0], rows.shape[0]))
        right[: self.size] = rows.toarray().T
        return np.asarray(self._factors.solve(right))

    def towards(self, gaps: Array) -> Array:
        """Change (n,) of the unknowns that moves the held rows by ``gaps`` (k,)."""
        return self.solve(np.concatenate([np.zeros(self.size), gaps]))[: self.size]


def active_set_step(
    H: sp.spmatrix, gradient: Array, jacobian: sp.csr_matrix, low: Array, high: Array, guess: Array
) -> ActiveStep | None:
    """Solve the quadratic program; None where the guess was too far away or H curves downwards.

    Args:
        H: (n, n) curvature.
        gradient: (n,) of the objective.
        jacobian: (rows, n); equalities are rows whose ``low`` and ``high`` agree.
        low, high: (rows,) bounds on the change of the rows.
        guess: (rows,) multipliers. A bound is surely met when its multiplier outweighs its distance.
    """
    n, equal = len(gradient), high - low <= 0.0
    side = np.where(guess > np.maximum(high, 0.0), 1, np.where(-guess > np.maximum(-low, 0.0), -1, 0))
    side[equal] = 0
    doubt, turn = np.zeros(0, dtype=np.int64), np.zeros(0)  # rows, and +1 at the upper or -1 at the lower bound
    for _ in range(_ROUNDS):
        held = np.flatnonzero(equal | (side != 0))
        goal = np.where(side[held] < 0, low[held], high[held])
        try:
            conditions = KktFactor(H, jacobian[held])
        except RuntimeError:
            return None
        base = conditions.solve(np.concatenate([-gradient, goal]))
        pushes = conditions.pushed(sp.diags(turn) @ jacobian[doubt])
        while True:
            weights = _small(sp.diags(turn) @ jacobian[doubt], pushes[:n], base[:n], turn, low[doubt], high[doubt])
            if weights is None or len(doubt) > _DOUBTS:
                return None
            found = base - pushes @ weights
            lam = np.zeros(len(low))
            lam[held] = found[n:]
            # Bounds held with a multiplier of the wrong sign come first: they push the step beyond many others.
            wrong = np.flatnonzero(side * lam < 0.0)
            change = jacobian @ found[:n]
            free = ~equal & (side == 0)
            above, below = free & (change > high + _BEYOND), free & (change < low - _BEYOND)
            above[doubt[turn > 0]], below[doubt[turn < 0]] = False, False
            new = np.flatnonzero(above | below)
            if len(wrong) or not len(new):
                break
            sign = np.where(above[new], 1.0, -1.0)
            pushes = np.hstack([pushes, conditions.pushed(sp.diags(sign) @ jacobian[new])])
            doubt, turn = np.concatenate([doubt, new]), np.concatenate([turn, sign])
        if not len(wrong):
            met = weights > _TRIFLE * weights.max(initial=0.0)
            lam[doubt[met]] = (turn * weights)[met]
            side[doubt[met]] = turn[met]
            held = np.flatnonzero(equal | (side != 0))
            same = None if np.any(met) else conditions
            return ActiveStep(found[:n], lam, held, H, jacobian, same) if np.isfinite(found).all() else None
        doubt, turn = np.concatenate([doubt, wrong]), np.concatenate([turn, side[wrong].astype(np.float64)])
        side[wrong] = 0
    return None


def _small(rows: sp.csr_matrix, pushes: Array, base: Array, turn: Array, low: Array, high: Array) -> Array | None:
    """Multipliers (j,) at least 0 of the doubtful rows, by DAQP; None if H curves downwards along one of them."""
    count = len(turn)
    if count == 0:
        return np.zeros(0)
    excess = rows @ base - np.where(turn > 0, high, -low)
    G = np.asarray(rows @ pushes)
    G = 0.5 * (G + G.T)
    G[np.diag_indices(count)] += _RIDGE * float(np.abs(np.diag(G)).max())
    try:
        np.linalg.cholesky(G)
    except np.linalg.LinAlgError:
        return None
    nothing, sense = np.zeros((0, count)), np.zeros(count, dtype=np.int32)
    found, _, flag, _ = daqp.solve(G, -excess, nothing, np.full(count, 1e30), np.zeros(count), sense, iter_limit=2000)
    return np.maximum(found, 0.0) if flag > 0 and np.isfinite(found).all() else None
