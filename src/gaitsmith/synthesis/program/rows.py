"""Rows of the nonlinear program: linear in the outputs of the points and in the unknowns."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from gaitsmith.synthesis.point.layout import PointLayout
from gaitsmith.synthesis.program.bounds import Kind, PhaseBound, shown
from gaitsmith.synthesis.program.quantities import Form

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Label:
    """What a row says, where, and how its value reads: value times span plus constant, or the angle with that sine.

    ``kind`` is that of a bound or a condition; None for what holds by construction. ``exact``: an equality.
    """

    name: str
    unit: str
    phase: int
    time: float
    span: float
    constant: float = 0.0
    sine: bool = False
    kind: Kind | None = None
    exact: bool = False

    def shown(self, value: float) -> float:
        """The row's value, or a bound on it, in the unit."""
        return shown(value * self.span + self.constant, self.sine)


def bound_label(bound: PhaseBound, phase: int, time: float) -> Label:
    """What a row says that imposes a bound at a time."""
    constant = 0.0 if bound.rise else bound.constant
    return Label(bound.name, bound.unit, phase, time, bound.span, constant, bound.sine, bound.kind)


@dataclass
class Rows:
    """low <= C vec(O) + D x <= high; O (outputs, K) and Z (inputs, K), linear in x, are taken column by column.

    Bounds whose range is large are divided by ``span`` so that all rows have comparable size.
    """

    layout: PointLayout
    size: int
    low: list[float] = field(default_factory=list)
    high: list[float] = field(default_factory=list)
    labels: list[Label] = field(default_factory=list)
    _entries: tuple[list[tuple[int, int, float]], ...] = field(default_factory=lambda: ([], [], []))

    def add(
        self,
        label: Label,
        low: float,
        high: float,
        out: Form | None = None,
        lin: Form | None = None,
        inp: Form | None = None,
    ) -> None:
        """Append a row: factors by index of vec(O), of x, and of vec(Z)."""
        self._append(label, low, high)
        row = len(self.low) - 1
        for entries, form in zip(self._entries, (out, lin, inp), strict=True):
            if form:
                entries += [(row, index, value) for index, value in form.items() if value]

    def _append(self, label: Label, low: float, high: float) -> None:
        """A row without entries."""
        self.low.append(low)
        self.high.append(high)
        self.labels.append(label)

    def add_linear(self, label: Label, matrix: sp.csr_matrix, values: Array) -> None:
        """Append equality rows matrix x = values."""
        for k in range(matrix.shape[0]):
            begin, end = matrix.indptr[k], matrix.indptr[k + 1]
            lin = dict(zip(matrix.indices[begin:end].tolist(), matrix.data[begin:end].tolist(), strict=True))
            self.add(label, float(values[k]), float(values[k]), lin=lin)

    def add_bound(self, bound: PhaseBound, label: Label, point: int, share: float, tighten: float = 0.0) -> None:
        """Append a bound at a point, divided by its span; ``share``: normalised time; ``tighten``: part of the span."""
        constant = bound.constant if not bound.rise else float(bound.offset(np.array(share)))
        low, high = ((limit - constant) / bound.span for limit in (bound.low, bound.high))
        low, high = low + tighten, high - tighten
        if low > high:
            low = high = 0.5 * (low + high)
        self._append(label, low, high)
        row, span = len(self.low) - 1, bound.span
        sides = (bound.out, point * self.layout.outputs, 0), (bound.inp, point * self.layout.inputs, 2)
        for form, first, which in sides:
            if form:
                self._entries[which].extend([(row, first + k, value / span) for k, value in form.items() if value])

    def matrices(self, inputs: sp.csr_matrix) -> tuple[sp.csr_matrix, sp.csr_matrix]:
        """C (rows, outputs * K) and D (rows, size), with the map from x to vec(Z) (inputs * K, size)."""
        points = inputs.shape[0] // self.layout.inputs
        found = []
        columns = (self.layout.outputs * points, self.size, inputs.shape[0])
        for entries, width in zip(self._entries, columns, strict=True):
            row, index, value = np.array(entries, dtype=np.float64).reshape(-1, 3).T
            places = row.astype(np.int64), index.astype(np.int64)
            found.append(sp.csr_matrix((value, places), shape=(len(self.low), width)))
        return found[0], sp.csr_matrix(found[1] + found[2] @ inputs)
