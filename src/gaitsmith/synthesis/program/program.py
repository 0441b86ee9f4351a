"""The nonlinear program (19), (20): objective and rows at chosen points, with derivatives assembled as BᵀHB."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from operator import attrgetter

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from gaitsmith.synthesis.point.functions import PointFunctions
from gaitsmith.synthesis.program.boundary import closure_rows, condition_rows, passive_rows, wrench_rows
from gaitsmith.synthesis.program.bounds import Kind, PhaseBound
from gaitsmith.synthesis.program.cones import cone_rows, is_cone
from gaitsmith.synthesis.program.rates import rate_form, rate_label, steepest
from gaitsmith.synthesis.program.rows import Entries, Label, Labels, Rows, bound_label, tightened
from gaitsmith.synthesis.program.smoothness import torque_rates
from gaitsmith.synthesis.program.transcription import Points, Transcription

Array = npt.NDArray[np.float64]
_PARTS = attrgetter("phase", "bound", "time", "tighten")
_SCALE = 9.5  # of the objective in units of the robot's weight, leg and the time in which it falls over
CURVED = (Kind.FRICTION, Kind.YAW_MOMENT)  # far from a solution these rows make the solver wander
SELDOM = (Kind.TORQUE, *CURVED)  # imposed only where the dense grid asks for it


@dataclass(frozen=True, eq=False)
class Program:
    """min scale * (sum of weights (τᵀτ + zᵀ diag(ρ) z) + ‖S vec(O)‖²) + priceᵀx; low <= C vec(O) + D x <= high.

    Attributes:
        functions: of a point.
        points: where they are evaluated, those of the first of the functions' sides first.
        groups: how many of each side.
        pivots: (3, K), on slopes (6, K): with gravity.
        inputs: B, (K * inputs, size).
        outputs: C, (rows, K * outputs).
        linear: D, (rows, size).
        low, high: (rows,).
        labels: what each row says.
        torque_weight: (joints, K) of τ² in (16).
        effort: ρ, (inputs,), of u in (16) and of the accelerations beside it.
        smooth: S, the torque rates times the root of their weight, and what torques weigh more than the lightest.
        scale: of the objective.
        price: (size,) of the unknowns, a linear part of the scaled objective.
    """

    functions: PointFunctions
    points: Points
    groups: tuple[int, ...]
    pivots: Array
    inputs: sp.csr_matrix
    outputs: sp.csr_matrix
    linear: sp.csr_matrix
    low: Array
    high: Array
    labels: Sequence[Label]
    torque_weight: Array
    effort: Array
    smooth: sp.csr_matrix
    scale: float
    price: Array

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return int(self.inputs.shape[1])

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(self.low)

    def evaluate(self, x: Array) -> tuple[Array, Array]:
        """Inputs (inputs, K) and outputs (outputs, K) of all points."""
        layout = self.functions.layout
        z = (self.inputs @ x).reshape(self.points.count, layout.inputs).T
        first = self.groups[0]
        parts = ((slice(first), 1.0), (slice(first, None), -1.0))
        return z, np.hstack([self.functions.evaluate(z[:, k], self.pivots[:, k], side) for k, side in parts])

    def constraint(self, x: Array, o: Array) -> Array:
        """Values of the rows (rows,) from the outputs at ``x``."""
        return np.asarray(self.outputs @ o.T.ravel() + self.linear @ x)

    def objective(self, z: Array, o: Array) -> float:
        """J of eq. (16), unscaled, without rates, accelerations and prices."""
        layout = self.functions.layout
        torque, u = np.sum(self.torque_weight * o[: layout.joints] ** 2, axis=0), z[layout.wrench :]
        return float(self.points.weight @ (torque + self.effort[layout.wrench :] @ u**2))

    def cost(self, z: Array, o: Array) -> float:
        """What is minimised, unscaled and without prices."""
        torque, rates = o[: self.functions.layout.joints], self.smooth @ o.T.ravel()
        least = self.torque_weight.min() * np.sum(torque**2, axis=0)
        return float(self.points.weight @ (least + self.effort @ z**2) + rates @ rates)

    def violation(self, values: Array) -> Array:
        """By how much each row is violated, 0 where it holds."""
        return np.asarray(np.maximum(np.maximum(self.low - values, values - self.high), 0.0))


@dataclass(frozen=True)
class ImposedBound:
    """A bound that the program imposes at a time: ``bound`` counts the phase's; ``tighten`` is a share of its span."""

    phase: int
    bound: int
    time: float
    tighten: float = 0.0


def make_program(
    trans: Transcription, functions: PointFunctions, points: Points, imposed: list[ImposedBound] | None = None
) -> Program:
    """The program on given points.

    Args:
        trans: unknowns and bounds.
        functions: of a point.
        points: collocation points and added ones.
        imposed: bounds to impose; all bounds at all points if None.
    """
    side = np.array([functions.side(phase.side) for phase in trans.motion.phases])[points.phase]
    order = np.argsort(side, kind="stable")
    fixed, smooth, position = _fixed_rows(trans, points), _smooth(trans, points), np.argsort(order)
    points = Points(*(values[order] for values in vars(points).values()))
    inputs = trans.input_map(points)
    if imposed is None:
        imposed = every_bound(trans, points)
    layout, first, table = trans.layout, len(fixed.low), trans.rows
    parts = np.array(list(map(_PARTS, imposed))).reshape(-1, 4).T
    (phase, bound), (time, tighten) = parts[:2].astype(np.int64), parts[2:]
    steep = bound >= np.diff(table.first)[phase]
    plain = np.flatnonzero(~steep)
    number, low, high = (table.first[phase] + bound)[plain], np.full(len(imposed), -0.5), np.full(len(imposed), 0.5)
    low[steep], high[steep] = tightened(low[steep], high[steep], tighten[steep])
    low[plain], high[plain] = table.limits(number, trans.share(phase[plain], time[plain]), tighten[plain])
    spans = [2.0 * steepest(trans, index) for index in range(len(trans.bounds))]
    rates, where = [], points.places() if steep.any() else {}
    for row in np.flatnonzero(steep).tolist():
        item = imposed[row]
        keys, weights = rate_form(trans, item.phase, item.time)
        torque = layout.torque + item.bound - len(trans.bounds[item.phase])
        columns = np.array([where[key] for key in keys]) * layout.outputs + torque
        rates.append((np.full(len(keys), first + row), columns, weights / spans[item.phase]))

    def label(row: int) -> Label:
        item = imposed[row]
        if steep[row]:
            return rate_label(trans, item.phase, item.bound, item.time, spans[item.phase])
        return bound_label(trans.bounds[item.phase][item.bound], item.phase, item.time)

    shape, (out, lin, inp) = (first + len(imposed), points.count * layout.outputs), fixed.entries
    own, on_inputs = (
        (entries[0], position[entries[1] // width] * width + entries[1] % width, entries[2])
        for entries, width in ((out, layout.outputs), (inp, layout.inputs))
    )
    on_points = table.entries(number, first + plain, points.find(phase[plain], time[plain]), layout)
    c = _matrix([own, on_points[0], *rates], shape)
    by_input = _matrix([on_inputs, on_points[1]], (shape[0], points.count * layout.inputs))
    d = sp.csr_matrix(_matrix([lin], (shape[0], trans.size)) + by_input @ inputs)
    torque_weight = _torque_weights(trans, points)
    moved = position[smooth.indices // layout.outputs] * layout.outputs + smooth.indices % layout.outputs
    return Program(
        functions=functions,
        points=points,
        groups=tuple(int(np.sum(side == k)) for k in range(len(functions.sides))),
        pivots=trans.pivots[points.phase].T.copy(),
        inputs=inputs,
        outputs=c,
        linear=d,
        low=np.concatenate([fixed.low, low]),
        high=np.concatenate([fixed.high, high]),
        labels=Labels(fixed.labels, len(imposed), label),
        torque_weight=torque_weight,
        effort=_efforts(trans),
        smooth=sp.csr_matrix((smooth.data, moved, smooth.indptr), (smooth.shape[0], points.count * layout.outputs)),
        scale=_SCALE / (trans.biped.effort**2 * trans.biped.fall_time),
        price=np.zeros(trans.size),
    )


def _fixed_rows(trans: Transcription, points: Points) -> Rows:
    """The rows that all programs of a motion have in common, on the points in the order given; kept."""
    if trans.fixed is None:
        rows = Rows(trans.layout, trans.size)
        closure_rows(rows, trans, points)
        passive_rows(rows, trans, points)
        wrench_rows(rows, trans, points)
        condition_rows(rows, trans, points)
        cone_rows(rows, trans, points)
        trans.fixed = rows
    return trans.fixed


def _smooth(trans: Transcription, points: Points) -> sp.csr_matrix:
    """S on the points in the order given; kept, as only those that all programs have in common take part."""
    if trans.smooth is None:
        rates = torque_rates(trans, points) * (math.sqrt(trans.settings.rate_weight) * trans.biped.fall_time)
        trans.smooth = sp.csr_matrix(sp.vstack([rates, _heavier(trans, points, _torque_weights(trans, points))]))
    return trans.smooth


def _matrix(parts: list[Entries], shape: tuple[int, int]) -> sp.csr_matrix:
    """Entries as a matrix in compressed rows."""
    row, column, value = (np.concatenate([part[k] for part in parts]) for k in range(3))
    return sp.csr_matrix((value, (row, column)), shape=shape)


def _torque_weights(trans: Transcription, points: Points) -> Array:
    """(joints, K) weights of τ², joints in local order."""
    biped = trans.biped
    own = trans.settings.weights(biped.names)
    left = np.array([phase.side < 0.0 for phase in trans.motion.phases])[points.phase]
    return np.where(left, own[biped.partner][:, None], own[:, None])


def _heavier(trans: Transcription, points: Points, weight: Array) -> sp.csr_matrix:
    """(rows, K * outputs): the sum of their squares is what joints with larger weights add to the lightest's."""
    more = np.sqrt(np.maximum(points.weight, 0.0) * (weight - weight.min()))
    joint, point = np.nonzero(more)
    columns = point * trans.layout.outputs + trans.layout.torque + joint
    shape = (len(joint), points.count * trans.layout.outputs)
    return sp.csr_matrix((more[joint, point], (np.arange(len(joint)), columns)), shape=shape)


def _efforts(trans: Transcription) -> Array:
    """(inputs,) weights of the squares of accelerations and of u beside those of the torques."""
    layout, biped, settings = trans.layout, trans.biped, trans.settings
    found = np.zeros(layout.inputs)
    inertia = biped.effort * biped.fall_time**2
    found[layout.acceleration : layout.wrench] = settings.acceleration_weight * inertia**2
    found[layout.wrench :] = settings.wrench_weight
    return found


def unloaded(trans: Transcription, phase: int, start: bool, end: bool) -> bool:
    """Whether a support sole bears nothing at an end of a phase, because a flight is there."""
    phases = trans.motion.phases
    after_flight = start and phase > 0 and phases[phase - 1].flies
    return (
        after_flight
        or (start and trans.motion.takes_over(phase))
        or (end and phase + 1 < len(phases) and phases[phase + 1].flies)
    )


def bears(trans: Transcription, bound: PhaseBound) -> bool:
    """Whether a bound is on the wrench on the support sole."""
    layout = trans.layout
    return any(layout.force <= k < layout.pivot or k in (layout.twist, layout.load) for k in bound.out)


def every_bound(trans: Transcription, points: Points, without: tuple[Kind, ...] = ()) -> list[ImposedBound]:
    """Every bound at every point, but those of some kinds."""
    borders = trans.motion.borders
    found, kept = [], dict[tuple[int, bool, bool], list[int]]()
    for phase, time, control in zip(points.phase.tolist(), points.time.tolist(), points.control.tolist(), strict=True):
        if control >= 0:
            continue
        start, end = abs(time - borders[phase]) < 1e-9, abs(time - borders[phase + 1]) < 1e-9
        if (phase, start, end) not in kept:
            kept[phase, start, end] = _holding(trans, phase, start, end, without)
        found += [ImposedBound(phase, k, time) for k in kept[phase, start, end]]
    return found


def _holding(trans: Transcription, phase: int, start: bool, end: bool, without: tuple[Kind, ...]) -> list[int]:
    """Bounds of a phase that hold inside it, or at its start or end."""
    motion, found = trans.motion, []
    free = (start and motion.meets(phase)) or (end and motion.leaves(phase))
    idle = unloaded(trans, phase, start, end)
    for k, bound in enumerate(trans.bounds[phase]):
        # A wrench that is zero sits on all its cones at once; such rows only make the program degenerate.
        coned = is_cone(trans, bound) or (free and bool(bound.inp) and min(bound.inp) >= trans.layout.wrench)
        coned = coned or (idle and bears(trans, bound))
        if not bound.free_at(start, end) and not coned and bound.kind not in without:
            found.append(k)
    return found
