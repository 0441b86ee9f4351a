"""A plan as a kernel reads it: sections of time with contacts, and the curves of all tracked quantities.

Every quantity is given relative to the section's support sole: its origin on the ground is the origin, its axes, as it
lies flat, are the axes. A section holds for every repetition of its step, so that a walk of any length is as large as
its different steps.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from gaitsmith.compiled import Cube, IntMatrix, IntVector, Matrix, Vector

TERMS = 10
"""Chebyshev polynomials of a curve."""
COM = 0
"""First of the centre of mass's three coordinates among the motion's channels."""
TORSO = 3
"""First of the torso's three angles: yaw, pitch and roll, turned in this order."""
SOLES = 6
"""First channel of the first sole: position, then yaw, pitch and roll."""
PER_SOLE = 6
"""Channels of a sole; the joints follow the last one."""
ENDLESS = -1
"""Passes of a loop that goes on until the run ends."""


class PlanTable(NamedTuple):
    """A plan of S sections for n soles and nj joints; SI units.

    Attributes:
        sequence: (visits,) sections in order of time.
        loop_first: first visit of the part that is repeated.
        loop_end: the visit after its last one.
        passes: how often it is gone through, 1 or more; ENDLESS.
        duration: (S,) s.
        phase: (S,) number of the phase, for reports.
        support: (S,) row of the sole that stands flat; in flight of the one that did before.
        contact: (S, n) NONE, FLAT, HEEL or TOE.
        by_contact: (S,) 1 where a swinging sole's contact ends the stretch, early or late.
        stretch_start: (S,) time from the beginning of the stretch, that is of all sections with the same soles on the
            ground, to the beginning of the section, s.
        stretch_duration: (S,) s.
        weight_from: (S, n) how far each sole's place decides about the plan's, at the beginning of the stretch; sum 1.
        weight_to: (S, n) the same at its end.
        place: (S, n, 4) where a sole on the ground stands when flat, m, and its heading, rad; zero for one in the air.
        motion: (S, TERMS, 6 + 6 n + nj) Chebyshev coefficients: CoM (m), torso angles (rad), soles (m, rad), joints.
        effort: (S, TERMS, nj + 6 n) joint torques (N·m), force and moment on each sole about its origin (N, N·m).
    """

    sequence: IntVector
    loop_first: int
    loop_end: int
    passes: int
    duration: Vector
    phase: IntVector
    support: IntVector
    contact: IntMatrix
    by_contact: IntVector
    stretch_start: Vector
    stretch_duration: Vector
    weight_from: Matrix
    weight_to: Matrix
    place: Cube
    motion: Cube
    effort: Cube


@dataclass(frozen=True, eq=False)
class Plan:
    """A plan to be followed, with what a run needs to know about it.

    Attributes:
        name: of the motion.
        table: for the kernel.
        phases: names, by the table's phase numbers.
        start: (nq,) and (nv,) state at the beginning, the first support sole's heading along x.
        at_rest: whether it begins and whether it ends at rest.
        duration: of all visits, s; infinite if endless.
        speed: mean forward speed over the loop if there is one, over all else, m/s.
        height: mean height of the CoM above the support sole, m.
        ball: (x, y) of the point that meets the ball and its planned speed (m/s); None without one.
        foot_pitch: largest pitch of a sole at its landing and at its lift-off: strike, off, rad; 0 without one.
    """

    name: str
    table: PlanTable
    phases: tuple[str, ...]
    start: tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]
    at_rest: tuple[bool, bool]
    duration: float
    speed: float
    height: float
    ball: tuple[float, float, float] | None
    foot_pitch: tuple[float, float]

    def way(self, time: float) -> Way:
        """The CoM from where it began, and the support sole's heading, at a time, s, on the plan's own clock."""
        table = self.table
        spans = table.duration[table.sequence]
        once = float(spans[table.loop_first : table.loop_end].sum())
        before = float(spans[: table.loop_first].sum())
        laps = int(max(time - before, 0.0) / once)
        laps = laps if table.passes == ENDLESS else min(laps, table.passes - 1)
        time -= laps * once
        sole, visit = Way(0.0, 0.0, 0.0), 0
        while True:
            if visit == table.loop_first and laps:
                lap = lap_of(table)
                for _ in range(laps):
                    sole = sole.then(lap)
            if visit + 1 == len(spans) or time < spans[visit]:
                break
            time -= spans[visit]
            sole, visit = sole.then(_between(table, visit, visit + 1)), visit + 1
        here, began = sole.then(self._com(visit, min(time / spans[visit], 1.0))), self._com(0, 0.0)
        return Way(here.x - began.x, here.y - began.y, sole.heading)

    def _com(self, visit: int, share: float) -> Way:
        """CoM ahead of and left of the support sole at a share of a visit."""
        series = self.table.motion[self.table.sequence[visit], :, COM : COM + 2]
        found = np.array(np.polynomial.chebyshev.chebval(2.0 * share - 1.0, series))
        return Way(float(found[0]), float(found[1]), 0.0)


class Way(NamedTuple):
    """A place (m) with a heading (rad), seen from another."""

    x: float
    y: float
    heading: float

    def then(self, other: Way) -> Way:
        """Another one that is seen from this one."""
        cos, sin = math.cos(self.heading), math.sin(self.heading)
        x, y = cos * other.x - sin * other.y, sin * other.x + cos * other.y
        return Way(self.x + x, self.y + y, self.heading + other.heading)

    @property
    def ahead(self) -> float:
        """Distance along the mean of both headings, m."""
        return math.cos(0.5 * self.heading) * self.x + math.sin(0.5 * self.heading) * self.y


def _between(table: PlanTable, before: int, visit: int) -> Way:
    """The support sole of a visit from that of the one before."""
    one, two = table.sequence[before], table.sequence[visit]
    x, y, _, heading = table.place[one, table.support[two]].tolist()
    return Way(x, y, heading)


def lap_of(table: PlanTable) -> Way:
    """The first support sole of the loop after one pass, from where it was."""
    found, visits = Way(0.0, 0.0, 0.0), [*range(table.loop_first, table.loop_end), table.loop_first]
    for before, visit in pairwise(visits):
        found = found.then(_between(table, before, visit))
    return found


def empty_table(n_soles: int, n_joints: int) -> PlanTable:
    """The plan of a controller that follows none: one section of standing still."""
    channels = SOLES + PER_SOLE * n_soles + n_joints
    weight = np.zeros((1, n_soles))
    weight[0, 0] = 1.0
    return PlanTable(
        sequence=np.zeros(1, dtype=np.int64),
        loop_first=0,
        loop_end=1,
        passes=1,
        duration=np.ones(1),
        phase=np.zeros(1, dtype=np.int64),
        support=np.zeros(1, dtype=np.int64),
        contact=np.ones((1, n_soles), dtype=np.int64),
        by_contact=np.zeros(1, dtype=np.int64),
        stretch_start=np.zeros(1),
        stretch_duration=np.ones(1),
        weight_from=weight,
        weight_to=weight.copy(),
        place=np.zeros((1, n_soles, 4)),
        motion=np.zeros((1, TERMS, channels)),
        effort=np.zeros((1, TERMS, n_joints + PER_SOLE * n_soles)),
    )
