"""The Lagrangian's Hessian on NumPy arrays: the points' blocks, taken to the splines' unknowns section by section.

A joint's inputs q, q̇, q̈ depend on its own control points only, all joints in the same way, so that BᵀHB is a small
product with the (3, w) basis of a point in place of one with B.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from gaitsmith.synthesis.program.program import OBJECTIVE_SCALE, Program

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]


class Curvature:
    """Hessians of one program; the objective is scaled by ``OBJECTIVE_SCALE``.

    Args:
        program: the program, its inputs mapped as :meth:`Transcription.input_map` does.
    """

    def __init__(self, program: Program) -> None:
        self.program = program
        layout, points = program.functions.layout, program.points.count
        n = layout.joints
        self._weight = program.points.weight * OBJECTIVE_SCALE
        lengths = np.diff(program.inputs.indptr).reshape(points, layout.inputs)
        starts = program.inputs.indptr[:-1].reshape(points, layout.inputs)
        width = int(lengths[0, 0])
        entry = starts[:, : 3 * n].reshape(points, 3, n, 1) + np.arange(width)
        data = program.inputs.data[entry]
        self._columns: Indices = program.inputs.indices[entry[:, 0]].astype(np.int64)  # (K, n, w)
        self._basis = data[:, :, 0, :]  # (K, 3, w), of the first joint
        largest = np.abs(self._basis[:, 0]).argmax(axis=1)
        value = np.take_along_axis(data[:, 0], largest[:, None, None], axis=2)[:, :, 0]
        self._sign = np.sign(value * value[:, :1])  # (K, n), relative to the first joint
        self._loaded = np.flatnonzero(lengths[:, layout.wrench] > 0)
        if len(self._loaded):
            degree = int(lengths[self._loaded[0], layout.wrench])
            entry = starts[self._loaded, layout.wrench :, None] + np.arange(degree)
            self._wrench = program.inputs.data[entry[:, 0]]  # (L, 4), of every row
            self._wrench_columns: Indices = program.inputs.indices[entry].astype(np.int64)  # (L, 6, 4)
        # Points of one section share their columns: their blocks are added before they are scattered.
        _, first, group = np.unique(self._columns[:, 0, 0], return_index=True, return_inverse=True)
        self._first, self._member = first, np.zeros((len(first), points))
        self._member[group, np.arange(points)] = 1.0
        members = self._member[:, self._loaded]
        self._loads = members[members.any(axis=1)]
        self._begins = self._loads.argmax(axis=1)

    def exact(self, x: Array, multipliers: Array) -> sp.coo_matrix:
        """(n, n) Hessian of the Lagrangian; entries that occur twice are to be added."""
        layout = self.program.functions.layout
        z, o = self.program.evaluate(x)
        on_outputs = np.asarray(self.program.outputs.T @ multipliers).reshape(-1, layout.outputs)
        on_outputs[:, : layout.joints] += 2.0 * self._weight[:, None] * o[: layout.joints].T
        return self._assembled(z, on_outputs)

    def convex(self, x: Array) -> sp.coo_matrix:
        """(n, n) the objective's Hessian without the curvature of the torques: never negative."""
        layout = self.program.functions.layout
        z = (self.program.inputs @ x).reshape(-1, layout.inputs).T
        return self._assembled(z, np.zeros((z.shape[1], layout.outputs)))

    def _assembled(self, z: Array, on_outputs: Array) -> sp.coo_matrix:
        program, layout = self.program, self.program.functions.layout
        points, n, width = z.shape[1], layout.joints, self._basis.shape[2]
        H = program.functions.curvature(z, program.pivots, on_outputs, self._weight)
        up = self._basis.transpose(0, 2, 1)  # (K, w, 3)
        joint = H[:, : 3 * n, : 3 * n].reshape(points, 3, n, 3, n)
        joint = joint * self._sign[:, None, :, None, None] * self._sign[:, None, None, None, :]
        half = (up @ joint.reshape(points, 3, -1)).reshape(points, width, n, 3, n)
        full = up @ half.transpose(0, 3, 1, 2, 4).reshape(points, 3, -1)  # (K, w', w * n * n)
        summed = (self._member @ full.reshape(points, -1)).reshape(-1, width, width, n, n)
        columns = self._columns[self._first].transpose(0, 2, 1)  # (S, w, n)
        row = np.broadcast_to(columns[:, None, :, :, None], summed.shape)
        column = np.broadcast_to(columns[:, :, None, None, :], summed.shape)
        parts = [(summed.ravel(), row.ravel(), column.ravel())]
        if len(self._loaded):
            parts += self._wrench_parts(H[self._loaded], up[self._loaded])
        values, rows, cols = (np.concatenate(part) for part in zip(*parts, strict=True))
        return sp.coo_matrix((values, (rows, cols)), shape=(program.size, program.size))

    def _wrench_parts(self, H: Array, up: Array) -> list[tuple[Array, Indices, Indices]]:
        """Entries between joints and u, and of u with itself, for the points (L,) at which both feet carry load."""
        program, layout = self.program, self.program.functions.layout
        n, first, width = layout.joints, layout.wrench, up.shape[1]
        count = len(self._loaded)
        mixed = H[:, : 3 * n, first:].reshape(count, 3, -1)
        mixed = (up @ mixed).reshape(count, width, n, 6) * self._sign[self._loaded][:, None, :, None]
        mixed = self._summed(mixed[..., None] * self._wrench[:, None, None, None, :])  # (S, w, n, 6, 4)
        joint_columns = self._columns[self._loaded[self._begins]].transpose(0, 2, 1)[:, :, :, None, None]
        wrench_columns = self._wrench_columns[self._begins]
        row = np.broadcast_to(joint_columns, mixed.shape).ravel()
        column = np.broadcast_to(wrench_columns[:, None, None], mixed.shape).ravel()
        own = H[:, first:, first:] + 2.0 * program.wrench_weight * self._weight[self._loaded, None, None] * np.eye(6)
        both = own[:, :, None, :, None] * self._wrench[:, None, :, None, None] * self._wrench[:, None, None, None, :]
        both = self._summed(both)
        down = np.broadcast_to(wrench_columns[:, :, :, None, None], both.shape).ravel()
        across = np.broadcast_to(wrench_columns[:, None, None], both.shape).ravel()
        flat = mixed.ravel()
        return [(flat, row, column), (flat, column, row), (both.ravel(), down, across)]

    def _summed(self, blocks: Array) -> Array:
        """Blocks (L, ...) of the points with load, added section by section (S, ...)."""
        return np.asarray((self._loads @ blocks.reshape(len(blocks), -1)).reshape(-1, *blocks.shape[1:]))
