"""The joint splines of eqs. (17) and (18) of the second paper, as linear maps from their control points."""

from __future__ import annotations

from functools import cache

import numpy as np
import numpy.typing as npt

from gaitsmith.splines.polynomial import bernstein, lobatto

Array = npt.NDArray[np.float64]


@cache
def quadrature(count: int) -> tuple[Array, Array]:
    """Gauss-Lobatto nodes in [0, 1] and weights that sum to 1, found once; they cannot be written to."""
    found = lobatto(count)
    for values in found:
        values.flags.writeable = False
    return found


class JointSpline:
    """Polynomials of one degree over consecutive sections, joined with continuous position, velocity, acceleration.

    The free numbers are B-spline control points; ``sections[k]`` maps those that matter to the section's Bernstein
    coefficients. A curve's values at ``places``, s (Greville's), make a spline near it.

    Args:
        knots: (N + 1,) section borders, s, increasing.
        degree: 4 as in the paper, or 5.
    """

    def __init__(self, knots: Array, degree: int) -> None:
        self.knots = np.asarray(knots, dtype=np.float64)
        self.degree = degree
        self.new = degree - 2  # control points that a section adds at C²
        count = len(self.knots) - 1
        self.size = degree + 1 + self.new * (count - 1)
        padded = _padded(self.knots, degree)
        self.sections = _bezier_maps(self.knots, padded, degree)
        self.places = np.array([padded[k + 1 : k + degree + 1].mean() for k in range(self.size)])
        self._rows: dict[tuple[int, float, int], Array] = {}

    def first(self, section: int) -> int:
        """Index of the first control point that a section depends on."""
        return section * self.new

    def row(self, section: int, t: float, derivative: int = 0) -> Array:
        """Weights (degree + 1) of the control points from ``first(section)`` on, for a value or a derivative; kept."""
        kept = self._rows.get((section, t, derivative))
        if kept is not None:
            return kept
        span = self.knots[section + 1] - self.knots[section]
        s = (t - self.knots[section]) / span
        row = np.asarray(bernstein(self.degree, s, derivative) @ self.sections[section] / span**derivative)
        row.flags.writeable = False
        self._rows[section, t, derivative] = row
        return row


def _padded(knots: Array, degree: int) -> Array:
    """All knots of the B-splines: the ends degree + 1 times, those inside degree - 2 times."""
    return np.concatenate([[knots[0]] * (degree + 1), np.repeat(knots[1:-1], degree - 2), [knots[-1]] * (degree + 1)])


def _bezier_maps(knots: Array, padded: Array, degree: int) -> list[Array]:
    """Per section, the matrix (degree + 1, degree + 1) from B-spline control points to Bernstein coefficients.

    Blossoming: a Bernstein coefficient is the spline's blossom at the section's two ends, each repeated.
    """
    multiplicity, maps = degree - 2, []
    for section in range(len(knots) - 1):
        start = degree + section * multiplicity
        a, b = knots[section], knots[section + 1]
        matrix = np.zeros((degree + 1, degree + 1))
        for k in range(degree + 1):
            arguments = [a] * (degree - k) + [b] * k
            table = np.eye(degree + 1)
            for level in range(1, degree + 1):
                x = arguments[level - 1]
                for j in range(degree, level - 1, -1):
                    left, right = padded[start - degree + j], padded[start + 1 + j - level]
                    w = (x - left) / (right - left)
                    table[j] = (1.0 - w) * table[j - 1] + w * table[j]
            matrix[k] = table[degree]
        maps.append(matrix)
    return maps
