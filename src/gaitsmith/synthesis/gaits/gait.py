"""A planned gait: phases with piecewise polynomials for joints, torques and contact wrenches."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from gaitsmith.splines.polynomial import chebyshev
from gaitsmith.splines.polynomial import polynomial as polynomial
from gaitsmith.synthesis.motions.motion import At, Condition, Limit, Motion, Phase, State, turned
from gaitsmith.synthesis.motions.quantities import QUANTITIES, RATE, of_joint

Array = npt.NDArray[np.float64]
_BORDER = 1e-9  # s: an instant so near before a piece lies in it, however its time was rounded
ROOT_DEGREE = 14
"""Of the polynomials of a support sole that moves: no joint drives it, and its equations of motion have to hold."""
ROLL = 5
"""Of a sole's pose x, y, z, yaw, pitch, roll, the last."""
_Image = tuple[tuple[str, ...], npt.NDArray[np.int64], Array]  # names of joints, partners and signs in the mirror
CHANNELS = 12  # left force, left moment, right force, right moment
_POSE = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])  # mirror image of a pose
_PLACES = ("ankle", "sole", "toe", "heel", "support", "centre", "body")  # what has a place in the world


@dataclass(frozen=True, eq=False)
class Piece:
    """One section of one phase.

    Attributes:
        start: s from the start of the motion.
        duration: s.
        joints: (n, degree + 1) coefficients of 1, s, s² ... of eq. (17), s from 0 to 1 over the section, rad.
        torque: (n, m) Chebyshev coefficients over the section, N·m.
        wrench: (12, m) Chebyshev coefficients of left force and moment, right force and moment; axes of the support
            sole (the world's where nothing turns), about the sole frame's origin, N and N·m.
        root: coefficients of 1, s, s² ... of the support sole's motion: (0, k) where it stands flat, (1, k) of the roll
            of a line sole, rad, (6, k) of a flight's x, y, z (m, from the foothold), yaw, pitch and roll (rad, turned
            in this order); axes of the sole at its foothold.
    """

    start: float
    duration: float
    joints: Array
    torque: Array
    wrench: Array
    root: Array = field(default_factory=lambda: np.zeros((0, 1)))

    @cached_property
    def torque_slope(self) -> Array:
        """(n, m - 1) Chebyshev coefficients of the torques' derivatives, N·m/s."""
        return np.asarray(np.polynomial.chebyshev.chebder(self.torque.T).T * (2.0 / self.duration))


@dataclass(frozen=True, eq=False)
class Gait:
    """A whole gait.

    Attributes:
        robot: name of the robot.
        robot_hash: content hash of card, model and included files.
        joint_names: in the order of the coefficients.
        motion: the phases and conditions it was planned for.
        pieces: per phase, its sections.
        bounds: the bounds it was planned for, as plain numbers.
        order: degree of the splines that were optimised.
        solver: status, iterations, objective, times.
        certificate: worst value of every constraint on the dense grid.
    """

    robot: str
    robot_hash: str
    joint_names: tuple[str, ...]
    motion: Motion
    pieces: tuple[tuple[Piece, ...], ...]
    bounds: dict[str, float]
    order: int
    solver: dict[str, Any] = field(default_factory=dict)
    certificate: dict[str, Any] = field(default_factory=dict)

    @property
    def duration(self) -> float:
        """Length of the motion as stored, s."""
        return float(self.motion.borders[-1])

    def joints(self, phase: int, times: Array) -> tuple[Array, Array, Array]:
        """Angles, velocities and accelerations (n, N) of a phase at times within it, s from the start of the motion."""
        n = len(self.joint_names)
        found = np.zeros((3, n, len(times)))
        for piece, mask, s in self._split(phase, times):
            found[:, :, mask] = polynomial(piece.joints, s, piece.duration)
        return found[0], found[1], found[2]

    def roots(self, phase: int, times: Array) -> Array:
        """(3, 6, N) the support sole's pose and two derivatives as of :func:`root_of`."""
        found = np.zeros((3, 6, len(times)))
        for piece, mask, s in self._split(phase, times):
            found[:, :, mask] = root_of(piece, s)
        return found

    def torques(self, phase: int, times: Array) -> Array:
        """Joint torques (n, N), N·m."""
        return self._series(phase, times, "torque", len(self.joint_names))

    def torque_rates(self, phase: int, times: Array) -> Array:
        """Their derivatives (n, N), N·m/s."""
        found = np.zeros((len(self.joint_names), len(times)))
        for piece, mask, s in self._split(phase, times):
            found[:, mask] = chebyshev(piece.torque_slope, s)
        return found

    @cached_property
    def moving(self) -> npt.NDArray[np.bool_]:
        """(n,) the joints that move."""
        return np.asarray(np.any([p.joints[:, 1:].any(axis=1) for group in self.pieces for p in group], axis=0))

    def wrenches(self, phase: int, times: Array) -> Array:
        """Contact wrenches (12, N): left force, left moment, right force, right moment."""
        return self._series(phase, times, "wrench", CHANNELS)

    def _series(self, phase: int, times: Array, name: str, channels: int) -> Array:
        found = np.zeros((channels, len(times)))
        for piece, mask, s in self._split(phase, times):
            found[:, mask] = chebyshev(getattr(piece, name), s)
        return found

    def _split(self, phase: int, times: Array) -> list[tuple[Piece, npt.NDArray[np.int64], Array]]:
        """Pieces with the times that fall into them and their normalised time."""
        pieces = self.pieces[phase]
        starts = np.array([piece.start for piece in pieces])
        index = np.clip(np.searchsorted(starts - _BORDER, times, side="right") - 1, 0, len(pieces) - 1)
        found = []
        for k, piece in enumerate(pieces):
            mask = np.flatnonzero(index == k).astype(np.int64)
            if len(mask):
                found.append((piece, mask, np.clip((times[mask] - piece.start) / piece.duration, 0.0, 1.0)))
        return found


def root_of(piece: Piece, s: Array) -> Array:
    """(3, 6, N) the support sole's x, y, z, yaw, pitch and roll at normalised times, and two derivatives; 0 if flat."""
    found = np.zeros((3, 6, len(s)))
    found[:, 6 - len(piece.root) :] = polynomial(piece.root, s, piece.duration)
    return found


def unrolled(gait: Gait, partner: npt.NDArray[np.int64], sign: Array, steps: int) -> Gait:
    """A cyclic gait repeated, every second step mirrored; a stride is not, and other gaits are left as they are."""
    if not gait.motion.cyclic or steps == 1:
        return gait
    phases: list[Phase] = []
    pieces: list[tuple[Piece, ...]] = []
    current = gait
    for step in range(steps):
        if step:
            current = follow(current, gait, step % 2 == 1 and gait.motion.mirrored, partner, sign)
        phases += current.motion.phases
        pieces += current.pieces
    motion = replace(gait.motion, phases=tuple(phases), conditions=(), cyclic=False)
    return replace(gait, motion=motion, pieces=tuple(pieces))


def follow(before: Gait, gait: Gait, mirror: bool, partner: npt.NDArray[np.int64], sign: Array) -> Gait:
    """``gait`` moved in time and place, and turned, so that it goes on where ``before`` ends, mirrored if asked."""
    last = before.motion.phases[-1]
    first = gait.motion.phases[0]
    flip = -1.0 if mirror else 1.0
    side = {False: first.support, True: first.other_foot}[mirror]
    held = last.place(side)
    if held is None:
        raise ValueError(f"{before.motion.name} ends with the {side} foot in the air")
    turn = last.facing(side) - flip * first.heading
    dz = (last.height if side == last.support else last.other_height) - first.height
    final = before.pieces[-1][-1]
    dt = final.start + final.duration - gait.pieces[0][0].start

    def placed(place: tuple[float, float]) -> tuple[float, float]:
        x, y = turned((place[0] - first.foothold[0], flip * (place[1] - first.foothold[1])), turn)
        return (held[0] + x, held[1] + y)

    phases, away = [], []
    image = gait.joint_names, partner, sign
    for phase in gait.motion.phases:
        stand = placed(phase.foothold)
        away.append((stand[0] - phase.foothold[0], stand[1] - flip * phase.foothold[1], dz))
        moved_phase = replace(
            phase,
            support=phase.other_foot if mirror else phase.support,
            foothold=stand,
            other=None if phase.other is None else placed(phase.other),
            limits=tuple(_moved_limit(limit, away[-1], flip, image) for limit in phase.limits),
            height=phase.height + dz,
            other_height=phase.other_height + dz,
            heading=flip * phase.heading + turn,
            other_heading=flip * phase.other_heading + turn,
        )
        phases.append(moved_phase)
    swap = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    pieces = []
    for group in gait.pieces:
        moved = []
        for piece in group:
            joints, torque, wrench, root = piece.joints, piece.torque, piece.wrench, piece.root
            if mirror:
                joints, torque = joints[partner] * sign[:, None], torque[partner] * sign[:, None]
                root = root * _POSE[6 - len(root) :, None]
                wrench = np.concatenate([wrench[6:] * swap[:, None], wrench[:6] * swap[:, None]])
            moved.append(Piece(piece.start + dt, piece.duration, joints, torque, wrench, root))
        pieces.append(tuple(moved))
    conditions = tuple(_moved(item, away[max(item.border - 1, 0)], flip, image) for item in gait.motion.conditions)
    motion = replace(gait.motion, phases=tuple(phases), conditions=conditions)
    return replace(gait, motion=motion, pieces=tuple(pieces))


def _moved(item: Condition, away: tuple[float, float, float], flip: float, image: _Image) -> Condition:
    """A condition in another place, and in the mirror image if ``flip`` is -1."""
    if isinstance(item, At):
        quantity, factor = _imaged(item.quantity, flip, image)
        return replace(item, quantity=quantity, value=moved_value(quantity, factor * item.value, away, flip))
    if isinstance(item, State) and flip < 0.0:
        _, partner, sign = image
        states = (item.position, item.velocity, item.acceleration)
        return State(item.border, *(None if values is None else values[partner] * sign for values in states))
    return item


def _imaged(quantity: str, flip: float, image: _Image) -> tuple[str, float]:
    """The same quantity of the joint that takes its joint's place in the mirror image, and the value's factor."""
    joint = of_joint(quantity)
    if joint is None or flip > 0.0:
        return quantity, 1.0
    names, partner, sign = image
    place = int(partner[names.index(joint[0])])
    return f"{names[place]}.{joint[1]}", float(sign[place])


def moved_value(quantity: str, value: float, away: tuple[float, float, float], flip: float) -> float:
    """A quantity's value in another place, and in the mirror image if ``flip`` is -1; a joint's stays."""
    if quantity == RATE or of_joint(quantity) is not None:
        return value
    part, axis, _ = QUANTITIES[quantity]
    turned = axis != 1 if part in ("foot", "torso") else axis == 1  # roll and yaw, and y, change sign
    return value * (flip if turned else 1.0) + (away[axis] if part in _PLACES else 0.0)


def _moved_limit(limit: Limit, away: tuple[float, float, float], flip: float, image: _Image) -> Limit:
    """Bounds in another place, and in the mirror image if ``flip`` is -1."""
    quantity, factor = _imaged(limit.quantity, flip, image)
    ends = (moved_value(quantity, factor * value, away, flip) for value in (limit.low, limit.high))
    return Limit(quantity, *sorted(ends))
