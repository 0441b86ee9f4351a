"""A program's derivatives as SciPy's matrices, at once: for the few steps from a warm start.

CasADi's functions of a whole program (:mod:`gaitsmith.synthesis.program.assembly`) are faster to call and take
longer to make.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from gaitsmith.synthesis.point.functions import PointFunctions
from gaitsmith.synthesis.program.program import Program

Array = npt.NDArray[np.float64]


class _Blocks:
    """Equal blocks along the diagonal, from the nonzeros of every point.

    Args:
        functions: of a point.
        kind: of function whose last output the blocks are.
        count: of points.
    """

    def __init__(self, functions: PointFunctions, kind: str, count: int) -> None:
        pattern = functions.pattern(kind)
        rows, columns = (np.array(places) for places in pattern.get_triplet())
        self._order = np.lexsort((columns, rows))
        height, width = pattern.size1(), pattern.size2()
        ends = np.cumsum(np.bincount(rows, minlength=height))
        points = np.arange(count)[:, None]
        self._columns = (columns[self._order] + width * points).ravel()
        self._starts = np.concatenate([[0], (ends + len(rows) * points).ravel()])
        self._shape = height * count, width * count

    def matrix(self, values: Array) -> sp.csr_matrix:
        """The matrix for nonzeros (K, nonzeros), column by column of each block."""
        return sp.csr_matrix((values[:, self._order].ravel(), self._columns, self._starts), shape=self._shape)


class Derivatives:
    """Gradient, rows, Jacobian and Hessian of a program; the objective is scaled.

    Args:
        program: the program.
    """

    def __init__(self, program: Program) -> None:
        self.program = program
        functions, count = program.functions, program.points.count
        self._slopes, self._curves = (_Blocks(functions, kind, count) for kind in ("jacobian", "hessian"))
        weight = program.points.weight * program.scale
        self._torque = np.zeros((count, functions.layout.outputs))
        self._torque[:, : functions.layout.joints] = 2.0 * weight[:, None] * float(program.torque_weight.min())
        self._weight = weight * float(program.torque_weight.min())
        self._effort = 2.0 * np.outer(weight, program.effort).ravel()
        self._back = sp.csr_matrix(program.inputs.T)
        self._constant = self._back @ sp.diags(self._effort) @ program.inputs
        self._x = np.full(program.size, np.nan)

    def first_order(self, x: Array) -> tuple[Array, Array, sp.csr_matrix]:
        """Gradient of the objective (n,), rows (rows,) and the rows' Jacobian (rows, n)."""
        self._see(x)
        program, o = self.program, self._o.ravel()
        gradient = self._moved.T @ self._on_outputs() + self._back @ (self._effort * self._z.ravel()) + program.price
        rows = program.outputs @ o + program.linear @ x
        return gradient, rows, sp.csr_matrix(program.outputs @ self._moved + program.linear)

    def evaluate(self, x: Array) -> tuple[Array, Array]:
        """As :meth:`Program.evaluate`."""
        self._see(x)
        return self._z.T, self._o.T

    def curvature(self, x: Array, share: float, multipliers: Array | float, ridge: float) -> sp.csc_matrix:
        """The Hessian (n, n) with a share of the torques' curvature, and a ridge.

        Without both, the share and the multipliers, it is never negative.
        """
        self._see(x)
        program = self.program
        on = share * self._on_outputs() + program.outputs.T @ np.broadcast_to(multipliers, program.rows)
        values = self._called("hessian", on.reshape(self._o.shape).T, self._weight[None])[0]
        rates = program.smooth @ self._moved
        found = self._back @ (self._curves.matrix(values) @ program.inputs) + self._constant
        found = found + 2.0 * program.scale * (rates.T @ rates)
        return sp.csc_matrix(found + ridge * sp.eye_array(program.size))

    def _see(self, x: Array) -> None:
        """Inputs, outputs and their slopes by the unknowns, unless they are there."""
        if np.array_equal(x, self._x):
            return
        self._x = x.copy()
        self._z = (self.program.inputs @ x).reshape(self.program.points.count, -1)
        self._o, values = self._called("jacobian")
        self._moved = sp.csr_matrix(self._slopes.matrix(values) @ self.program.inputs)

    def _on_outputs(self) -> Array:
        """D objective / d outputs, point by point."""
        program, o = self.program, self._o.ravel()
        rates = program.smooth.T @ (program.smooth @ o)
        return np.asarray(self._torque.ravel() * o + 2.0 * program.scale * rates)

    def _called(self, kind: str, *more: Array) -> list[Array]:
        """A function's outputs at all points, (K, nonzeros) each."""
        program, found, first = self.program, [], 0
        for side, count in enumerate(program.groups):
            if count:
                part = slice(first, first + count)
                given = [a[:, part].T.ravel() for a in (self._z.T, program.pivots, *more)]
                found.append([a.reshape(count, -1).copy() for a in program.functions.called(kind, count, side, given)])
            first += count
        return [np.vstack(parts) for parts in zip(*found, strict=True)]
