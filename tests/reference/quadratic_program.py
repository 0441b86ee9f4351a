"""Convex quadratic programs by DAQP, in well-scaled variables."""

from __future__ import annotations

import daqp
import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

_FAR = 1e30  # what DAQP takes for infinity
_OPTIMAL = 1


def minimise(hessian: Array, gradient: Array, low: Array, high: Array, rows: Array, row_low: Array) -> Array:
    """Minimiser of ½ xᵀH x + gᵀx subject to low ≤ x ≤ high and row_low ≤ A x.

    Raises:
        ArithmeticError: DAQP found no solution.
    """
    unit = 1.0 / np.sqrt(np.diag(hessian))
    scaled_rows = rows * unit
    length = np.linalg.norm(scaled_rows, axis=1)
    below = np.concatenate([low / unit, row_low / length])
    above = np.concatenate([high / unit, np.full(len(rows), _FAR)])
    solution, _, status, _ = daqp.solve(
        hessian * np.outer(unit, unit),
        gradient * unit,
        np.ascontiguousarray(scaled_rows / length[:, None]),
        np.minimum(above, _FAR),
        np.maximum(below, -_FAR),
        np.zeros(len(below), dtype=np.int32),
        primal_tol=1e-12,
        dual_tol=1e-12,
    )
    if status != _OPTIMAL:
        raise ArithmeticError(f"DAQP stopped with {status}")
    return unit * solution
