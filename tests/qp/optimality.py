"""How far a solution is from optimal, measured without the solver."""

from __future__ import annotations

import numpy as np

from gaitsmith.qp.quadratic_program import QuadraticProgram


def residual(qp: QuadraticProgram) -> float:
    """Largest violation of the optimality conditions by ``solution`` and ``multipliers``, relative.

    Variable i is measured in 1/√H_ii and constraint k by the norm of its normal in those units; the result is
    divided by the largest scaled entry of solution and gradient, so 1e-10 means ten correct digits. Covers limits,
    stationarity, and sign and complementarity of the multipliers.
    """
    (n, m), base = qp.size, len(qp.gradient)
    used = np.r_[:n, base : base + m]
    hessian, g, x, rows = qp.hessian[:n, :n].copy(), qp.gradient[:n], qp.solution[:n], qp.rows[:m, :n].copy()
    scale = np.sqrt(np.diag(hessian))
    norms = np.linalg.norm(rows / scale, axis=1)
    metric = np.concatenate([scale, 1.0 / np.where(norms > 0.0, norms, 1.0)])
    low, high = (np.concatenate([a[:n], b[:m]]) for a, b in ((qp.lower, qp.row_lower), (qp.upper, qp.row_upper)))
    y, value = qp.multipliers[used], np.concatenate([x, rows @ x])
    slope = np.abs(hessian @ x + g - y[:n] - rows.T @ y[n:]) / scale
    force, below, above = y / metric, (value - low) * metric, (high - value) * metric
    unit = max(1e-300, np.abs(g / scale).max(), np.abs(x * scale).max())
    sides = (np.minimum(np.maximum(force, 0.0), np.abs(below)), np.minimum(np.maximum(-force, 0.0), np.abs(above)))
    return float(max(0.0, slope.max(), -below.min(), -above.min(), *(side.max() for side in sides)) / unit)
