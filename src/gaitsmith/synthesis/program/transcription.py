"""From a motion to a nonlinear program: the unknowns, the points, and the linear maps between them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from gaitsmith.splines.joint_spline import JointSpline, quadrature
from gaitsmith.splines.polynomial import bernstein
from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.motions.motion import Motion
from gaitsmith.synthesis.motions.settings import Settings
from gaitsmith.synthesis.point.layout import layout_of
from gaitsmith.synthesis.program.bounds import PhaseBound, phase_bounds
from gaitsmith.synthesis.program.margin import drawn_in
from gaitsmith.synthesis.program.rows import BoundRows, Rows

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]
WRENCH_DEGREE = 3
_KEPT = 5000  # points of which the map is remembered
SOON = 4e-3  # share of a phase in which a foot takes over the load, after which it bears enough to be looked at
_UNIT = np.eye(WRENCH_DEGREE + 1)


@dataclass(frozen=True)
class Points:
    """Instants at which the dynamics are evaluated.

    Attributes:
        phase: (K,) index of the phase.
        section: (K,) index of the spline section.
        time: (K,) s from the start of the motion.
        weight: (K,) s, of the integral (16); 0 for added points.
        control: (K,) which Bernstein coefficient of u such a point has as its wrench; -1: u at its time.
    """

    phase: Indices
    section: Indices
    time: Array
    weight: Array
    control: Indices

    @property
    def count(self) -> int:
        """Number of points K."""
        return len(self.time)

    def places(self) -> dict[tuple[int, float], int]:
        """Which point lies at a time of a phase, to 1 ns."""
        times = zip(self.phase.tolist(), self.time.tolist(), self.control.tolist(), strict=True)
        return {(phase, round(time, 9)): k for k, (phase, time, control) in enumerate(times) if control < 0}

    def keys(self) -> Indices:
        """(K,) what tells apart, to 1 ns, the instants of all phases; negative where a point is none."""
        return np.where(self.control < 0, instant_keys(self.phase, self.time), -1)

    def find(self, phases: Indices, times: Array) -> Indices:
        """(N,) which points lie at times of phases; all of them are there."""
        keys = self.keys()
        order = np.argsort(keys, kind="stable")
        # of several at the same instant the last one
        return order[np.searchsorted(keys[order], instant_keys(phases, times), side="right") - 1]

    def with_(self, more: Points) -> Points:
        """These and more of them."""
        return Points(*(np.concatenate(pair) for pair in zip(vars(self).values(), vars(more).values(), strict=True)))


def instant_keys(phases: Indices, times: Array) -> Indices:
    """(N,) one number for a phase and a time, to 1 ns."""
    return (np.asarray(phases, dtype=np.int64) << 44) + np.rint(times * 1e9).astype(np.int64)


def flights_of(motion: Motion) -> list[list[int]]:
    """Phases in a row with both feet in the air."""
    grouped = groupby(range(len(motion.phases)), lambda k: motion.phases[k].flies)
    return [list(group) for flies, group in grouped if flies]


def tips_of(motion: Motion) -> list[list[int]]:
    """Phases in a row in which the support foot turns about its toe's edge."""
    grouped = groupby(range(len(motion.phases)), lambda k: motion.phases[k].tips)
    return [list(group) for tips, group in grouped if tips]


class Transcription:
    """Unknowns x of a motion and their linear maps to the points.

    x holds the control points of the splines, joint by joint and lean by lean, then for every phase of double support
    the Bernstein coefficients of u in units of the robot's weight (N and N·m), then for every flight the control points
    of the support sole's pose, coordinate by coordinate, in the local frame.

    Attributes:
        biped, motion, settings: what was given.
        spline: of every joint and lean.
        size: number of unknowns.
        bounds: per phase, every bound that holds throughout it.
        rows: what they are as rows of a program.
        pivots: (phases, 3) of the other sole, in its frame, local; on slopes gravity behind it, m/s².
    """

    def __init__(self, biped: Biped, motion: Motion, settings: Settings) -> None:
        self.biped, self.motion, self.settings = biped, motion, settings
        self.layout = layout_of(biped)
        self.borders = motion.borders
        knots, self.first_section = [0.0], []
        for phase, start in zip(motion.phases, motion.borders, strict=False):
            self.first_section.append(len(knots) - 1)
            knots += [start + phase.duration * (k + 1) / phase.sections for k in range(phase.sections)]
        self.spline = JointSpline(np.array(knots), settings.order)
        self.phase_of_section = [i for i, phase in enumerate(motion.phases) for _ in range(phase.sections)]
        self._wrench_first: dict[int, int] = {}
        size = biped.channels * self.spline.size
        for index, phase in enumerate(motion.phases):
            if phase.double:
                self._wrench_first[index] = size
                size += 6 * (WRENCH_DEGREE + 1)
        self.flights: dict[int, tuple[int, JointSpline, int]] = {}  # by phase: first section, spline, first unknown
        for run in flights_of(motion) + tips_of(motion):
            first, end = self.first_section[run[0]], self.first_section[run[-1]] + motion.phases[run[-1]].sections
            own = JointSpline(np.array(knots[first : end + 1]), settings.order)
            self.flights |= dict.fromkeys(run, (first, own, size))
            size += self.layout.poses * own.size
        self.size = size
        # What one program after another has in common.
        self.rates: dict[tuple[int, float], tuple[list[tuple[int, float]], Array]] = {}
        self.fixed: Rows | None = None
        self.smooth: sp.csr_matrix | None = None
        self.maps: dict[int, sp.csr_matrix] = {}  # to the knots of a phase
        self._maps: dict[tuple[int, int, float, int], tuple[Array, Indices, Indices]] = {}
        self.limits: list[list[PhaseBound]] = [
            phase_bounds(biped, settings.bounds, motion, index) for index in range(len(motion.phases))
        ]
        self.bounds: list[list[PhaseBound]] = [
            drawn_in(items, biped, motion, index) for index, items in enumerate(self.limits)
        ]
        self.rows = BoundRows(self.bounds)
        self.pivots = np.array([biped.pivot(phase) * (1.0, phase.side, 1.0) for phase in motion.phases])
        if biped.slopes:
            fall = float(np.linalg.norm(biped.model.opt.gravity))
            down = fall * np.array([-np.sin(motion.slope), 0.0, -np.cos(motion.slope)])
            self.pivots = np.hstack([self.pivots, np.tile(down, (len(motion.phases), 1))])

    def pose_rows(self, phase: int, time: float, derivative: int) -> sp.csr_matrix:
        """(poses, size) map from x to the pose of a support sole that moves, or to a derivative, at a time."""
        data, rows, columns = self._pose(
            phase, int(self.instants(phase, np.array([time])).section[0]), time, derivative
        )
        return sp.csr_matrix((data, (rows, columns)), shape=(self.layout.poses, self.size))

    def _pose(self, phase: int, section: int, time: float, derivative: int) -> tuple[Array, Indices, Indices]:
        """Values, rows and columns of that map."""
        first, own, start = self.flights[phase]
        row, coordinate = own.row(section - first, time, derivative), np.arange(self.layout.poses)
        columns = start + own.size * coordinate[:, None] + own.first(section - first) + np.arange(own.degree + 1)
        return np.tile(row, len(coordinate)), np.repeat(coordinate, own.degree + 1), columns.ravel()

    def points(self) -> Points:
        """Gauss-Lobatto points of every section; a knot inside a phase is one point."""
        phase: list[int] = []
        section: list[int] = []
        time: list[float] = []
        weight: list[float] = []
        for index, item in enumerate(self.motion.phases):
            nodes, weights = quadrature(self.settings.double_nodes if item.double else self.settings.single_nodes)
            for k in range(item.sections):
                number = self.first_section[index] + k
                a, b = self.spline.knots[number], self.spline.knots[number + 1]
                for node, w in zip(nodes, weights, strict=True):
                    if k and node == 0.0:
                        weight[-1] += w * (b - a)
                        continue
                    phase.append(index)
                    section.append(number)
                    time.append(a + (b - a) * node)
                    weight.append(w * (b - a))
        found = Points(np.array(phase), np.array(section), np.array(time), np.array(weight), np.full(len(time), -1))
        ends = [
            (index, k) for index, item in enumerate(self.motion.phases) if item.double for k in self._vanishing(index)
        ]
        soon = np.array([k for k in range(len(self.motion.phases)) if self.motion.takes_over(k)], dtype=np.int64)
        found = found.with_(self.instants(soon, self.borders[soon] + SOON * np.diff(self.borders)[soon]))
        phases, controls = np.array(ends, dtype=np.int64).reshape(-1, 2).T
        return found.with_(replace(self.instants(phases, self.borders[phases + (controls > 1)]), control=controls))

    def _vanishing(self, phase: int) -> list[int]:
        """Coefficients next to an end of a phase at which u is zero: what its direction tends to there."""
        return [1] * self.motion.meets(phase) + [WRENCH_DEGREE - 1] * self.motion.leaves(phase)

    def nodes(self, phase: int, section: int) -> Array:
        """Times of the Gauss-Lobatto points of a section of a phase, s."""
        a, b = self.spline.knots[section : section + 2]
        return np.asarray(a + (b - a) * quadrature(self.nodes_in(phase))[0])

    def nodes_in(self, phase: int) -> int:
        """How many there are in a section of a phase."""
        return self.settings.double_nodes if self.motion.phases[phase].double else self.settings.single_nodes

    def instants(self, phases: Indices | int, times: Array) -> Points:
        """Points without weight at times (K,) in phases, (K,) or one for all; a border belongs to either phase."""
        phase = np.broadcast_to(phases, times.shape).astype(np.int64)
        first = np.array(self.first_section)[phase]
        last = first + np.array([item.sections for item in self.motion.phases])[phase] - 1
        section = np.clip(np.searchsorted(self.spline.knots, times, side="right") - 1, first, last)
        return Points(phase, section, times, np.zeros(len(times)), np.full(len(times), -1))

    def share(self, phases: Indices | int, times: Array) -> Array:
        """Normalised times in their phases, 0 to 1."""
        return np.asarray(np.clip((times - self.borders[phases]) / np.diff(self.borders)[phases], 0.0, 1.0))

    def wrench_columns(self, phase: int) -> Indices:
        """(6, 4) unknowns that hold the Bernstein coefficients of u in a phase of double support."""
        return self._wrench_first[phase] + np.arange(24).reshape(6, 4)

    def joint_columns(self, joint: int, section: int) -> Indices:
        """Unknowns that a joint's spline depends on in a section."""
        start = joint * self.spline.size + self.spline.first(section)
        return np.arange(start, start + self.spline.degree + 1)

    def state_rows(self, border: int, derivative: int) -> sp.csr_matrix:
        """(joints + leans, size) map from x to these or a derivative at a border, in the robot's order."""
        t = float(self.borders[border])
        section = self.first_section[border] if border < len(self.first_section) else len(self.spline.knots) - 2
        row = self.spline.row(section, t, derivative)
        n = self.biped.channels
        columns = np.concatenate([self.joint_columns(joint, section) for joint in range(n)])
        rows = np.repeat(np.arange(n), len(row))
        return sp.csr_matrix((np.tile(row, n), (rows, columns)), shape=(n, self.size))

    def input_map(self, points: Points) -> sp.csr_matrix:
        """(K * inputs, size) map from x to the inputs of all points, each in its phase's local frame."""
        inputs = self.layout.inputs
        places = (points.phase, points.section, points.time, points.control)
        found = [self._inputs_of(*item) for item in zip(*(values.tolist() for values in places), strict=True)]
        data, rows, columns = (np.concatenate([item[k] for item in found]) for k in range(3))
        rows = rows + np.repeat(inputs * np.arange(points.count), [len(item[0]) for item in found])
        return sp.csr_matrix((data, (rows, columns)), shape=(points.count * inputs, self.size))

    def _inputs_of(self, index: int, section: int, t: float, control: int) -> tuple[Array, Indices, Indices]:
        """Values, rows and columns of one point's part of the map; kept."""
        kept = self._maps.get((index, section, t, control))
        if kept is not None:
            return kept
        layout, n, phase = self.layout, self.biped.channels, self.motion.phases[index]
        width, local = self.spline.degree + 1, np.arange(n)
        # Local joint j is the robot's joint j, or its partner's mirror image.
        source, sign = (local, np.ones(n)) if phase.side > 0 else self.biped.image
        starts = source * self.spline.size + self.spline.first(section)
        data, rows, columns = [], [], []
        for derivative in range(3):
            data.append((sign[:, None] * self.spline.row(section, t, derivative)).ravel())
            rows.append(np.repeat(derivative * layout.coordinates + local, width))
            columns.append((starts[:, None] + np.arange(width)).ravel())
            if index in self.flights:
                values, pose, places = self._pose(index, section, t, derivative)
                data.append(values)
                rows.append(derivative * layout.coordinates + layout.pose + pose)
                columns.append(places)
        if phase.double:
            s = min(max((t - self.borders[index]) / phase.duration, 0.0), 1.0)
            shares = bernstein(WRENCH_DEGREE, s) if control < 0 else _UNIT[control]
            data.append(np.tile(self.biped.weight * shares, 6))
            rows.append(np.repeat(layout.wrench + np.arange(6), WRENCH_DEGREE + 1))
            columns.append(self.wrench_columns(index).ravel())
        found = np.concatenate(data), np.concatenate(rows), np.concatenate(columns)
        if len(self._maps) < _KEPT:
            self._maps[index, section, t, control] = found
        return found
