"""What a page sees of a walk: one row of numbers, by name; written by the loop, read by the page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
import numpy.typing as npt

from gaitsmith.log.columns import Columns

Array = npt.NDArray[np.float64]

CONTACTS = 8
"""Contacts with the ground that a row holds, the strongest ones."""
VITALS = (
    "time",  # simulated, s
    "episode",  # since the page began
    "factor",  # simulated time over wall time, as wished
    "speed",  # the same, as it is
    "ticks",  # paced since the beginning of the episode
    "late",  # of them, more than 1 ms after they were due
    "worst",  # the latest one since the row before, s
    "busy",  # longest tick since the row before, physics and all, s
    "paused",
    "over",  # fallen, stopped by the engine, or at the end of a plan
    "walks",  # whether a walk is asked for, or a plan followed
    "recording",
    "refused",  # wishes that the controller did not take
)


class _Plant(Protocol):
    """What is seen of the physics besides its truth."""

    q: Array
    com: Array

    def ground_forces(self) -> Array: ...


class Frame:
    """One row, laid out; every part is a view of ``row``.

    Args:
        telemetry: names of the controller's numbers and of the truth.
        nq: numbers of the robot's position.
        balls: how many there are.

    Attributes:
        row: (n,) all numbers.
        vitals, telemetry: as :data:`VITALS` and ``telemetry`` name them.
        q: (nq,) true position of the robot.
        com: (3,) true centre of mass, world, m.
        push: (3,) force that pushes the torso, world, N.
        contacts: (8, 6) place and force of contacts with the ground, world; 0 where there is none.
        balls: (k, 3) centres of balls, world, m.
    """

    def __init__(self, telemetry: Sequence[str], nq: int, balls: int) -> None:
        sizes = (len(VITALS), len(telemetry), nq, 3, 3, 6 * CONTACTS, 3 * balls)
        self.row = np.zeros(sum(sizes))
        parts = np.split(self.row, np.cumsum(sizes)[:-1])
        self.vitals, self.telemetry, self.q, self.com, self.push = parts[:5]
        self.contacts, self.balls = parts[5].reshape(CONTACTS, 6), parts[6].reshape(balls, 3)
        self._names = {name: k for k, name in enumerate((*(f"live.{name}" for name in VITALS), *telemetry))}
        self.columns = Columns((VITALS, self.vitals), (tuple(telemetry), self.telemetry))

    def index(self, name: str) -> int:
        """Where a number stands in a row; vitals begin with ``live.``.

        Raises:
            KeyError: there is none of this name.
        """
        return self._names[name]

    def __contains__(self, name: str) -> bool:
        return name in self._names

    def __getitem__(self, name: str) -> float:
        return float(self.row[self._names[name]])

    def fill(self, columns: Columns, plant: _Plant, push: Array, balls: Sequence[Array]) -> None:
        """All but the vitals, as the simulation stands."""
        first = 0
        for buffer in columns.buffers:
            self.telemetry[first : first + len(buffer)] = buffer
            first += len(buffer)
        self.q[:], self.com[:], self.push[:] = plant.q, plant.com, push
        found = plant.ground_forces()
        if len(found) > CONTACTS:
            found = found[np.argsort(-found[:, 5])[:CONTACTS]]
        self.contacts[: len(found)], self.contacts[len(found) :] = found, 0.0
        for place, ball in zip(self.balls, balls, strict=True):
            place[:] = ball
