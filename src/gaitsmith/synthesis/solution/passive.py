"""Leans of line soles between the collocation points: no joint drives them, so that their equation of motion must hold.

The program holds it at its points only. In the air the support sole's lean is solved from it, as polynomials of high
degree through the ends that the program gave; what is left at the far end is taken up by a small change of the joints
at knots inside. In double support the wrench on the other sole, whose cones do not mind, is scaled until no moment is
left about the support's line.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby

import numpy as np
import numpy.typing as npt

from gaitsmith.splines.polynomial import hermite, polynomial
from gaitsmith.synthesis.gaits.gait import LEAN_DEGREE
from gaitsmith.synthesis.point.functions import PointFunctions
from gaitsmith.synthesis.program.transcription import Transcription

Array = npt.NDArray[np.float64]
LocalPiece = tuple[float, float, Array]  # start, duration, coefficients in local order
_ROUNDS = 6
_DONE = 1e-12  # of the robot's unit of torque
_POWERS = np.array(
    [
        np.polynomial.Polynomial.cast(np.polynomial.Chebyshev.basis(k, [0, 1])).coef.tolist()
        + [0.0] * (LEAN_DEGREE - k)
        for k in range(LEAN_DEGREE + 1)
    ]
).T  # from Chebyshev coefficients on [0, 1] to those of 1, s, s² ...
_NODES = 0.5 - 0.5 * np.cos(np.pi * np.arange(LEAN_DEGREE - 1) / (LEAN_DEGREE - 2))


def balanced(trans: Transcription, functions: PointFunctions, phase: int, z: Array) -> Array:
    """Inputs (inputs, N) of a phase with u scaled so that no moment about the support's line is left."""
    layout, item = trans.layout, trans.motion.phases[phase]
    if not layout.leans or not item.double:
        return z
    pivots, bare = np.tile(trans.pivots[phase][:, None], (1, z.shape[1])), z.copy()
    bare[layout.wrench :] = 0.0
    without, found = (functions.evaluate(values, pivots, item.side)[layout.moment] for values in (bare, z))
    share = found - without
    enough = np.abs(share) > _DONE * trans.biped.effort
    bare[layout.wrench :] = z[layout.wrench :] * np.where(enough, -without / np.where(enough, share, 1.0), 1.0)
    return bare


def with_leans(
    trans: Transcription, functions: PointFunctions, pieces: list[list[LocalPiece]]
) -> list[list[LocalPiece]]:
    """All phases' pieces with the leans of single support solved from their equation of motion."""
    if not trans.layout.leans:
        return pieces
    found, phases = list(pieces), trans.motion.phases
    for (double, _), group in groupby(range(len(phases)), lambda k: (phases[k].double, phases[k].support)):
        run = list(group)
        if double:
            continue
        solved = iter(
            _Run(trans, functions, run[0], [piece for k in run for piece in pieces[k]], _borders(pieces, run)).solved()
        )
        for k in run:
            found[k] = [next(solved) for _ in pieces[k]]
    return found


def _borders(pieces: list[list[LocalPiece]], run: list[int]) -> set[int]:
    """Knots of a run of phases, counted from its start, at which phases meet."""
    return set(np.cumsum([len(pieces[k]) for k in run]).tolist())


@dataclass(eq=False)
class _Run:
    """Phases in a row with one sole on the ground."""

    trans: Transcription
    functions: PointFunctions
    phase: int
    pieces: list[LocalPiece]
    borders: set[int]

    def solved(self) -> list[LocalPiece]:
        """The pieces with their equation of motion met; as they were where Newton's method does not arrive."""
        layout, n = self.trans.layout, self.trans.layout.joints
        spans = np.array([span for _, span, _ in self.pieces])
        states = np.array([polynomial(c, np.zeros(1), span)[:, :, 0] for _, span, c in self.pieces])
        _, span, last = self.pieces[-1]
        states = np.concatenate([states, polynomial(last, np.ones(1), span)[None, :, :, 0]])  # (P + 1, 3, c)
        ends = states[[0, -1], :2, n]
        free = [k for k in range(1, len(self.pieces)) if k not in self.borders]
        basis = [np.polynomial.chebyshev.Chebyshev(row, [0, 1]) for row in np.eye(LEAN_DEGREE + 1)]
        tables = np.array([[p.deriv(d)(_NODES) if d else p(_NODES) for p in basis] for d in range(3)])  # (3, D + 1, N)
        sides = np.array([[[p.deriv(d)(x) if d else p(x) for p in basis] for d in range(2)] for x in (0.0, 1.0)])
        lean = np.array([np.linalg.lstsq(_POWERS, _padded(c)[n], rcond=None)[0] for _, _, c in self.pieces])
        toward = None
        for _ in range(_ROUNDS):
            curves = [hermite(h, *states[k : k + 2]) for k, h in enumerate(spans)]
            z = self._inputs(curves, lean, spans)
            o, J = self.functions.differentiate(z, np.zeros((3, z.shape[1])), self.trans.motion.phases[self.phase].side)
            scale = 1.0 / self.trans.biped.effort
            moment, slope = o[layout.moment] * scale, J[:, layout.moment] * scale
            if toward is None:
                toward = slope[:, layout.acceleration : layout.acceleration + n].mean(axis=0)
                toward = toward / np.linalg.norm(toward)
            left = self._ends(lean, spans, sides, ends)
            if max(np.abs(moment).max(), np.abs(left).max()) < _DONE:
                break
            matrix = self._matrix(slope, spans, tables, sides, free, toward)
            step = np.linalg.lstsq(matrix, -np.concatenate([moment, left]), rcond=None)[0]
            lean = lean + step[: lean.size].reshape(lean.shape)
            for k, change in zip(free, step[lean.size :].reshape(-1, 3), strict=True):
                h = spans[k]
                states[k, :, :n] += np.outer(change * (1.0, 1.0 / h, 1.0 / h**2), toward)
        if not np.isfinite(lean).all():
            return self.pieces
        return [(a, h, self._whole(hermite(h, *states[k : k + 2]), lean[k])) for k, (a, h, _) in enumerate(self.pieces)]

    def _whole(self, curve: Array, lean: Array) -> Array:
        """Coefficients (c, LEAN_DEGREE + 1) with the support's lean from its Chebyshev coefficients."""
        found = _padded(curve)
        found[self.trans.layout.joints] = _POWERS @ lean
        return found

    def _inputs(self, curves: list[Array], lean: Array, spans: Array) -> Array:
        """Inputs (inputs, P * N) at all nodes."""
        layout, found = self.trans.layout, []
        for curve, own, h in zip(curves, lean, spans, strict=True):
            z = np.zeros((layout.inputs, len(_NODES)))
            z[: layout.wrench] = polynomial(self._whole(curve, own), _NODES, h).reshape(layout.wrench, -1)
            found.append(z)
        return np.hstack(found)

    @staticmethod
    def _ends(lean: Array, spans: Array, sides: Array, ends: Array) -> Array:
        """What is left of the lean's value and rate at both ends, and of their continuity in between."""
        rates = np.array([np.ones_like(spans), 1.0 / spans])  # (2, P)
        first, last = ((side @ lean.T) * rates for side in sides)  # (2, P)
        return np.concatenate([first[:, 0] - ends[0], last[:, -1] - ends[1], (last[:, :-1] - first[:, 1:]).ravel()])

    def _matrix(self, slope: Array, spans: Array, tables: Array, sides: Array, free: list[int], toward: Array) -> Array:
        """Derivatives of moments and ends by the leans' coefficients and the changes of the free knots."""
        layout, count, terms = self.trans.layout, len(spans), LEAN_DEGREE + 1
        nodes, places = len(_NODES), (layout.position, layout.velocity, layout.acceleration)
        found = np.zeros((count * nodes + 2 * count + 2, count * terms + 3 * len(free)))
        by_lean = slope[:, [place + layout.joints for place in places]]
        by_joints = np.array([slope[:, place : place + layout.joints] @ toward for place in places]).T
        for k, h in enumerate(spans):
            rows, columns = slice(k * nodes, (k + 1) * nodes), slice(k * terms, (k + 1) * terms)
            found[rows, columns] = sum(by_lean[rows, d, None] * tables[d].T / h**d for d in range(3))
            for side in (0, 1):
                if k + side not in free:
                    continue
                scale = np.diag([1.0, 1.0 / spans[k + side], 1.0 / spans[k + side] ** 2])
                states = [scale, np.zeros((3, 3))] if side == 0 else [np.zeros((3, 3)), scale]
                moved = polynomial(hermite(h, *states), _NODES, h)  # (3, 3, N): derivative, parameter
                first = count * terms + 3 * free.index(k + side)
                found[rows, first : first + 3] += np.einsum("nd,dpn->np", by_joints[rows], moved)
        row = count * nodes
        for k, side, sign, at in [(0, 0, 1.0, row), (count - 1, 1, 1.0, row + 2)]:
            for d in range(2):
                found[at + d, k * terms : (k + 1) * terms] = sign * sides[side, d] / spans[k] ** d
        for k in range(count - 1):
            for d in range(2):
                at = row + 4 + d * (count - 1) + k
                found[at, k * terms : (k + 1) * terms] = sides[1, d] / spans[k] ** d
                found[at, (k + 1) * terms : (k + 2) * terms] = -sides[0, d] / spans[k + 1] ** d
        return found


def _padded(coefficients: Array) -> Array:
    """Coefficients (c, LEAN_DEGREE + 1) with zeros behind."""
    found = np.zeros((len(coefficients), LEAN_DEGREE + 1))
    found[:, : coefficients.shape[1]] = coefficients
    return found
