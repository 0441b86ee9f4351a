"""Walks on stairs as data: every step one tread further and one rise higher, or lower."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.motions.catalogue import sections_of
from gaitsmith.synthesis.motions.motion import At, Condition, Limit, Motion, Phase, Side, State, opposite
from gaitsmith.synthesis.motions.parameters import StepParameters, record

Array = npt.NDArray[np.float64]
_CLEAR = 0.25  # of the tread's spare length: distance of the swing sole's end from an edge that it has to pass
_SPARE = 0.1  # of the sole's length: least spare length of a tread
_QUARTER = 0.25  # of a swing: until the first edge, and from it to the next


@dataclass(frozen=True)
class _Place:
    """Where a sole stands: which tread, and where in the world, m."""

    tread: int
    x: float
    y: float
    z: float


@dataclass
class _Walk:
    """Phases and conditions, one after the other."""

    biped: Biped
    step: StepParameters
    phases: list[Phase] = field(default_factory=list)
    conditions: list[Condition] = field(default_factory=list)

    def place(self, tread: int, side: Side) -> _Place:
        """A sole in the middle of a tread."""
        half = self.biped.width / 2.0
        z = tread * self.step.rise + self.step.base
        return _Place(tread, tread * self.step.length, half if side == "left" else -half, z)

    def edge(self, tread: int) -> float:
        """Where a tread ends ahead, x, m: midway between the toe on it and the heel on the next."""
        sole = self.biped.sole("left")
        return tread * self.step.length + 0.5 * (self.step.length + sole.toe - sole.heel)

    def at(self, quantity: str, value: float) -> None:
        """A condition at the end of the last phase."""
        self.conditions.append(At(len(self.phases), quantity, value))

    def swing(self, support: Side, stands: int, leaves: int, lands: int) -> None:
        """The other foot from one tread to another, past the edges in between."""
        step, biped, here = self.step, self.biped, self.place(stands, support)
        sole = biped.sole(opposite(support))
        clear = _CLEAR * (step.length - sole.heel - sole.toe)
        single = step.period * (1.0 - step.double_support)
        up = step.rise > 0.0
        level = [k * step.rise + step.base for k in (leaves, max(leaves, min(stands, lands)), lands)]
        first, last = self.edge(leaves), self.edge(lands - 1)
        if up:  # not past an edge before the sole is above the tread behind it
            rows = [
                (_QUARTER, level[0], (Limit("toe_x", high=first - clear),) if lands > leaves else ()),
                (_QUARTER, level[1], (Limit("toe_x", high=last - clear),) if lands > leaves else ()),
                (2.0 * _QUARTER, level[2], ()),
            ]
        else:  # not below a tread before the sole is past its edge
            rows = [
                (2.0 * _QUARTER, level[0], ()),
                (_QUARTER, level[1], (Limit("heel_x", low=first + clear),) if lands > leaves else ()),
                (_QUARTER, level[2], (Limit("heel_x", low=last + clear),) if lands > leaves else ()),
            ]
        top = max(level[0], level[2], here.z) + biped.ankle_height + step.height
        apex = 1 if up else 0
        for k, (share, ground, limits) in enumerate(rows):
            count = sections_of(biped, share * single, False)
            name = ("lift", "swing", "lower")[k]
            self.phases.append(
                Phase(name, share * single, support, "air", (here.x, here.y), None, count, limits, here.z, ground)
            )
            if k == apex:
                self.at("ankle_z", top)
                self.at("ankle_vz", 0.0)

    def transfer(self, support: Side, stands: int, lands: int) -> None:
        """Double support: heel down, flat, and the rear foot on its toe."""
        step, ahead = self.step, opposite(support)
        self.at("foot_pitch", -float(np.sin(step.heel_strike)))
        here, there = self.place(stands, support), self.place(lands, ahead)
        double = step.period * step.double_support
        heel, toe = double * step.heel_share, double * step.toe_share
        count = [sections_of(self.biped, duration, True) for duration in (heel, double - heel - toe, toe)]
        xy, goal = (here.x, here.y), (there.x, there.y)
        self.phases += [
            Phase("heel", heel, support, "heel", xy, goal, count[0], (), here.z, there.z),
            Phase("flat", double - heel - toe, support, "flat", xy, goal, count[1], (), here.z, there.z),
            Phase("toe", toe, ahead, "toe", goal, xy, count[2], (), there.z, here.z),
        ]
        self.at("foot_pitch", float(np.sin(step.toe_off)))

    def shift(self, support: Side, tread: int) -> None:
        """Both feet flat on one tread, at rest at one end of the phase."""
        one, two = self.place(tread, support), self.place(tread, opposite(support))
        phase = Phase("weight shift", self.step.shift, support, "flat", (one.x, one.y), (two.x, two.y), 2)
        self.phases.append(replace(phase, height=one.z, other_height=one.z))

    def motion(self, name: str, cyclic: bool = False) -> Motion:
        """What was put together."""
        return Motion(name, tuple(self.phases), tuple(self.conditions), cyclic, record("stairs", self.step))


def check_stairs(biped: Biped, step: StepParameters) -> None:
    """Refuse treads on which no sole finds room, and robots that are not their mirror image.

    Raises:
        BadInput: naming the flag.
    """
    sole = biped.sole("left")
    least = (1.0 + _SPARE) * (sole.heel + sole.toe)
    if step.length < least:
        raise BadInput("--tread", step.length, f"at least {least:.3g} m: the sole's length and a tenth")
    if not biped.symmetric:
        raise BadInput("robot", biped.robot.card.name, "a robot that is its own mirror image", "for stairs")


def stairs_cycle(biped: Biped, step: StepParameters) -> Motion:
    """One step of a walk on stairs, the right foot as first support."""
    walk = _Walk(biped, step)
    walk.swing("right", 0, -1, 1)
    walk.transfer("right", 0, 1)
    return walk.motion("cyclic", cyclic=True)


def stairs_start(biped: Biped, step: StepParameters, rest: Array, goal: tuple[Array, Array, Array]) -> Motion:
    """From rest on the level to the cyclic walk on stairs: a weight shift and two steps."""
    walk, still = _Walk(biped, step), np.zeros_like(rest)
    walk.conditions.append(State(0, rest, still, still))
    walk.shift("right", 0)
    walk.swing("right", 0, 0, 1)
    walk.transfer("right", 0, 1)
    walk.swing("left", 1, 0, 2)
    walk.transfer("left", 1, 2)
    walk.conditions.append(State(len(walk.phases), *goal))
    return walk.motion("start")


def stairs_stop(biped: Biped, step: StepParameters, rest: Array, begin: tuple[Array, Array, Array]) -> Motion:
    """From the cyclic walk to rest: a last step, one that closes up, and a weight shift."""
    walk, still = _Walk(biped, step), np.zeros_like(rest)
    walk.conditions.append(State(0, *begin))
    walk.swing("right", 0, -1, 1)
    walk.transfer("right", 0, 1)
    walk.swing("left", 1, 0, 1)
    walk.shift("left", 1)
    walk.conditions.append(State(len(walk.phases), rest, still, still))
    return walk.motion("stop")
