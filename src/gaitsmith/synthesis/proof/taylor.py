"""Taylor models: polynomials of time with a radius that encloses everything left out, rounding included.

A model stands for all functions f on s in [-1, 1] with |f(s) - Σ c_k s^k| <= r. Every operation hands back a model that
holds for all functions that its operands stand for. Additions and products of floating-point numbers are exact to half
a unit in the last place (IEEE 754), which is all that the radii rely on; no library's sine is.
"""

from __future__ import annotations

from math import factorial
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
DEGREE = 8
_GAMMA = 1e-14  # 90 units in the last place: more than the additions in any sum of products below
_SPARE = 1.0 + 1e-12  # radii are computed with rounding too
_SINE = 1e-12  # of _start: 16 terms and three doublings lose less
_TERMS = 6  # of the series in the moving part of an angle
_TURNS = 10.0  # rad: larger angles are not enclosed


class Taylor:
    """An array of Taylor models over N stretches of time.

    Args:
        coefficients: (DEGREE + 1, ..., N).
        radius: (..., N).
    """

    __array_ufunc__ = None  # a NumPy array on the left leaves the operation to this class

    def __init__(self, coefficients: Array, radius: Array) -> None:
        self.c, self.r = coefficients, radius

    @classmethod
    def constant(cls, values: Array, count: int) -> Taylor:
        """Exact numbers (...) in all N stretches."""
        c = np.zeros((DEGREE + 1, *np.shape(values), count))
        c[0] = np.asarray(values)[..., None]
        return cls(c, np.zeros(c.shape[1:]))

    @property
    def shape(self) -> tuple[int, ...]:
        """Of the array, N last."""
        return tuple(self.r.shape)

    @property
    def size(self) -> Array:
        """(..., N) upper bounds of |f|."""
        return np.asarray((np.abs(self.c).sum(axis=0) + self.r) * _SPARE)

    def __getitem__(self, key: Any) -> Taylor:
        """Entries by their place; the stretches stay."""
        whole = key if isinstance(key, tuple) else (key,)
        return Taylor(self.c[(slice(None), *whole)], self.r[whole])

    def __neg__(self) -> Taylor:
        return Taylor(-self.c, self.r)

    def __add__(self, other: Taylor | float | Array) -> Taylor:
        if not isinstance(other, Taylor):
            c = np.broadcast_to(self.c, (DEGREE + 1, *np.broadcast_shapes(self.shape, np.shape(other)))).copy()
            c[0] += other
            return Taylor(c, (self.r + _GAMMA * np.abs(c[0])) * _SPARE)
        one, two = _level(self, other)
        c = one.c + two.c
        return Taylor(c, (one.r + two.r + _GAMMA * np.abs(c).sum(axis=0)) * _SPARE)

    __radd__ = __add__

    def __sub__(self, other: Taylor | float | Array) -> Taylor:
        return self + (-other)

    def __rsub__(self, other: float | Array) -> Taylor:
        return (-self) + other

    def __mul__(self, other: Taylor | float | Array) -> Taylor:
        """Product, entry by entry; a number (or one of each of the N stretches) is exact."""
        if not isinstance(other, Taylor):
            c = self.c * other
            return Taylor(c, (self.r * np.abs(other) + _GAMMA * np.abs(c).sum(axis=0)) * _SPARE)
        one, two = _aligned(self, other)
        shape = np.broadcast_shapes(one.shape, two.shape)
        c, left = np.zeros((DEGREE + 1, *shape)), np.zeros(shape)
        sizes, others = np.abs(one.c), np.abs(two.c)
        tails = np.cumsum(others[::-1], axis=0)[::-1]
        for k in range(DEGREE + 1):
            if not one.c[k].any():
                continue
            c[k:] += one.c[k] * two.c[: DEGREE + 1 - k]
            if k:
                left += sizes[k] * tails[DEGREE + 1 - k]
        all_one, all_two = sizes.sum(axis=0), tails[0]
        rounding = _GAMMA * all_one * all_two
        r = left + all_one * two.r + one.r * all_two + one.r * two.r + rounding
        return Taylor(c, r * _SPARE + np.finfo(float).tiny)

    __rmul__ = __mul__

    def sum(self, axis: int) -> Taylor:
        """Sum over an axis of the array, at most 40 long."""
        sizes = np.abs(self.c).sum(axis=0).sum(axis=axis)
        return Taylor(self.c.sum(axis=axis + 1), (self.r.sum(axis=axis) + _GAMMA * sizes) * _SPARE)

    def by(self, matrix: Array) -> Taylor:
        """This matrix (i, j) times exact numbers (j, k) or (j,)."""
        table = np.asarray(matrix, dtype=np.float64)
        letters = "zijn,jk->zikn" if table.ndim == 2 else "zijn,j->zin"
        c = np.einsum(letters, self.c, table)
        sizes = np.einsum(letters[1:].replace(">z", ">"), np.abs(self.c).sum(axis=0), np.abs(table))
        r = np.einsum(letters[1:].replace(">z", ">"), self.r, np.abs(table))
        return Taylor(c, (r + _GAMMA * sizes) * _SPARE)

    def transposed(self) -> Taylor:
        """Of a matrix (i, j)."""
        return Taylor(self.c.swapaxes(1, 2), self.r.swapaxes(0, 1))


def _level(one: Taylor, two: Taylor) -> tuple[Taylor, Taylor]:
    """Both with equally many axes, as NumPy aligns arrays."""
    axes = max(len(one.shape), len(two.shape))
    return tuple(  # type: ignore[return-value]
        item[(None,) * (axes - len(item.shape))] if len(item.shape) < axes else item for item in (one, two)
    )


def _aligned(one: Taylor, two: Taylor) -> tuple[Taylor, Taylor]:
    """The operand with fewer powers first: its absent ones cost nothing."""
    one, two = _level(one, two)
    used = [sum(bool(row.any()) for row in item.c) for item in (one, two)]
    return (one, two) if used[0] <= used[1] else (two, one)


def stacked(rows: list[Taylor]) -> Taylor:
    """Models as a new first axis."""
    return Taylor(np.stack([item.c for item in rows], axis=1), np.stack([item.r for item in rows]))


def matmul(one: Taylor, two: Taylor) -> Taylor:
    """Matrix (i, j) times matrix (j, k) or vector (j,)."""
    if len(two.shape) == 2:
        return (one * two[None]).sum(1)
    return (one[:, :, None] * two[None]).sum(1)


def cross(one: Taylor, two: Taylor) -> Taylor:
    """Of vectors (3, ...), along the first axis."""
    ahead, after = [1, 2, 0], [2, 0, 1]
    return one[ahead] * two[after] - one[after] * two[ahead]


def sine_cosine(angle: Taylor) -> tuple[Taylor, Taylor]:
    """Sine and cosine of angles (..., N); of angles beyond 10 rad nothing is known."""
    start = angle.c[0]
    moving = Taylor(np.concatenate([np.zeros_like(angle.c[:1]), angle.c[1:]]), angle.r)
    square = moving * moving
    size = moving.size
    even, odd = square * (1.0 / factorial(2 * _TERMS)) * 0.0, square * 0.0
    for k in range(_TERMS, -1, -1):
        even = even * square + (-1.0) ** k / factorial(2 * k)
        odd = odd * square + (-1.0) ** k / factorial(2 * k + 1)
    odd = odd * moving
    small = size < 1.0
    rest = np.minimum(size, 1.0) ** (2 * _TERMS + 2) / factorial(2 * _TERMS + 2) * 1.01
    # Where the series does not hold, what is known of any sine: it lies between -1 and 1.
    even, odd = (Taylor(np.where(small, x.c, 0.0), np.where(small, x.r + rest, 1.0)) for x in (even, odd))
    known = np.abs(start) <= _TURNS
    s, c = (np.where(known, x, 0.0) for x in _start(np.where(known, start, 0.0)))
    error = np.where(known, _SINE, 1.0)
    s0, c0 = (Taylor(np.concatenate([v[None], np.zeros_like(angle.c[1:])]), error) for v in (s, c))
    return s0 * even + c0 * odd, c0 * even - s0 * odd


def _start(angle: Array) -> tuple[Array, Array]:
    """Sine and cosine of numbers up to 10 to 1e-12: their series at an eighth, doubled three times."""
    x = angle / 8.0
    square = x * x
    s, c = np.zeros_like(x), np.zeros_like(x)
    for k in range(15, -1, -1):
        c = c * square + (-1.0) ** k / factorial(2 * k)
        s = s * square + (-1.0) ** k / factorial(2 * k + 1)
    s = s * x
    for _ in range(3):
        s, c = 2.0 * s * c, 1.0 - 2.0 * s * s
    return s, c
