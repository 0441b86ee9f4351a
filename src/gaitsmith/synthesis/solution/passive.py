"""Support soles that move, between the collocation points: no joint drives them, so that their equations must hold.

The program holds them at its points only. With one line sole on the ground its lean is solved from its equation of
motion, in flight the pose of the sole from all six, as polynomials of high degree through the ends that the program
gave; what is left at the far end is taken up by small changes of the joints at knots inside. While both line soles
bear, the wrench on the other one, whose cones do not mind, is scaled until no moment is left about the support's line.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import groupby
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from gaitsmith.splines.polynomial import hermite, polynomial
from gaitsmith.synthesis.gaits.gait import ROOT_DEGREE
from gaitsmith.synthesis.point.functions import PointFunctions
from gaitsmith.synthesis.program.transcription import Transcription

Array = npt.NDArray[np.float64]
LocalPiece = tuple[float, float, Array]  # start, duration, coefficients in local order
_ROUNDS = 6
_DONE = 1e-12  # of the robot's weight, or its unit of torque
_RANK = 1e-9  # of the largest singular value: momenta at both ends follow from each other


class _Series(NamedTuple):
    """Chebyshev series on [0, 1]: made once a process, where a sole moves at all.

    Attributes:
        powers: (D + 1, D + 1) from their coefficients to those of 1, s, s² ...
        nodes: (N,) at which the equations of motion are met.
        values: (3, D + 1, N) of every term and two derivatives there.
        sides: (2, 2, D + 1) of every term and its derivative at both ends.
    """

    powers: Array
    nodes: Array
    values: Array
    sides: Array


@cache
def _series() -> _Series:
    degree = ROOT_DEGREE
    nodes = 0.5 - 0.5 * np.cos(np.pi * np.arange(degree - 1) / (degree - 2))
    terms = [np.polynomial.Chebyshev.basis(k, [0, 1]) for k in range(degree + 1)]
    powers = [np.array(np.polynomial.Polynomial.cast(term).coef, dtype=np.float64) for term in terms]
    values = [[term.deriv(d)(nodes) if d else term(nodes) for term in terms] for d in range(3)]
    sides = [[[term.deriv(d)(x) if d else term(x) for term in terms] for d in range(2)] for x in (0.0, 1.0)]
    return _Series(np.concatenate([_padded(row[None]) for row in powers]).T, nodes, np.array(values), np.array(sides))


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


def with_roots(
    trans: Transcription, functions: PointFunctions, pieces: list[list[LocalPiece]]
) -> list[list[LocalPiece]]:
    """All phases' pieces with the motion of support soles solved from the equations of motion."""
    found, phases = list(pieces), trans.motion.phases

    def kind(k: int) -> tuple[bool, bool, str]:
        return phases[k].double, phases[k].flies or phases[k].tips, phases[k].support

    for (double, moves, _), group in groupby(range(len(phases)), kind):
        run = list(group)
        if double or not (moves or trans.layout.leans):
            continue
        borders = set(np.cumsum([len(pieces[k]) for k in run]).tolist())
        solved = iter(_Run(trans, functions, run[0], [piece for k in run for piece in pieces[k]], borders).solved())
        for k in run:
            found[k] = [next(solved) for _ in pieces[k]]
    return found


@dataclass(eq=False)
class _Run:
    """Phases in a row in which a sole moves alike; ``borders``: knots at which phases meet, counted from the start."""

    trans: Transcription
    functions: PointFunctions
    phase: int
    pieces: list[LocalPiece]
    borders: set[int]

    def __post_init__(self) -> None:
        layout, biped = self.trans.layout, self.trans.biped
        phase = self.trans.motion.phases[self.phase]
        self.side = self.trans.motion.phases[self.phase].side
        moves = phase.flies or phase.tips
        self.own = layout.pose + np.arange(layout.poses) if moves else np.array([layout.joints])
        self.rows = np.arange(layout.force, layout.force + 6) if phase.flies else np.array([layout.moment])
        self.rows = np.array([layout.edge]) if phase.tips else self.rows
        self.scale = np.where(self.rows < layout.moment, 1.0 / biped.weight, 1.0 / biped.effort)
        self.pivot = self.trans.pivots[self.phase][:, None]
        self.spans = np.array([span for _, span, _ in self.pieces])
        self.free = [k for k in range(1, len(self.pieces)) if k not in self.borders]

    def solved(self) -> list[LocalPiece]:
        """The pieces with their equations of motion met; what is left shows in the checks."""
        n, spans = self.trans.layout.joints, self.spans
        states = np.array([polynomial(c, np.zeros(1), span)[:, :, 0] for _, span, c in self.pieces])
        states = np.concatenate([states, polynomial(self.pieces[-1][2], np.ones(1), spans[-1])[None, :, :, 0]])
        ends = states[[0, -1]][:, :2, self.own]  # (end, derivative, r)
        padded = np.array([_padded(c)[self.own] for _, _, c in self.pieces])  # (P, r, D + 1)
        series = np.linalg.solve(_series().powers, padded.transpose(2, 0, 1).reshape(len(_series().powers), -1))
        root = series.reshape(len(_series().powers), *padded.shape[:2]).transpose(1, 2, 0)
        for _ in range(_ROUNDS):
            z = self._inputs(states, root)
            o, J = self.functions.differentiate(z, np.tile(self.pivot, (1, z.shape[1])), self.side)
            gap = (o[self.rows] * self.scale[:, None]).T.ravel()  # by node, then row
            left = self._ends(root, ends)
            if max(np.abs(gap).max(), np.abs(left).max()) < _DONE:
                break
            matrix = self._matrix(J[:, self.rows] * self.scale[:, None])
            step = np.linalg.lstsq(matrix, -np.concatenate([gap, left.ravel()]), rcond=_RANK)[0]
            root = root + step[: root.size].reshape(root.shape)
            for k, change in zip(self.free, step[root.size :].reshape(-1, 3, n), strict=True):
                states[k, :, :n] += change / spans[k] ** np.arange(3)[:, None]
        if not np.isfinite(root).all():
            return self.pieces
        return [(a, h, self._whole(states, root, k)) for k, (a, h, _) in enumerate(self.pieces)]

    def _whole(self, states: Array, root: Array, k: int) -> Array:
        """Coefficients (c, ROOT_DEGREE + 1) of a piece, the sole's own from their Chebyshev coefficients."""
        found = _padded(hermite(self.spans[k], *states[k : k + 2]))
        found[self.own] = root[k] @ _series().powers.T
        return found

    def _inputs(self, states: Array, root: Array) -> Array:
        """Inputs (inputs, P * N) at all nodes."""
        z = np.zeros((len(root), self.trans.layout.inputs, len(_series().nodes)))
        for k, h in enumerate(self.spans):
            z[k, : self.trans.layout.wrench] = polynomial(self._whole(states, root, k), _series().nodes, h).reshape(
                -1, len(_series().nodes)
            )
        return z.transpose(1, 0, 2).reshape(self.trans.layout.inputs, -1)

    def _ends(self, root: Array, ends: Array) -> Array:
        """(2 P + 2, r) what is left of places and rates at both ends, and of their continuity in between."""
        rates = self.spans[:, None] ** -np.arange(2.0)  # (P, derivative)
        first, last = ((root @ side.T).transpose(0, 2, 1) * rates[:, :, None] for side in _series().sides)
        return np.concatenate([first[0] - ends[0], last[-1] - ends[1], *(last[:-1] - first[1:])])

    def _matrix(self, slope: Array) -> Array:
        """Derivatives of gaps and ends by the sole's coefficients and the changes of the joints at the free knots."""
        layout, count, r, n = self.trans.layout, len(self.spans), len(self.own), self.trans.layout.joints
        nodes, width = len(_series().nodes), r * len(_series().powers)
        by = slope[:, :, : layout.wrench].reshape(len(slope), r, 3, layout.coordinates)
        found = np.zeros(((count * nodes + 2 * count + 2) * r, count * width + 3 * n * len(self.free)))
        for k, h in enumerate(self.spans):
            here, rows = slice(k * nodes, (k + 1) * nodes), slice(k * nodes * r, (k + 1) * nodes * r)
            tables = _series().values / h ** np.arange(3)[:, None, None]  # (derivative, term, node)
            own = np.einsum("nado,dtn->naot", by[here][..., self.own], tables)
            found[rows, k * width : (k + 1) * width] = own.reshape(nodes * r, width)
            for side in (0, 1):
                if k + side not in self.free:
                    continue
                states = [np.zeros((3, 3)), np.zeros((3, 3))]
                states[side] = np.diag(self.spans[k + side] ** -np.arange(3.0))
                moved = polynomial(hermite(h, *states), _series().nodes, h)  # (derivative, parameter, node)
                first = count * width + 3 * n * self.free.index(k + side)
                changed = np.einsum("nadj,dpn->napj", by[here][..., :n], moved)
                found[rows, first : first + 3 * n] += changed.reshape(nodes * r, 3 * n)
        at = count * nodes * r
        places = [(0, 0, 1.0, 0), (count - 1, 1, 1.0, 1)]  # piece, end, sign, pair of rows
        places += [(k, 1, 1.0, k + 2) for k in range(count - 1)] + [(k + 1, 0, -1.0, k + 2) for k in range(count - 1)]
        for k, side, sign, pair in places:
            block = sign * _series().sides[side] / self.spans[k] ** np.arange(2)[:, None]  # (derivative, term)
            rows = slice(at + 2 * r * pair, at + 2 * r * (pair + 1))
            found[rows, k * width : (k + 1) * width] += np.einsum("dt,ab->dabt", block, np.eye(r)).reshape(2 * r, width)
        return found


def _padded(coefficients: Array) -> Array:
    """Coefficients (c, ROOT_DEGREE + 1) with zeros behind."""
    found = np.zeros((len(coefficients), ROOT_DEGREE + 1))
    found[:, : coefficients.shape[1]] = coefficients
    return found
