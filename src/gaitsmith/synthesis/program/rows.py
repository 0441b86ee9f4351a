"""Rows of the nonlinear program: linear in the outputs of the points and in the unknowns."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from gaitsmith.synthesis.point.layout import PointLayout
from gaitsmith.synthesis.program.bounds import Kind, PhaseBound, shown
from gaitsmith.synthesis.program.quantities import Form

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]
Entries = tuple[Indices, Indices, Array]


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

    def add_bound(
        self, bound: PhaseBound, phase: int, time: float, point: int, share: float, tighten: float = 0.0
    ) -> None:
        """Append a bound at a point, divided by its span; ``share``: normalised time; ``tighten``: part of the span."""
        row = bound_row(bound, phase, time, share)
        low, high = tightened(np.array([row.low]), np.array([row.high]), np.array([tighten]))
        out, inp = (
            dict(zip((first + index).tolist(), value.tolist(), strict=True))
            for (index, value), first in ((row.out, point * self.layout.outputs), (row.inp, point * self.layout.inputs))
        )
        self.add(row.label, float(low[0]), float(high[0]), out, inp=inp)

    @cached_property
    def entries(self) -> list[Entries]:
        """Rows, columns and values of what is linear in vec(O), in x, and in vec(Z)."""
        arrays = [np.array(entries, dtype=np.float64).reshape(-1, 3).T for entries in self._entries]
        return [(row.astype(np.int64), index.astype(np.int64), value) for row, index, value in arrays]


@dataclass(frozen=True, eq=False)
class BoundRow:
    """A bound's row at an instant, without its point: kept from one program to the next."""

    low: float
    high: float
    label: Label
    out: tuple[Indices, Array]
    inp: tuple[Indices, Array]


def bound_row(bound: PhaseBound, phase: int, time: float, share: float) -> BoundRow:
    """The row of a bound at a time, divided by its span; ``share``: normalised time."""
    constant = bound.constant if not bound.rise else float(bound.offset(np.array(share)))
    low, high = ((limit - constant) / bound.span for limit in (bound.low, bound.high))
    out, inp = (
        (np.array(list(form), dtype=np.int64), np.array(list(form.values()), dtype=np.float64) / bound.span)
        for form in (bound.out, bound.inp)
    )
    return BoundRow(low, high, bound_label(bound, phase, time), out, inp)


def tightened(low: Array, high: Array, tighten: Array) -> tuple[Array, Array]:
    """Bounds drawn in by parts of their spans; where nothing is left between them, they meet half-way."""
    low, high = low + tighten, high - tighten
    crossed = low > high
    middle = 0.5 * (low[crossed] + high[crossed])
    low[crossed] = high[crossed] = middle
    return low, high


def stacked(parts: list[tuple[Indices, Array]], first: int, shifts: Indices) -> Entries:
    """Entries of rows from ``first`` on, their columns shifted."""
    lengths = [len(index) for index, _ in parts]
    rows = np.repeat(np.arange(first, first + len(parts)), lengths)
    if not parts:
        return rows, rows, np.zeros(0)
    index, value = (np.concatenate([part[k] for part in parts]) for k in range(2))
    return rows, index + np.repeat(shifts, lengths), value
