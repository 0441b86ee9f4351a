"""Polynomials on a section: powers, Bernstein form, quintic Hermite pieces, Chebyshev series, Gauss-Lobatto points.

A section's time is normalised: s runs from 0 to 1.
"""

from __future__ import annotations

from math import comb, perm

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
_HERMITE = np.array(
    [
        [1, 0, 0, -10, 15, -6],
        [0, 1, 0, -6, 8, -3],
        [0, 0, 0.5, -1.5, 1.5, -0.5],
        [0, 0, 0, 10, -15, 6],
        [0, 0, 0, -4, 7, -3],
        [0, 0, 0, 0.5, -1, 0.5],
    ],
    dtype=np.float64,
)


def power_basis(degree: int, t: npt.ArrayLike, derivative: int = 0) -> Array:
    """(degree + 1, ...) powers of ``t`` from t⁰ on, or their derivatives with respect to it."""
    at = np.asarray(t, dtype=np.float64)
    found, power = np.zeros((degree + 1, *at.shape)), np.ones_like(at)
    for k in range(derivative, degree + 1):
        found[k] = perm(k, derivative) * power
        power = power * at
    return found


def polynomial(coefficients: Array, s: Array, span: float) -> Array:
    """(3, n, N) values and two derivatives in time of polynomials in powers of s: eq. (17) of the second paper.

    Args:
        coefficients: (n, degree + 1) of 1, s, s² ...
        s: (N,) from 0 to 1 over the section.
        span: the section's duration, s.
    """
    degree = coefficients.shape[1] - 1
    return np.array([coefficients @ power_basis(degree, s, k) / span**k for k in range(3)])


def bernstein(degree: int, s: float, derivative: int = 0) -> Array:
    """Bernstein polynomials (degree + 1) or their derivatives with respect to ``s`` in [0, 1]."""
    return np.array(_bernstein(degree, float(s), derivative))


def _bernstein(degree: int, s: float, derivative: int) -> list[float]:
    if derivative > degree:
        return [0.0] * (degree + 1)
    if derivative:
        lower = _bernstein(degree - 1, s, derivative - 1)
        return [degree * (one - two) for one, two in zip([0.0, *lower], [*lower, 0.0], strict=True)]
    return [comb(degree, k) * s**k * (1.0 - s) ** (degree - k) for k in range(degree + 1)]


def bernstein_to_power(degree: int) -> Array:
    """Matrix from Bernstein coefficients to those of 1, s, s² ..."""
    matrix = np.zeros((degree + 1, degree + 1))
    for k in range(degree + 1):
        for j in range(k, degree + 1):
            matrix[j, k] = comb(degree, k) * comb(degree - k, j - k) * (-1.0) ** (j - k)
    return matrix


def hermite(span: float, left: Array, right: Array) -> Array:
    """(n, 6) power coefficients of the quintics between two states (3, n), derivatives with respect to time."""
    factors = np.array([1.0, span, span**2])[:, None]
    return np.asarray(np.concatenate([left * factors, right * factors]).T @ _HERMITE)


def chebyshev_fit(count: int) -> tuple[Array, Array]:
    """Nodes s (count,), and the matrix from values (..., count) there to Chebyshev coefficients (..., count)."""
    nodes = np.cos(np.pi * (np.arange(count) + 0.5) / count)
    matrix = np.polynomial.chebyshev.chebvander(nodes, count - 1) * (2.0 / count)
    matrix[:, 0] /= 2.0
    return (nodes + 1.0) / 2.0, np.asarray(matrix, dtype=np.float64)


def chebyshev_slopes(to_series: Array, at: Array) -> Array:
    """(count, N) from values at the nodes of :func:`chebyshev_fit` to their series' slopes at ``at``, from -1 to 1."""
    count = to_series.shape[1]
    slopes = np.polynomial.chebyshev.chebder(np.eye(count))
    return np.asarray(to_series @ slopes.T @ np.polynomial.chebyshev.chebvander(at, count - 2).T)


def chebyshev(coefficients: Array, s: npt.ArrayLike) -> Array:
    """(n, ...) values of Chebyshev series (n, m) at normalised times."""
    return np.asarray(np.polynomial.chebyshev.chebval(2.0 * np.asarray(s) - 1.0, coefficients.T))


def lobatto(count: int) -> tuple[Array, Array]:
    """Gauss-Lobatto nodes in [0, 1] and weights that sum to 1."""
    if count < 2:
        raise ValueError(f"{count} Lobatto nodes: at least 2")
    legendre = np.polynomial.legendre.Legendre.basis(count - 1)
    nodes = np.concatenate([[-1.0], np.sort(legendre.deriv().roots().real), [1.0]])
    weights = 2.0 / (count * (count - 1) * legendre(nodes) ** 2)
    return (nodes + 1.0) / 2.0, weights / 2.0
