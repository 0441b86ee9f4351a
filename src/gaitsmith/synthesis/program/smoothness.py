"""Torque rates at the collocation points, as linear maps from the torques of a section's points."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from gaitsmith.splines.joint_spline import quadrature
from gaitsmith.synthesis.program.transcription import Points, Transcription

Array = npt.NDArray[np.float64]


def differentiation(nodes: Array) -> Array:
    """(n, n) from a polynomial's values at nodes to its derivative there, by barycentric weights."""
    gaps = nodes[:, None] - nodes[None]
    np.fill_diagonal(gaps, 1.0)
    weights = 1.0 / gaps.prod(axis=1)
    found = weights[None] / weights[:, None] / gaps
    np.fill_diagonal(found, 0.0)
    np.fill_diagonal(found, -found.sum(axis=1))
    return np.asarray(found)


def torque_rates(trans: Transcription, points: Points) -> sp.csr_matrix:
    """S (joints * nodes, K * outputs): ‖S vec(O)‖² is the integral of τ̇ᵀτ̇, in (N·m)²/s.

    The torques of a section are the polynomial through its Gauss-Lobatto points; the quadrature is exact for it.
    """
    layout, n = trans.layout, trans.biped.joints
    where = points.places()
    data, rows, columns, row = [], [], [], 0
    for section, phase in enumerate(trans.phase_of_section):
        nodes, weights = quadrature(trans.nodes_in(phase))
        span = float(np.diff(trans.spline.knots[section : section + 2])[0])
        block = np.sqrt(span * weights)[:, None] * differentiation(nodes) / span
        place = np.array([where[phase, round(float(t), 9)] for t in trans.nodes(phase, section)])
        count = len(nodes)
        for joint in range(n):
            data.append(block.ravel())
            rows.append(row + np.repeat(np.arange(count), count))
            columns.append(np.tile(place * layout.outputs + layout.torque + joint, count))
            row += count
    shape = (row, points.count * layout.outputs)
    return sp.csr_matrix((np.concatenate(data), (np.concatenate(rows), np.concatenate(columns))), shape=shape)
