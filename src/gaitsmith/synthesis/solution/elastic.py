"""The elastic program, with soft bounds and a penalty on their excess: what a request asks for beyond the robot."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from gaitsmith.synthesis.program.bounds import Kind
from gaitsmith.synthesis.program.program import Program
from gaitsmith.synthesis.program.rows import Label
from gaitsmith.synthesis.solution.ipopt import Progress, solve_ipopt

Array = npt.NDArray[np.float64]
_PENALTIES = {Kind.TORQUE: 1.0, Kind.VELOCITY: 1.0, Kind.ANGLE: 3.0, Kind.ZMP: 3.0, Kind.NORMAL_FORCE: 3.0}
_OTHERS = 10.0  # penalty of what is asked for, rather than what the robot can do
_CONDITIONS = 100.0  # of what has to hold exactly
_JOINT = (Kind.TORQUE, Kind.VELOCITY, Kind.ANGLE)
_COST = 1e-4  # share of the objective that is kept, so that the least motion is chosen
_TOLERANCE = 1e-4
_NOTHING = 1e-4  # of a range


@dataclass(frozen=True)
class Excess:
    """A bound that has to be exceeded, where it is exceeded most.

    Attributes:
        label: of the row: name, unit, phase, time.
        value: in the label's unit.
        limit: that it is compared with, in the same unit.
        share: by which it is exceeded, of its range.
    """

    label: Label
    value: float
    limit: float
    share: float


@dataclass(frozen=True, eq=False)
class Elastic:
    """The least excess with which a request can be met.

    Attributes:
        solved: whether the excess is at its least; else nothing is decided.
        x: unknowns.
        iterations: that it took.
        excesses: the bounds exceeded, the joints' own first, the worst first; none if the request can be met.
        unmet: the equality that holds least; None where all hold.
    """

    solved: bool
    x: Array
    iterations: int
    excesses: list[Excess] = field(default_factory=list)
    unmet: Excess | None = None

    @property
    def total(self) -> float:
        """All excesses together, shares of their ranges."""
        return sum(item.share for item in self.excesses) + (self.unmet.share if self.unmet is not None else 0.0)


def solve_elastic(
    program: Program, start: Array, max_iterations: int, report: Callable[[Progress], None] | None = None
) -> Elastic:
    """Solve a program whose bounds may be exceeded, and whose conditions may be missed; closure and dynamics hold.

    All rows of one name share one unknown, the share of the range by which they may be exceeded.

    Args:
        program: the program, with all the bounds that matter.
        start: unknowns to start from.
        max_iterations: before it gives up.
        report: called at every iteration.
    """
    soft = _elastic(program)
    _, o = program.evaluate(start)
    gaps = program.violation(program.constraint(start, o))
    begin = np.concatenate([start, np.zeros(soft.size - program.size)])
    for row, column in enumerate(_columns(program)):
        if column >= 0:
            begin[program.size + column] = max(begin[program.size + column], 1.01 * gaps[row])
    found = solve_ipopt(soft, begin, _TOLERANCE, max_iterations, report)
    x = found.x[: program.size]
    _, o = program.evaluate(x)
    values = program.constraint(x, o)
    if not np.isfinite(values).all():
        return Elastic(False, start, found.iterations)
    gaps = program.violation(values)
    worst: dict[str, int] = {}
    for row, label in enumerate(program.labels):
        if label.kind is not None and gaps[row] > max(_NOTHING, gaps[worst.get(label.name, row)] * 0.999):
            worst[label.name] = row
    # What the joints lack comes first: a ZMP out of place is often its consequence.
    order = sorted(worst.values(), key=lambda row: (program.labels[row].kind not in _JOINT, -gaps[row]))
    excesses = [excess_of(program, row, values) for row in order]
    soft_row = np.array([label.kind is not None for label in program.labels])
    row = int(np.argmax(np.where(soft_row, 0.0, gaps)))
    unmet = None if soft_row[row] or gaps[row] < _NOTHING else excess_of(program, row, values)
    return Elastic(found.solved, x, found.iterations, excesses, unmet)


def excess_of(program: Program, row: int, values: Array) -> Excess:
    """What a row exceeds, from the values of all rows."""
    label, value = program.labels[row], float(values[row])
    limit = float(program.low[row] if value < program.low[row] else program.high[row])
    return Excess(label, label.shown(value), label.shown(limit), abs(value - limit))


def _columns(program: Program) -> list[int]:
    """Per row the number of the unknown by which it may be exceeded; -1 for what holds by construction."""
    names: dict[str, int] = {}
    return [
        -1 if label.kind is None else names.setdefault(label.name + " exactly" * label.exact, len(names))
        for label in program.labels
    ]


def _penalties(program: Program, columns: npt.NDArray[np.int64], extra: int) -> Array:
    """Penalty on an excess of a whole range: what the robot lacks shall be named, not what was asked of it."""
    found = np.zeros(extra)
    for label, column in zip(program.labels, columns.tolist(), strict=True):
        if column >= 0 and label.kind is not None:
            found[column] = _CONDITIONS if label.exact else _PENALTIES.get(label.kind, _OTHERS)
    return found


def _elastic(program: Program) -> Program:
    """The program with one more unknown for every name of a bound: two-sided rows are split, penalties are added."""
    columns = np.array(_columns(program))
    extra = int(columns.max(initial=-1)) + 1
    equal = np.flatnonzero(columns < 0)
    above = np.flatnonzero((columns >= 0) & np.isfinite(program.high))
    below = np.flatnonzero((columns >= 0) & np.isfinite(program.low))
    source = np.concatenate([equal, above, below])
    count = len(source)
    give = np.concatenate([np.zeros(len(equal)), -np.ones(len(above)), np.ones(len(below))])
    bounded = np.flatnonzero(give)
    slack = sp.csr_matrix((give[bounded], (bounded, columns[source[bounded]])), shape=(count, extra))
    positive = sp.hstack([sp.csr_matrix((extra, program.size)), sp.eye_array(extra)])
    infinite = np.full(extra, np.inf)
    low = np.concatenate([program.low[equal], np.full(len(above), -np.inf), program.low[below], np.zeros(extra)])
    high = np.concatenate([program.high[equal], program.high[above], np.full(len(below), np.inf), infinite])
    labels = [program.labels[row] for row in source] + [Label("excess", "", 0, 0.0, 1.0)] * extra
    return replace(
        program,
        scale=program.scale * _COST,
        inputs=sp.csr_matrix(sp.hstack([program.inputs, sp.csr_matrix((program.inputs.shape[0], extra))])),
        outputs=sp.csr_matrix(sp.vstack([program.outputs[source], sp.csr_matrix((extra, program.outputs.shape[1]))])),
        linear=sp.csr_matrix(sp.vstack([sp.hstack([program.linear[source], slack]), positive])),
        low=low,
        high=high,
        labels=labels,
        price=np.concatenate([np.zeros(program.size), _penalties(program, columns, extra)]),
    )
