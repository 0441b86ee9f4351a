"""Rows of the nonlinear program: linear in the outputs of the points and in the unknowns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import overload

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
        own, none = BoundRows([[bound]]), np.zeros(1, dtype=np.int64)
        low, high = own.limits(none, np.array([share]), np.array([tighten]))
        out, inp = (
            dict(zip(index.tolist(), value.tolist(), strict=True))
            for _, index, value in own.entries(none, none, np.array([point]), self.layout)
        )
        self.add(bound_label(bound, phase, time), float(low[0]), float(high[0]), out, inp=inp)

    @cached_property
    def entries(self) -> list[Entries]:
        """Rows, columns and values of what is linear in vec(O), in x, and in vec(Z)."""
        arrays = [np.array(entries, dtype=np.float64).reshape(-1, 3).T for entries in self._entries]
        return [(row.astype(np.int64), index.astype(np.int64), value) for row, index, value in arrays]


class Labels(Sequence[Label]):
    """Labels of a program's rows, made when they are asked for: few ever are.

    Args:
        first: of the first rows.
        count: how many follow.
        make: the label of one of these.
    """

    def __init__(self, first: list[Label], count: int, make: Callable[[int], Label]) -> None:
        self._first, self._count, self._make = first, count, make

    def __len__(self) -> int:
        return len(self._first) + self._count

    @overload
    def __getitem__(self, row: int) -> Label: ...

    @overload
    def __getitem__(self, row: slice) -> list[Label]: ...

    def __getitem__(self, row: int | slice) -> Label | list[Label]:
        if isinstance(row, slice):
            return [self[k] for k in range(*row.indices(len(self)))]
        place = range(len(self))[row] - len(self._first)
        return self._make(place) if place >= 0 else self._first[place]


class BoundRows:
    """The rows of all bounds of all phases, divided by their spans, without instants and points.

    Args:
        phases: every phase's bounds.
    """

    def __init__(self, phases: list[list[PhaseBound]]) -> None:
        every = [bound for bounds in phases for bound in bounds]
        self._bounds = every
        self.first = np.cumsum([0] + [len(bounds) for bounds in phases])
        """(phases + 1,) number of a phase's first bound."""
        self._span = np.array([bound.span for bound in every])
        self._low, self._high = (
            (np.array([getattr(bound, name) - (0.0 if bound.rise else bound.constant) for bound in every])) / self._span
            for name in ("low", "high")
        )
        self._risen = [k for k, bound in enumerate(every) if bound.rise]
        self._out, self._inp = (
            _Forms([getattr(bound, name) for bound in every], self._span) for name in ("out", "inp")
        )

    def limits(self, numbers: Indices, shares: Array, tighten: Array) -> tuple[Array, Array]:
        """Lowest and highest values (N,) of bounds by number, at normalised times of their phases."""
        low, high = self._low[numbers], self._high[numbers]
        for k in self._risen:
            at = np.flatnonzero(numbers == k)
            offset = self._bounds[k].offset(shares[at]) / self._span[k]
            low[at], high[at] = low[at] - offset, high[at] - offset
        return tightened(low, high, tighten)

    def entries(self, numbers: Indices, rows: Indices, points: Indices, layout: PointLayout) -> tuple[Entries, Entries]:
        """Entries in vec(O) and in vec(Z) of bounds by number, in these rows and at these points."""
        out = self._out.entries(numbers, rows, points * layout.outputs)
        return out, self._inp.entries(numbers, rows, points * layout.inputs)


class _Forms:
    """Linear forms in a row, taken many at a time."""

    def __init__(self, forms: list[Form], spans: Array) -> None:
        lengths = np.array([len(form) for form in forms], dtype=np.int64)
        self._first, self._lengths = np.cumsum(lengths) - lengths, lengths
        self._index = np.array([index for form in forms for index in form], dtype=np.int64)
        values = np.array([value for form in forms for value in form.values()], dtype=np.float64)
        self._value = values / np.repeat(spans, lengths)

    def entries(self, numbers: Indices, rows: Indices, shifts: Indices) -> Entries:
        """Entries of forms by number, in rows, their columns shifted."""
        lengths = self._lengths[numbers]
        ends = np.cumsum(lengths)
        place = np.arange(lengths.sum()) + np.repeat(self._first[numbers] - ends + lengths, lengths)
        return np.repeat(rows, lengths), self._index[place] + np.repeat(shifts, lengths), self._value[place]


def tightened(low: Array, high: Array, tighten: Array) -> tuple[Array, Array]:
    """Bounds drawn in by parts of their spans; where nothing is left between them, they meet half-way."""
    low, high = low + tighten, high - tighten
    crossed = low > high
    middle = 0.5 * (low[crossed] + high[crossed])
    low[crossed] = high[crossed] = middle
    return low, high
