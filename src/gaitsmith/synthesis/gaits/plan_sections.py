"""Pieces of a gait as sections of a plan: all tracked quantities as Chebyshev series, relative to the support sole."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from gaitsmith.planned import ContactPhase, PlanTable
from gaitsmith.planned.schedule import BY_CONTACT
from gaitsmith.planned.table import TERMS
from gaitsmith.robots import Robot
from gaitsmith.splines.polynomial import chebyshev, chebyshev_fit
from gaitsmith.synthesis.gaits.full_state import StateFinder
from gaitsmith.synthesis.gaits.gait import Piece, polynomial, root_of

Array = npt.NDArray[np.float64]
_MOTION = 1e-10  # m, rad: a series whose last two terms are larger is fitted again in halves
_EFFORT = 1e-4  # N, N·m: the same for torques and wrenches, of which no derivative is taken
_FINEST = 2e-3  # s
_SAME = 9  # decimals in which the numbers of two sections that count as one agree


class Sections:
    """Sections of a plan, equal ones kept once.

    Args:
        robot: the robot.
        slope: of the ground along x, rad; curves are those of a world whose z is up.
    """

    def __init__(self, robot: Robot, slope: float) -> None:
        self.robot = robot
        self.finder = StateFinder(robot, slope, level=True)
        self.names: dict[str, int] = {}
        self._known: dict[bytes, list[int]] = {}
        self._rows: list[dict[str, Any]] = []
        self._nodes, self._matrix = chebyshev_fit(TERMS)

    def add(
        self,
        contact: ContactPhase,
        piece: Piece,
        stretch: tuple[float, float],
        frame: tuple[Array, ...],
        standing: int,
    ) -> list[int]:
        """Numbers of the sections that a piece becomes.

        Args:
            contact: of the phase that it belongs to.
            piece: the piece.
            stretch: when it begins within its stretch, and the stretch's duration, s.
            frame: the table's weight_from, weight_to and place.
            standing: row of the sole that stands still in the piece; its motion is relative to the contact's support.
        """
        numbers = np.concatenate([[piece.duration, *stretch], *(values.ravel() for values in frame)])
        key = repr(contact).encode() + (np.round(numbers, _SAME) + 0.0).tobytes()
        key += piece.root.tobytes() + piece.joints.tobytes() + piece.torque.tobytes() + piece.wrench.tobytes()
        if key not in self._known:
            first = len(self._rows)
            row = {
                "phase": self.names.setdefault(contact.name, len(self.names)),
                "support": contact.support,
                "contact": contact.contact,
                "by_contact": int(contact.end == BY_CONTACT),
                "stretch_duration": stretch[1],
                **dict(zip(("weight_from", "weight_to", "place"), frame, strict=True)),
            }
            self._fit(row, standing, piece, 0.0, 1.0, stretch[0])
            self._known[key] = list(range(first, len(self._rows)))
        return self._known[key]

    def _fit(self, row: dict[str, Any], standing: int, piece: Piece, low: float, high: float, begin: float) -> None:
        """Fit the part of a piece between two shares of it; in halves if its curves need more terms than there are."""
        motion, effort = self._sampled(standing, row["place"][standing, :3], piece, low, high)
        span = (high - low) * piece.duration
        good = np.abs(motion[-2:]).max() < _MOTION and np.abs(effort[-2:]).max() < _EFFORT
        if good or span < _FINEST:
            start = begin + low * piece.duration
            self._rows.append(row | {"duration": span, "stretch_start": start, "motion": motion, "effort": effort})
            return
        middle = 0.5 * (low + high)
        self._fit(row, standing, piece, low, middle, begin)
        self._fit(row, standing, piece, middle, high, begin)

    def _sampled(self, standing: int, place: Array, piece: Piece, low: float, high: float) -> tuple[Array, Array]:
        """(TERMS, channels) coefficients of motion and effort between two shares of a piece.

        The sole ``standing`` stands at ``place``.
        """
        s = low + (high - low) * self._nodes
        q, v, a = polynomial(piece.joints, s, piece.duration)
        name, root, rows = self.robot.legs[standing].name, root_of(piece, s), list[list[float]]()
        for k in range(len(s)):
            self.finder.find(name, (0.0, 0.0), q[:, k], v[:, k], a[:, k], root[..., k])
            torso = self.finder.data.xmat[self.robot.torso_body].reshape(3, 3)
            numbers = [*(self.finder.centre_of_mass() + place), *_angles(torso)]
            for leg in self.robot.legs:
                sole, _, _, rotation, _, _ = self.finder.foot(leg.name, np.zeros(3))
                numbers += [*(sole + place), *_angles(rotation)]
            rows.append([*numbers, *q[:, k]])
        effort = np.concatenate([chebyshev(values, s) for values in (piece.torque, piece.wrench)])
        return (np.array(rows).T @ self._matrix).T, (effort @ self._matrix).T

    def table(self, sequence: list[int], loop: tuple[int, int, int]) -> PlanTable:
        """The plan that goes through sections in an order, one part of it repeatedly."""
        whole = ("phase", "support", "contact", "by_contact")
        columns: dict[str, Any] = {
            name: np.ascontiguousarray([row[name] for row in self._rows], np.int64 if name in whole else np.float64)
            for name in self._rows[0]
        }
        return PlanTable(np.array(sequence), *loop, **columns)


def _angles(rotation: Array) -> list[float]:
    """Yaw, pitch and roll, turned in this order, rad."""
    return [
        float(np.arctan2(rotation[1, 0], rotation[0, 0])),
        float(np.arctan2(-rotation[2, 0], np.hypot(rotation[2, 1], rotation[2, 2]))),
        float(np.arctan2(rotation[2, 1], rotation[2, 2])),
    ]
