"""Rows of the nonlinear program: linear in the outputs of the points and in the unknowns."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from gaitsmith.synthesis.point.layout import PointLayout
from gaitsmith.synthesis.program.bounds import Kind, PhaseBound, shown

Array = npt.NDArray[np.float64]

Entries = tuple[list[int], list[int], list[float]]


@dataclass(frozen=True)
class Label:
    """What a row says, where, and how its value reads: value times span plus constant, or the angle with that sine.

    ``kind`` is that of a bound; None for an equality.
    """

    name: str
    unit: str
    phase: int
    time: float
    span: float
    constant: float = 0.0
    sine: bool = False
    kind: Kind | None = None

    def shown(self, value: float) -> float:
        """The row's value, or a bound on it, in the unit."""
        return shown(value * self.span + self.constant, self.sine)


@dataclass
class Rows:
    """low <= C vec(O) + D x <= high; O is (outputs, K), column by column.

    Bounds whose range is large are divided by ``span`` so that all rows have comparable size.
    """

    layout: PointLayout
    size: int
    low: list[float] = field(default_factory=list)
    high: list[float] = field(default_factory=list)
    labels: list[Label] = field(default_factory=list)
    _out: list[tuple[int, int, float]] = field(default_factory=list)
    _lin: list[tuple[int, int, float]] = field(default_factory=list)

    @property
    def count(self) -> int:
        """Number of rows."""
        return len(self.low)

    def add(
        self,
        label: Label,
        low: float,
        high: float,
        out: dict[int, float] | None = None,
        lin: dict[int, float] | None = None,
    ) -> None:
        """Append a row; ``out`` maps indices of vec(O), ``lin`` those of x, to factors."""
        row = self.count
        self._out += [(row, index, value) for index, value in (out or {}).items() if value]
        self._lin += [(row, index, value) for index, value in (lin or {}).items() if value]
        self.low.append(low)
        self.high.append(high)
        self.labels.append(label)

    def add_linear(self, label: Label, matrix: sp.csr_matrix, values: Array) -> None:
        """Append equality rows matrix x = values."""
        for k in range(matrix.shape[0]):
            begin, end = matrix.indptr[k], matrix.indptr[k + 1]
            lin = dict(zip(matrix.indices[begin:end].tolist(), matrix.data[begin:end].tolist(), strict=True))
            self.add(label, float(values[k]), float(values[k]), lin=lin)

    def add_bound(
        self, bound: PhaseBound, label: Label, point: int, share: float, inputs: Entries, tighten: float = 0.0
    ) -> None:
        """Append a bound at a point, divided by its span; ``share``: normalised time; ``tighten``: part of the span."""
        row = self.count
        constant = bound.constant if not bound.rise else float(bound.offset(np.array(share)))
        scale = 1.0 / bound.span
        base = point * self.layout.outputs
        self._out += [(row, base + index, value * scale) for index, value in bound.out.items()]
        starts, columns, values = inputs
        for index, value in bound.inp.items():
            k = point * self.layout.inputs + index
            part = slice(starts[k], starts[k + 1])
            # Columns that occur twice are summed when the matrix is built.
            self._lin += [(row, c, value * scale * v) for c, v in zip(columns[part], values[part], strict=True) if v]
        low = (bound.low - constant) * scale + tighten
        high = (bound.high - constant) * scale - tighten
        if low > high:
            low = high = 0.5 * (low + high)
        self.low.append(low)
        self.high.append(high)
        self.labels.append(label)

    @staticmethod
    def entries(inputs: sp.csr_matrix) -> Entries:
        """The input map as plain lists, which are read faster one by one."""
        return inputs.indptr.tolist(), inputs.indices.tolist(), inputs.data.tolist()

    def matrices(self, points: int) -> tuple[sp.csr_matrix, sp.csr_matrix]:
        """C (rows, outputs * points) and D (rows, size)."""

        def build(entries: list[tuple[int, int, float]], columns: int) -> sp.csr_matrix:
            if not entries:
                return sp.csr_matrix((self.count, columns))
            table = np.array(entries)
            return sp.csr_matrix(
                (table[:, 2], (table[:, 0].astype(np.int64), table[:, 1].astype(np.int64))), shape=(self.count, columns)
            )

        return build(self._out, self.layout.outputs * points), build(self._lin, self.size)
