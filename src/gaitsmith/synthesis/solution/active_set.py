"""The quadratic program of an SQP step, on what its equalities leave free, from a guess of the active bounds.

min ½ dᵀHd + gᵀd subject to A d = b and low <= J d <= high. The equalities leave d = f + Z e free, A f = b and A Z = 0.
With ZᵀHZ = L Lᵀ and y = Lᵀ(e - e*), e* the least without bounds, what is left is the shortest y within the
bounds: DAQP's own form. It is given the bounds of the guess and those which turn out to be exceeded, no others; these
only grow, so the iteration terminates.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import daqp
import numpy as np
import numpy.typing as npt
import scipy.linalg as la
import scipy.sparse as sp

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]
_BEYOND = 1e-8  # of a row's range; what counts as beyond a bound
_DEPENDENT = 1e-9  # of the largest: diagonal of R of a row that others say already
_FLAT = 1e-6  # of the largest curvature, the least that a step assumes
_LENT = 1.0  # of the largest curvature, what a bound that is met lends
_TRIFLE = 1e-9  # share of the largest multiplier
_ROUNDS = 30
_LIMIT, _FROM_NOTHING = 2000, 1000  # iterations of DAQP; where no bound is known and they contradict each other
_FREE = 1e-8  # of the largest: how much a row changes within what the equalities leave free, to count as free itself
_SOFT, _SOFTNESS = 8, 1e-7  # DAQP's word for a bound that may be exceeded, and by how much for a unit of multiplier


@dataclass(frozen=True, eq=False)
class ActiveStep:
    """A step and what it rests on.

    Attributes:
        step: (n,) change of the unknowns.
        multipliers: (rows,) of equalities and bounds; positive at an upper bound.
        held: (k,) rows that hold with equality.
        curved: whether H curved downwards where the equalities leave it free, and was turned upwards there.
        independent: which of the equalities stood for all of them; they are the first of those held.
        equalities, rows, root, slopes: what meets those; the other rows held, (b, n) of the Jacobian; L; L⁻¹ (rows Z)ᵀ.
    """

    step: Array
    multipliers: Array
    held: Indices
    curved: bool
    independent: Indices
    equalities: Equalities
    rows: sp.csr_matrix
    root: Array
    slopes: Array

    @cached_property
    def _factor(self) -> tuple[Array, Array, Indices]:
        Q, R, order = la.qr(self.slopes.T, mode="economic", pivoting=True, check_finite=False)
        size = np.abs(np.diag(R))
        rank = int(np.sum(size > _DEPENDENT * size.max(initial=0.0)))
        return Q[:, :rank], R[:rank, :rank], order[:rank]

    def towards(self, gaps: Array) -> Array:
        """Least change (n,) of the unknowns, as H measures it, that moves the held rows by ``gaps`` (k,)."""
        Q, R, order = self._factor
        count = len(self.held) - len(self.slopes)
        fixed = self.equalities.meeting(gaps[:count])
        left = gaps[count:] - self.rows @ fixed
        y = Q @ la.solve_triangular(R, left[order], trans=1, check_finite=False)
        return np.asarray(fixed + self.equalities.null @ _back(self.root, y))


def active_set_step(
    H: Array,
    gradient: Array,
    jacobian: sp.csr_matrix,
    low: Array,
    high: Array,
    guess: Array,
    independent: Indices | None = None,
    nearly: bool = False,
) -> ActiveStep | None:
    """Solve the quadratic program; None where no step keeps its bounds.

    Args:
        H: (n, n) curvature; what curves downwards is turned upwards.
        gradient: (n,) of the objective.
        jacobian: (rows, n); equalities are rows whose ``low`` and ``high`` agree.
        low, high: (rows,) bounds on the change of the rows.
        guess: (rows,) multipliers. A bound with one is thought to be met.
        independent: which of the equalities may stand for all of them, from a step nearby.
        nearly: where bounds contradict each other, they may be exceeded by as little as possible.
    """
    equal = high - low <= 0.0
    same = np.flatnonzero(equal)
    upper, lower = (guess > 0.0) & np.isfinite(high), (guess < 0.0) & np.isfinite(low)
    side = np.where(equal, 0, np.where(upper, 1, np.where(lower, -1, 0))).astype(np.int32)
    if not (np.isfinite(H).all() and np.isfinite(jacobian.data).all()):
        return None
    A, free = Equalities.of(_picked(jacobian, same).toarray(), independent)
    same = same[free]
    fixed, Z = A.meeting(low[same]), A.null
    if not np.isfinite(fixed).all():  # equalities that contradict each other
        return None
    slope, reduced = Z.T @ (gradient + H @ fixed), A.reduced(H)
    L, curved = _root(reduced)
    if curved:  # bounds that will be met lend their curvature, which changes nothing where they are
        met = np.flatnonzero(side)
        goal = np.where(side > 0, high, low)[met] - (chosen := _picked(jacobian, met)) @ fixed
        push = (chosen @ Z).toarray()
        weight = _LENT * np.abs(np.diag(reduced)).max()
        slope, reduced = slope - weight * (push.T @ goal), reduced + weight * (push.T @ push)
        L, curved = _root(reduced)
        if curved:
            L = _turned(reduced)

    best = -la.solve_triangular(L, slope, lower=True, check_finite=False)
    least = fixed + Z @ _back(L, best)
    move = jacobian @ least
    bounded = np.flatnonzero(~equal)
    known = np.zeros(len(low), dtype=bool)
    new = bounded[(side[bounded] != 0) | _beyond(move, low, high)[bounded]]
    work, slopes = np.zeros(0, dtype=np.int64), np.zeros((0, len(best)))
    largest, soft = 0.0, False
    y, lam, step = np.zeros(len(best)), np.zeros(0), least
    for _ in range(_ROUNDS):
        if not len(new):
            break
        known[new] = True
        more = la.solve_triangular(L, (_picked(jacobian, new) @ Z).T.toarray(), lower=True, check_finite=False).T
        size = np.sqrt(np.einsum("ij,ij->i", more, more))
        largest = max(largest, float(size.max()))
        new, more = new[size > _FREE * largest], more[size > _FREE * largest]
        work, slopes = np.concatenate([work, new]), np.vstack([slopes, more])
        above, below = high[work] - move[work], low[work] - move[work]
        sense = np.where(side[work] > 0, 1, np.where(side[work] < 0, 3, 0)).astype(np.int32)
        if not soft:
            y, _, flag, info = _shortest(slopes, above, below, sense, _LIMIT)
            soft = flag <= 0 and bool(nearly or guess.any())
        if soft:  # bounds that depend on each other: nearly all of them are kept, and more of them change nothing
            most = _LIMIT if guess.any() else _FROM_NOTHING
            y, _, flag, info = _shortest(slopes, above, below, sense | _SOFT, most, rho_soft=_SOFTNESS)
        if flag <= 0 or not np.isfinite(y).all():
            return None
        lam = info["lam"]
        side[work] = np.sign(np.where(np.abs(lam) > _TRIFLE * np.abs(lam).max(initial=0.0), lam, 0.0))
        step = least + Z @ _back(L, y)
        new = np.flatnonzero(_beyond(jacobian @ step, low, high) & ~known & ~equal)
    multipliers = np.zeros(len(low))
    multipliers[work] = np.where(side[work] != 0, lam, 0.0)
    left = gradient + H @ step + jacobian.T @ multipliers
    multipliers[same] = -A.multipliers(left)
    if not np.isfinite(step).all():
        return None
    met = side[work] != 0
    held = np.concatenate([same, work[met]])
    return ActiveStep(step, multipliers, held, curved, free, A, _picked(jacobian, work[met]), L, slopes[met])


def _back(L: Array, y: Array) -> Array:
    """The e with Lᵀ e = y."""
    return np.asarray(la.solve_triangular(L, y, trans=1, lower=True, check_finite=False))


def _picked(matrix: sp.csr_matrix, rows: Indices) -> sp.csr_matrix:
    """Some rows of a matrix; SciPy's own choice takes several times as long for few."""
    sizes = np.diff(matrix.indptr)[rows]
    ends = np.append(0, np.cumsum(sizes))
    entries = np.arange(ends[-1]) + np.repeat(matrix.indptr[rows] - ends[:-1], sizes)
    return sp.csr_matrix((matrix.data[entries], matrix.indices[entries], ends), shape=(len(rows), matrix.shape[1]))


def _shortest(
    slopes: Array, above: Array, below: Array, sense: npt.NDArray[np.int32], limit: int, **settings: float
) -> Any:
    """DAQP's answer: the shortest y with below <= slopes @ y <= above."""
    count = slopes.shape[1]
    bounds = slopes, above, below, sense.astype(np.int32)
    return daqp.solve(np.eye(count), np.zeros(count), *bounds, iter_limit=limit, primal_tol=_BEYOND, **settings)


def _beyond(change: Array, low: Array, high: Array) -> npt.NDArray[np.bool_]:
    """Which rows exceed a bound."""
    return np.asarray((change > high + _BEYOND) | (change < low - _BEYOND))


class Equalities:
    """Rows A (k, n) of full rank by Aᵀ = P L U: what meets them, and what they leave free.

    Args:
        rows: A.
    """

    def __init__(self, rows: Array) -> None:
        self._count = len(rows)
        packed, swaps, _ = la.lapack.dgetrf(rows.T)
        self._order = np.arange(rows.shape[1])
        for k, other in enumerate(swaps[: self._count].tolist()):
            self._order[[k, other]] = self._order[[other, k]]
        self._top, self._rest = packed[: self._count], packed[self._count :]

    @classmethod
    def of(cls, rows: Array, guess: Indices | None) -> tuple[Equalities, Indices]:
        """Of rows that may depend on each other; and which of them stand for all, of which there may be a guess."""
        kept = np.arange(len(rows)) if guess is None or guess.max(initial=-1) >= len(rows) else guess
        found = cls(rows[kept])
        others = np.delete(np.arange(len(rows)), kept)
        if found.full and (
            not len(others) or np.abs(sp.csr_matrix(rows[others]) @ found.null).max() < _DEPENDENT * np.abs(rows).max()
        ):
            return found, kept
        R, order = la.qr(rows.T, mode="r", pivoting=True, check_finite=False)
        size = np.abs(np.diag(R))
        kept = np.sort(order[: int(np.sum(size > _DEPENDENT * size.max(initial=0.0)))])
        return cls(rows[kept]), kept

    @property
    def full(self) -> bool:
        """Whether the rows do not depend on each other."""
        size = np.abs(np.diag(self._top))
        return bool(len(size) == self._count and size.min(initial=1.0) > _DEPENDENT * size.max(initial=0.0))

    def _solve(self, right: Array, lower: bool, trans: int) -> Array:
        return np.asarray(la.solve_triangular(self._top, right, trans, lower, unit_diagonal=lower, check_finite=False))

    def meeting(self, values: Array) -> Array:
        """(n,) with A x = values."""
        found = np.zeros(len(self._order))
        found[self._order[: self._count]] = self._solve(self._solve(values, False, 1), True, 1)
        return found

    @cached_property
    def _bound(self) -> sp.csr_matrix:
        """(k, n - k) how the unknowns that are not free follow from those that are, few from each."""
        return sp.csr_matrix(-self._solve(self._rest.T, True, 1))

    @cached_property
    def null(self) -> sp.csr_matrix:
        """Z (n, n - k) with A Z = 0, its columns independent."""
        bound, free = self._bound.tocoo(), len(self._rest)
        rows = np.concatenate([self._order[bound.row], self._order[self._count :]])
        columns, data = np.append(bound.col, np.arange(free)), np.append(bound.data, np.ones(free))
        return sp.csr_matrix((data, (rows, columns)), shape=(len(self._order), free))

    def reduced(self, H: Array) -> Array:
        """Zᵀ H Z of a symmetric H."""
        bound, free = self._order[: self._count], self._order[self._count :]
        turn = self._bound.T.tocsr()
        half = turn @ (0.5 * (turn @ H[np.ix_(bound, bound)]).T + H[np.ix_(bound, free)])
        return np.asarray(H[np.ix_(free, free)] + half + half.T)

    def multipliers(self, pull: Array) -> Array:
        """(k,) with Aᵀ λ = pull, where there is such a one."""
        return self._solve(self._solve(pull[self._order[: self._count]], True, 0), False, 0)


def _root(H: Array) -> tuple[Array, bool]:
    """L with L Lᵀ = H; and whether there is none, as H curves downwards."""
    try:
        return la.cholesky(H, lower=True, check_finite=False), False
    except la.LinAlgError:
        return H, True


def _turned(H: Array) -> Array:
    """L with L Lᵀ = H but where H curves downwards: there it is turned upwards."""
    values, vectors = la.eigh(H, check_finite=False)
    size = np.maximum(np.abs(values), _FLAT * np.abs(values).max())
    return np.asarray(la.cholesky((vectors * size) @ vectors.T, lower=True, check_finite=False))
