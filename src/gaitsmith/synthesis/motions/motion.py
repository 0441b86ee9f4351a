"""A motion as data: phases in a row, and conditions at the instants between them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from gaitsmith.synthesis.motions.quantities import QUANTITIES, RATE

Side = Literal["left", "right"]
SIDES: tuple[Side, Side] = ("left", "right")
Contact = Literal["air", "flat", "heel", "toe", "flight"]
Array = npt.NDArray[np.float64]


def turned(point: tuple[float, float], angle: float) -> tuple[float, float]:
    """A vector (x, y) turned to the left by an angle, rad."""
    cos, sin = math.cos(angle), math.sin(angle)
    return (cos * point[0] - sin * point[1], sin * point[0] + cos * point[1])


def about_vertical(angle: float) -> Array:
    """(3, 3) rotation to the left, rad."""
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


def opposite(side: Side) -> Side:
    """The other side."""
    return "left" if side == "right" else "right"


@dataclass(frozen=True)
class Limit:
    """Bounds on a quantity of the other foot, the torso or a joint during a phase; of feet and torso sines of angles.

    Positions are those of :attr:`Phase.straight`: the world's, turned about the support sole if that is turned.
    ``quantity`` is one of :data:`QUANTITIES`, or ``NAME.angle``, ``NAME.torque``, …, as in :data:`JOINT_QUANTITIES`,
    or :data:`RATE`.
    """

    quantity: str
    low: float = -np.inf
    high: float = np.inf


@dataclass(frozen=True)
class Phase:
    """A stretch of time with one set of contacts.

    Attributes:
        name: what reports call it.
        duration: s.
        support: the foot that stands flat and still; in flight, the one that left its foothold.
        contact: of the other foot: in the air, flat, or turning about its heel's or its toe's edge; flight: both feet
            are in the air.
        foothold: (x, y) of the support sole, world, m.
        other: (x, y) of the other sole when it lies flat there; None in the air.
        sections: spline sections.
        limits: bounds besides those that hold in every phase.
        height: of the support sole, world, m.
        other_height: of the ground under the other foot: where it stands, or what it may not go below in the air.
        heading: of the support sole, world, rad; to the left.
        other_heading: of the other sole, world, rad; in the air it stays between this one and those before and after.
        support_contact: of the support foot: flat, or turning about its toe's edge while the other foot is in the air.
        between: least and most duration, s, where it is free and chosen for the least objective.
    """

    name: str
    duration: float
    support: Side
    contact: Contact
    foothold: tuple[float, float]
    other: tuple[float, float] | None = None
    sections: int = 1
    limits: tuple[Limit, ...] = ()
    height: float = 0.0
    other_height: float = 0.0
    heading: float = 0.0
    other_heading: float = 0.0
    between: tuple[float, float] | None = None
    support_contact: Literal["flat", "toe"] = "flat"

    @property
    def straight(self) -> Phase:
        """The same with the world turned about the support sole, so that x points along that."""
        if not self.heading:
            return self
        other = self.other
        if other is not None:
            x, y = turned((other[0] - self.foothold[0], other[1] - self.foothold[1]), -self.heading)
            other = (self.foothold[0] + x, self.foothold[1] + y)
        return replace(self, other=other, heading=0.0, other_heading=self.other_heading - self.heading)

    @property
    def bend(self) -> float:
        """Heading of the other sole against the support sole's, rad; in the mirror image if the left foot bears."""
        return self.side * (self.other_heading - self.heading)

    @property
    def stand(self) -> tuple[float, float, float]:
        """(x, y, z) of the support sole, world, m."""
        return (*self.foothold, self.height)

    @property
    def rise(self) -> float:
        """How much higher the ground under the other foot is than that under the support, m."""
        return self.other_height - self.height

    @property
    def double(self) -> bool:
        """Whether both feet carry load."""
        return self.contact not in ("air", "flight")

    @property
    def flies(self) -> bool:
        """Whether no foot is on the ground."""
        return self.contact == "flight"

    @property
    def tips(self) -> bool:
        """Whether the support foot turns about its toe's edge."""
        return self.support_contact == "toe"

    @property
    def other_foot(self) -> Side:
        """The foot that is not the support."""
        return opposite(self.support)

    def steepest(self, most: float) -> float:
        """The largest torque rate here, where ``most`` is that of every phase, N·m/s."""
        return min([most, *(limit.high for limit in self.limits if limit.quantity == RATE)])

    def place(self, foot: Side) -> tuple[float, float] | None:
        """(x, y) of a foot's sole, world, m; None in the air."""
        return self.foothold if foot == self.support else self.other

    def facing(self, foot: Side) -> float:
        """Heading of a foot's sole, world, rad."""
        return self.heading if foot == self.support else self.other_heading

    @property
    def side(self) -> float:
        """+1 with the right foot as support, -1 in the mirror image."""
        return 1.0 if self.support == "right" else -1.0


@dataclass(frozen=True)
class At:
    """A quantity's value at an instant: border ``border`` (0: the start) seen from the phase that ends there."""

    border: int
    quantity: str
    value: float


@dataclass(frozen=True, eq=False)
class State:
    """Joint angles, velocities and accelerations at a border; None leaves one free."""

    border: int
    position: Array | None = None
    velocity: Array | None = None
    acceleration: Array | None = None


@dataclass(frozen=True)
class Same:
    """The joint angles at two borders are equal, or those at one are the mirror image of those at the other."""

    border: int
    other: int
    mirrored: bool = False


@dataclass(frozen=True)
class Unloaded:
    """The other foot bears nothing at a border that ends double support: it can be lifted there."""

    border: int


Condition = At | State | Same | Unloaded


@dataclass(frozen=True)
class Motion:
    """Phases and conditions.

    Attributes:
        name: cyclic, start, stop, walk, kick, or the user's.
        phases: in order of time.
        conditions: at the borders between phases.
        cyclic: the end is the start, one stride further; or its mirror image, one step further, where another foot
            supports.
        parameters: what the motion was made from, for the record.
        total: duration that free phases keep together with the others, s; None if they need not.
        slope: by which the ground, and the world with it, rises along x, rad: its z is the ground's normal.
    """

    name: str
    phases: tuple[Phase, ...]
    conditions: tuple[Condition, ...] = ()
    cyclic: bool = False
    parameters: dict[str, float] = field(default_factory=dict)
    total: float | None = None
    slope: float = 0.0

    @property
    def borders(self) -> Array:
        """(len(phases) + 1,) times of the borders, s."""
        return np.concatenate([[0.0], np.cumsum([phase.duration for phase in self.phases])])

    @property
    def mirrored(self) -> bool:
        """Whether a cyclic motion goes on as its mirror image."""
        return self.cyclic and self.phases[0].support != self.phases[-1].support

    @property
    def steps(self) -> int:
        """Steps that a cyclic motion takes."""
        return 1 if self.mirrored else 2

    @property
    def transfer(self) -> float | None:
        """Duration of a walk's double support, s; None of a motion that is no walk."""
        numbers = self.parameters
        return numbers["period"] * numbers["double_support"] if {"period", "double_support"} <= set(numbers) else None

    @property
    def lift(self) -> float | None:
        """How high a walk raises the ankle, m; None of a motion that is no walk."""
        return self.parameters["height"] if self.transfer is not None and "height" in self.parameters else None

    def bends(self, phase: int) -> tuple[float, float]:
        """Between which headings the other sole is turned in a phase, as :attr:`Phase.bend` counts them, rad."""
        here = self.phases[phase]
        near = [here] if here.double else self.phases[max(phase - 1, 0) : phase + 2]
        found = [item.bend for item in near if item.support == here.support]
        return min(found), max(found)

    @property
    def flies(self) -> bool:
        """Whether both feet leave the ground."""
        return any(phase.flies for phase in self.phases)

    @property
    def placed(self) -> bool:
        """Whether a limit or condition is on the place of the centre of mass or the torso."""
        names = [limit.quantity for phase in self.phases for limit in phase.limits]
        names += [item.quantity for item in self.conditions if isinstance(item, At)]
        parts = ("centre", "centre velocity", "body")
        return any(name in QUANTITIES and QUANTITIES[name].part in parts for name in names)

    @property
    def tips(self) -> bool:
        """Whether a support foot turns about its toe's edge."""
        return any(phase.tips for phase in self.phases)

    def beside_edge(self, phase: int) -> bool:
        """Whether the support foot stands flat in a phase and turns about its edge before or after it."""
        near = self.phases[max(phase - 1, 0) : phase + 2]
        return not self.phases[phase].tips and any(item.tips for item in near)

    def takes_over(self, phase: int) -> bool:
        """Whether a phase of double support begins with all load on the other foot, which turns about its toe."""
        return phase > 0 and self.phases[phase - 1].tips and self.phases[phase].double

    def lifts(self, phase: int) -> bool:
        """Whether the other foot leaves the ground at the start of a phase."""
        return not self.phases[phase].double and (phase == 0 or self.phases[phase - 1].double)

    def lands(self, phase: int) -> bool:
        """Whether the other foot meets the ground at the end of a phase."""
        last = phase == len(self.phases) - 1
        return not self.phases[phase].double and (last or self.phases[phase + 1].double)

    def meets(self, phase: int) -> bool:
        """Whether the other foot's wrench is zero at the start of a phase of double support."""
        if not self.phases[phase].double:
            return False
        if phase == 0 and not self.cyclic:
            return self.phases[0].contact == "heel"
        return not self.takes_over(phase) and not self.phases[phase - 1].double

    def leaves(self, phase: int) -> bool:
        """Whether the other foot's wrench is zero at the end of a phase of double support."""
        if not self.phases[phase].double:
            return False
        if phase == len(self.phases) - 1 and not self.cyclic:
            return self.phases[phase].contact == "toe" or Unloaded(phase + 1) in self.conditions
        return not self.phases[(phase + 1) % len(self.phases)].double
