"""Turns as data: every step lands flat and turned further than the one before, on the spot or along an arc."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.motions.catalogue import sections_of
from gaitsmith.synthesis.motions.motion import (
    At,
    Condition,
    Motion,
    Phase,
    Side,
    State,
    Unloaded,
    opposite,
    turned,
)
from gaitsmith.synthesis.motions.parameters import StepParameters, record

Array = npt.NDArray[np.float64]
_SPARE = 0.05  # of the soles' least distance: by how much they are further apart than they have to be


@dataclass(frozen=True)
class _Foot:
    """Where a sole stands: (x, y), m, and its heading, rad."""

    place: tuple[float, float]
    heading: float


@dataclass
class _Turn:
    """Phases and conditions, one after the other; the outer foot of a turn, ``first``'s opposite, goes first.

    Attributes:
        gap: smallest distance between the soles' edges, m.
        outer: the foot that bears in the first step; the outer one, so that the inner one opens, if None.
    """

    biped: Biped
    step: StepParameters
    gap: float
    outer: Side | None = None
    phases: list[Phase] = field(default_factory=list)
    conditions: list[Condition] = field(default_factory=list)

    @property
    def first(self) -> Side:
        """The foot that bears in the first step."""
        return self.outer or ("right" if self.step.turn > 0.0 else "left")

    def foot(self, count: int, side: Side, wide: bool = True) -> _Foot:
        """A sole after so many steps: beside a path whose heading has changed with each of them."""
        step, sole = self.step, self.biped.sole("left")
        half = 0.5 * self.biped.width
        if wide:  # a sole that turns inward brings its toe or its heel near the other one, and so does an arc
            angle = abs(step.turn)
            least = 2.0 * sole.half_width + self.gap + max(sole.toe, sole.heel) * math.sin(angle)
            least += step.length * math.sin(0.5 * angle)
            half = max(half, (1.0 + _SPARE) * least / (1.0 + math.cos(angle)))
        heading, x, y = count * step.turn, 0.0, 0.0
        for k in range(count):
            dx, dy = turned((step.length, 0.0), (k + 0.5) * step.turn)
            x, y = x + dx, y + dy
        dx, dy = turned((0.0, half if side == "left" else -half), heading)
        return _Foot((x + dx, y + dy), heading)

    def swing(self, support: _Foot, side: Side, leaves: _Foot, lands: _Foot) -> None:
        """The other foot from one place to another, up and down."""
        step, single = self.step, self.step.period * (1.0 - self.step.double_support)
        for name, share, near in (("up", step.swing_split, leaves), ("down", 1.0 - step.swing_split, lands)):
            count = sections_of(self.biped, share * single, False)
            phase = Phase(f"swing {name}", share * single, side, "air", support.place, None, count)
            self.phases.append(self._facing(phase, support, near))
            if name == "up":
                border, top = len(self.phases), self.biped.ankle_height + step.height
                self.conditions += [At(border, "ankle_z", top), At(border, "ankle_vz", 0.0)]

    def transfer(self, support: _Foot, side: Side, landed: _Foot) -> None:
        """Double support on flat soles: the foot that bore until now, then the one that landed, is the support."""
        double = self.step.transfer
        for name, here, other, foot in (
            ("load", support, landed, side),
            ("unload", landed, support, opposite(side)),
        ):
            count = sections_of(self.biped, 0.5 * double, True)
            phase = Phase(name, 0.5 * double, foot, "flat", here.place, other.place, count)
            self.phases.append(self._facing(phase, here, other))

    def shift(self, support: _Foot, side: Side, other: _Foot) -> None:
        """Both feet flat, at rest at one end of the phase."""
        phase = Phase("weight shift", self.step.shift, side, "flat", support.place, other.place, 2)
        self.phases.append(self._facing(phase, support, other))

    @staticmethod
    def _facing(phase: Phase, support: _Foot, other: _Foot) -> Phase:
        return replace(phase, heading=support.heading, other_heading=other.heading)

    def motion(self, name: str, cyclic: bool = False) -> Motion:
        """What was put together."""
        told = record("turn", self.step)
        return Motion(name, tuple(self.phases), tuple(self.conditions), cyclic, told, slope=self.step.slope)


def check_turn(biped: Biped) -> None:
    """Refuse robots whose soles are lines.

    Raises:
        BadInput: naming the robot.
    """
    if biped.lines:
        raise BadInput("robot", biped.robot.card.name, "a robot with soles that have an area", "for turns")


def turn_cycle(biped: Biped, step: StepParameters, gap: float, bears: Side | None = None) -> Motion:
    """Two steps of a turn: the inner foot opens, the outer one follows; it ends as it begins, turned twice.

    Args:
        biped: the robot.
        step: of the turn.
        gap: smallest distance between the soles' edges, m.
        bears: the foot that bears in the first of them; the outer one if None.
    """
    turn = _Turn(biped, step, gap, bears)
    outer, inner = turn.first, opposite(turn.first)
    behind = turn.foot(1, inner)
    here, there, further = turn.foot(2, outer), turn.foot(3, inner), turn.foot(4, outer)
    turn.swing(here, outer, behind, there)
    turn.transfer(here, outer, there)
    turn.swing(there, inner, here, further)
    turn.transfer(there, inner, further)
    return turn.motion("cyclic", cyclic=True)


def turn_start(
    biped: Biped,
    step: StepParameters,
    rest: Array,
    goal: tuple[Array, Array, Array],
    gap: float,
    bears: Side | None = None,
) -> Motion:
    """From rest to the cyclic turn: a weight shift and two steps."""
    turn, still = _Turn(biped, step, gap, bears), np.zeros_like(rest)
    outer, inner = turn.first, opposite(turn.first)
    stand, rises = turn.foot(0, outer, False), turn.foot(0, inner, False)
    one, two = turn.foot(1, inner), turn.foot(2, outer)
    turn.conditions.append(State(0, rest, still, still))
    turn.shift(stand, outer, rises)
    turn.swing(stand, outer, rises, one)
    turn.transfer(stand, outer, one)
    turn.swing(one, inner, stand, two)
    turn.transfer(one, inner, two)
    turn.conditions += [State(len(turn.phases), *goal), Unloaded(len(turn.phases))]
    return turn.motion("start")


def turn_stop(
    biped: Biped,
    step: StepParameters,
    rest: Array,
    begin: tuple[Array, Array, Array],
    gap: float,
    bears: Side | None = None,
) -> Motion:
    """From the cyclic turn to rest: a last step, one that closes up, and a weight shift."""
    turn, still = _Turn(biped, step, gap, bears), np.zeros_like(rest)
    outer, inner = turn.first, opposite(turn.first)
    behind, here, there = turn.foot(1, inner), turn.foot(2, outer), turn.foot(3, inner)
    x, y = turned((0.0, biped.width if outer == "left" else -biped.width), there.heading)
    beside = _Foot((there.place[0] + x, there.place[1] + y), there.heading)
    turn.conditions.append(State(0, *begin))
    turn.swing(here, outer, behind, there)
    turn.transfer(here, outer, there)
    turn.swing(there, inner, here, beside)
    turn.shift(there, inner, beside)
    turn.conditions.append(State(len(turn.phases), rest, still, still))
    return turn.motion("stop")
