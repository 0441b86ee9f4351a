"""A program's derivatives at once, from small dense blocks of every point.

CasADi's functions of a whole program (:mod:`gaitsmith.synthesis.program.assembly`) take longer to make.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from gaitsmith.synthesis.program.program import Program

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class _RateGroup:
    """Rows of torque rates: ``matrix`` (r, o) of the outputs ``outs`` (o,) of all points.

    These depend on ``unknowns`` (U,), each by its point's at ``slots`` (o, W).
    """

    matrix: Array
    outs: Indices
    unknowns: Indices
    slots: Indices


class Derivatives:
    """Gradient, rows, Jacobian and Hessian of a program; the objective is scaled.

    A point depends on few unknowns: its maps are kept as small dense blocks, padded to the same width W.

    Args:
        program: the program.
    """

    def __init__(self, program: Program) -> None:
        self.program = program
        functions, count, size = program.functions, program.points.count, program.size
        layout = functions.layout
        self._places = {kind: functions.pattern(kind).get_triplet() for kind in ("jacobian", "hessian")}
        weight = program.points.weight * program.scale
        self._torque = np.zeros((count, layout.outputs))
        self._torque[:, : layout.joints] = 2.0 * weight[:, None] * float(program.torque_weight.min())
        self._weight = weight * float(program.torque_weight.min())
        self._effort = 2.0 * np.outer(weight, program.effort)
        self._local = self._blocks(program.inputs.tocoo())
        width = self._local.shape[2]
        # Padded columns meet zeros: they go to the last unknown.
        ends = np.arange(count * layout.outputs + 1) * width
        columns = np.repeat(np.minimum(self._columns, size - 1), layout.outputs, axis=0).ravel()
        self._moved = sp.csr_matrix((np.zeros(len(columns)), columns, ends), shape=(count * layout.outputs, size))
        order = np.argsort(program.points.section, kind="stable")
        borders = np.flatnonzero(np.diff(program.points.section[order])) + 1
        self._sections = np.split(order, borders)  # points of a section depend on the same unknowns
        self._groups = self._rate_groups()
        self._x = np.full(size, np.nan)

    def _rate_groups(self) -> list[_RateGroup]:
        """The rows of the torque rates, those that the same points take part in together."""
        smooth, outputs = self.program.smooth, self.program.functions.layout.outputs
        if not smooth.nnz:
            return []
        point, sizes = smooth.indices // outputs, np.diff(smooth.indptr)
        used = np.flatnonzero(sizes)
        starts = smooth.indptr[used]
        ends = np.minimum.reduceat(point, starts), np.maximum.reduceat(point, starts)
        pairs, group = np.unique(ends[0] * self.program.points.count + ends[1], return_inverse=True)
        own, found = np.repeat(group, sizes[used]), []
        for k in range(len(pairs)):
            entries, count = np.flatnonzero(own == k), sizes[used[group == k]]
            outs, columns = np.unique(smooth.indices[entries], return_inverse=True)
            matrix = np.zeros((len(count), len(outs)))
            matrix[np.repeat(np.arange(len(count)), count), columns] = smooth.data[entries]
            points, place = np.unique(outs // outputs, return_inverse=True)
            unknowns = np.unique(self._columns[points])
            slots = np.searchsorted(unknowns, self._columns[points])
            found.append(_RateGroup(matrix, outs, unknowns, slots[place]))
        return found

    def _blocks(self, inputs: sp.coo_matrix) -> Array:
        """(K, inputs, W) of the map to the points' inputs; ``_columns`` (K, W): unknowns, ``size`` where none."""
        count, size = self.program.points.count, self.program.size
        height = self.program.functions.layout.inputs
        point = inputs.row // height
        pairs, where = np.unique(point * size + inputs.col, return_inverse=True)
        starts = np.searchsorted(pairs, np.arange(count) * size)
        slot = np.arange(len(pairs)) - starts[pairs // size]
        self._columns = np.full((count, int(slot.max()) + 1), size)
        self._columns[pairs // size, slot] = pairs % size
        found = np.zeros((count, height, self._columns.shape[1]))
        np.add.at(found, (point, inputs.row % height, slot[where]), inputs.data)
        return found

    def first_order(self, x: Array) -> tuple[Array, Array, sp.csr_matrix]:
        """Gradient of the objective (n,), rows (rows,) and the rows' Jacobian (rows, n)."""
        self._see(x)
        program, o = self.program, self._o.ravel()
        gradient = self._moved.T @ self._on_outputs() + program.price
        gradient += program.inputs.T @ (self._effort * self._z).ravel()
        rows = program.outputs @ o + program.linear @ x
        return gradient, rows, sp.csr_matrix(program.outputs @ self._moved + program.linear)

    def evaluate(self, x: Array) -> tuple[Array, Array]:
        """As :meth:`Program.evaluate`."""
        self._see(x)
        return self._z.T, self._o.T

    def curvature(self, x: Array, share: float, multipliers: Array | float, ridge: float) -> Array:
        """The Hessian (n, n) with a share of the torques' curvature, and a ridge.

        Without both, the share and the multipliers, it is never negative.
        """
        self._see(x)
        program, size = self.program, self.program.size
        on = share * self._on_outputs() + program.outputs.T @ np.broadcast_to(multipliers, program.rows)
        on = on.reshape(self._o.shape)
        used = (self._weight != 0.0) | (on != 0.0).any(axis=1)
        chosen = np.flatnonzero(used)  # points that only rows without multipliers look at bend nothing
        curved = self._dense("hessian", self._called("hessian", chosen, on, self._weight[:, None])[0])
        axis = np.arange(curved.shape[1])
        curved[:, axis, axis] += self._effort[chosen]
        place, found = np.cumsum(used) - 1, np.zeros((size + 1, size + 1))
        for points in self._sections:
            points = points[used[points]]
            if len(points):
                local, columns = self._local[points], self._columns[points[0]]
                width = local.shape[2]
                block = local.reshape(-1, width).T @ (curved[place[points]] @ local).reshape(-1, width)
                found[columns[:, None], columns] += block
        moved = self._moved.data.reshape(-1, self._local.shape[2])
        for item in self._groups:
            torque = np.zeros((len(item.outs), len(item.unknowns)))
            torque[np.arange(len(item.outs))[:, None], item.slots] = moved[item.outs]
            rates = item.matrix @ torque
            found[np.ix_(item.unknowns, item.unknowns)] += (2.0 * program.scale) * (rates.T @ rates)
        found = found[:size, :size]
        found[np.diag_indices(size)] += ridge
        return np.asarray(found)

    def _see(self, x: Array) -> None:
        """Inputs, outputs and their slopes by the unknowns, unless they are there."""
        if np.array_equal(x, self._x):
            return
        self._x = x.copy()
        self._z = (self.program.inputs @ x).reshape(self.program.points.count, -1)
        self._o, values = self._called("jacobian", np.arange(len(self._z)))
        self._moved.data = (self._dense("jacobian", values) @ self._local).ravel()

    def _dense(self, kind: str, values: Array) -> Array:
        """(K, height, width) of a function's last output at every point, from its nonzeros."""
        rows, columns = self._places[kind]
        pattern = self.program.functions.pattern(kind)
        found = np.zeros((len(values), pattern.size1(), pattern.size2()))
        found[:, rows, columns] = values
        return found

    def _on_outputs(self) -> Array:
        """D objective / d outputs, point by point."""
        program, o = self.program, self._o.ravel()
        rates = program.smooth.T @ (program.smooth @ o)
        return np.asarray(self._torque.ravel() * o + 2.0 * program.scale * rates)

    def _called(self, kind: str, chosen: Indices, *more: Array) -> list[Array]:
        """A function's outputs at chosen points, (len(chosen), nonzeros) each; ``more`` (K, ...) of all points."""
        program, found = self.program, []
        first = int(np.searchsorted(chosen, program.groups[0]))
        for side, part in enumerate((chosen[:first], chosen[first:])):
            if len(part):
                given = [a[part].ravel() for a in (self._z, program.pivots.T, *more)]
                outputs = program.functions.called(kind, len(part), side, given)
                found.append([a.reshape(len(part), -1).copy() for a in outputs])
        return [np.vstack(parts) for parts in zip(*found, strict=True)]
