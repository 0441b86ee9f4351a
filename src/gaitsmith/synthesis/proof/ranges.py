"""Ranges of Taylor models over their stretches: Bernstein coefficients, halved until the largest value is known."""

from __future__ import annotations

from dataclasses import dataclass
from math import comb

import numpy as np
import numpy.typing as npt

from gaitsmith.synthesis.proof.taylor import DEGREE, Taylor

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]
_GAMMA = 1e-14
_ROUNDS = 44
_MOST = 400_000  # polynomials in one round


def _to_bernstein() -> Array:
    """Matrix from coefficients of σ⁰ … on [-1, 1] to Bernstein coefficients."""
    n = DEGREE
    shift = np.zeros((n + 1, n + 1))  # σ = 2 s - 1
    for k in range(n + 1):
        for j in range(k + 1):
            shift[j, k] = comb(k, j) * 2.0**j * (-1.0) ** (k - j)
    lift = np.array([[comb(i, j) / comb(n, j) if j <= i else 0.0 for j in range(n + 1)] for i in range(n + 1)])
    return np.asarray(lift @ shift)


def _halves() -> tuple[Array, Array]:
    """Matrices from Bernstein coefficients to those of the left and the right half (de Casteljau)."""
    n = DEGREE
    left = np.array([[comb(i, j) / 2.0**i if j <= i else 0.0 for j in range(n + 1)] for i in range(n + 1)])
    return left, left[::-1, ::-1].copy()


_BERNSTEIN, (_LEFT, _RIGHT) = _to_bernstein(), _halves()


def bernstein(models: Taylor) -> tuple[Array, Array]:
    """Lower and upper bounds (..., N) over each stretch, from one set of Bernstein coefficients."""
    b = np.tensordot(_BERNSTEIN, models.c, 1)
    radius = models.r + _GAMMA * np.tensordot(np.abs(_BERNSTEIN), np.abs(models.c), 1).max(axis=0)
    return np.asarray(b.min(axis=0) - radius), np.asarray(b.max(axis=0) + radius)


@dataclass(frozen=True, eq=False)
class Suprema:
    """Of groups of functions.

    Attributes:
        least: (groups,) a value that is reached.
        most: (groups,) what no function exceeds at any time.
        stretch: (groups,) where ``least`` is reached.
        place: (groups,) σ there, -1 to 1.
    """

    least: Array
    most: Array
    stretch: Indices
    place: Array


def suprema(c: Array, r: Array, group: Indices, groups: int, tight: float, proved: float) -> Suprema:
    """Largest values of polynomials with radii.

    Args:
        c: (DEGREE + 1, M, N) coefficients; r: (M, N) radii.
        r: radii.
        group: (M,) group of each function.
        groups: how many there are.
        tight: by how much ``most`` may lie above ``least``, radii aside.
        proved: what has to be decided exactly: halving goes on while ``most`` is above it and ``least`` is not.
    """
    count = c.shape[2]
    with np.errstate(invalid="ignore", over="ignore"):
        b = np.einsum("ij,jmn->mni", _BERNSTEIN, c).reshape(-1, DEGREE + 1)
        sizes = np.einsum("ij,jmn->mni", np.abs(_BERNSTEIN), np.abs(c)).reshape(-1, DEGREE + 1)
        radius = r.reshape(-1) + _GAMMA * sizes.max(axis=1)
    owner, stretch = np.repeat(group, count), np.tile(np.arange(count), len(group))
    low, high = np.full(len(b), -1.0), np.full(len(b), 1.0)
    least, most = np.full(groups, -np.inf), np.full(groups, -np.inf)
    where, place = np.zeros(groups, dtype=np.int64), np.zeros(groups)
    lost = ~np.isfinite(b).all(axis=1) | ~np.isfinite(radius)
    most[owner[lost]] = np.inf
    keep = ~lost
    for turn in range(_ROUNDS + 1):
        b, radius, owner, stretch, low, high = (x[keep] for x in (b, radius, owner, stretch, low, high))
        if len(b) == 0:
            break
        for column, at in ((0, low), (DEGREE, high)):
            value = b[:, column] - radius
            best = np.full(groups, -np.inf)
            np.maximum.at(best, owner, value)
            hit = np.flatnonzero((value == best[owner]) & (value > least[owner]))
            where[owner[hit]], place[owner[hit]], least[owner[hit]] = stretch[hit], at[hit], value[hit]
        upper = b.max(axis=1) + radius
        goal = least[owner] + tight
        goal = np.where((goal > proved) & (least[owner] <= proved), proved, goal)
        open_ = (upper > goal) & (upper - b[:, [0, -1]].max(axis=1) > 2.0 * radius)
        if turn == _ROUNDS or 2 * int(open_.sum()) > _MOST:
            open_[:] = False
        np.maximum.at(most, owner[~open_], upper[~open_])
        b, radius, owner, stretch, low, high = (x[open_] for x in (b, radius, owner, stretch, low, high))
        radius = radius + 4.0 * _GAMMA * np.abs(b).max(axis=1, initial=0.0)
        middle = 0.5 * (low + high)
        b = np.concatenate([b @ _LEFT.T, b @ _RIGHT.T])
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
        radius, owner, stretch = np.tile(radius, 2), np.tile(owner, 2), np.tile(stretch, 2)
        keep = np.ones(len(b), dtype=bool)
    return Suprema(least, most, where, place)
