"""A phase of a gait over stretches of time: everything that is bounded, as Taylor models that hold at all instants."""

from __future__ import annotations

from dataclasses import dataclass
from math import comb, factorial
from typing import Any

import numpy as np
import numpy.typing as npt

from gaitsmith.synthesis.gaits.gait import Gait
from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.motions.motion import about_vertical
from gaitsmith.synthesis.proof.dynamics import BodyMotion, EnclosedRobot
from gaitsmith.synthesis.proof.quantities import Measured
from gaitsmith.synthesis.proof.taylor import DEGREE, Taylor, cross

Array = npt.NDArray[np.float64]
_GAMMA = 1e-14  # 90 units in the last place
_UNIT = 2.0**-53
_FIRST = 0.02  # s: of the first stretches


@dataclass(frozen=True, eq=False)
class Stretch:
    """A part of a section of a phase: its number there, and where it begins and ends in it, 0 to 1."""

    section: int
    begin: float
    end: float

    def halves(self) -> tuple[Stretch, Stretch]:
        """Both halves."""
        middle = 0.5 * (self.begin + self.end)
        return Stretch(self.section, self.begin, middle), Stretch(self.section, middle, self.end)


@dataclass(frozen=True, eq=False)
class Enclosed:
    """A phase over N stretches.

    Attributes:
        measured: what bounds are about.
        residual: (6 + n, N) of the equations of motion, N and N·m.
        contacts: place less its goal, velocity and acceleration of every point of the other foot that is in contact.
        loads: force (bodies, 3) and moment about the world's origin (bodies, 3) that each body's motion takes.
        middles, spans: (N,) times of the stretches, s.
    """

    measured: Measured
    residual: Taylor
    contacts: list[tuple[Taylor, Taylor, Taylor]]
    loads: tuple[Taylor, Taylor]
    middles: Array
    spans: Array


def enclose(gait: Gait, biped: Biped, engine: EnclosedRobot, index: int, stretches: list[Stretch]) -> Enclosed:
    """A phase over stretches of it.

    Args:
        gait: the gait.
        biped: the robot with all its joints.
        engine: its equations.
        index: of the phase.
        stretches: which.
    """
    phase, pieces = gait.motion.phases[index].straight, gait.pieces[index]
    count = len(stretches)
    joints = len(gait.joint_names)
    q, v, a, torque, rate, wrench, *pose = (_Rows(width, count) for width in (*(5 * (joints,)), 12, 6, 6, 6))
    middles, spans = np.zeros(count), np.zeros(count)
    for number in sorted({item.section for item in stretches}):
        piece = pieces[number]
        mask = np.array([k for k, item in enumerate(stretches) if item.section == number])
        middle = np.array([0.5 * (stretches[k].begin + stretches[k].end) for k in mask])
        half = np.array([0.5 * (stretches[k].end - stretches[k].begin) for k in mask])
        whole = np.zeros((6, piece.root.shape[1]))
        whole[6 - len(piece.root) :] = piece.root
        for table, derivatives in ((piece.joints, (q, v, a)), (whole, pose)):
            for order, rows in enumerate(derivatives if table.any() else ()):
                rows.put(mask, *_shifted(table, middle, half), 1.0 / piece.duration**order)
                table = table[:, 1:] * np.arange(1, table.shape[1]) if table.shape[1] > 1 else 0.0 * table
        torque.put(mask, *_series(piece.torque, middle, half), 1.0)
        rate.put(mask, *_series(piece.torque_slope, middle, half), 1.0)
        wrench.put(mask, *_series(piece.wrench, middle, half), 1.0)
        middles[mask], spans[mask] = piece.start + middle * piece.duration, 2.0 * half * piece.duration
    states = q.taylor, v.taylor, a.taylor
    moving = [rows.taylor for rows in pose] if biped.lines or phase.flies or phase.tips else None
    motions = engine.motions(phase.support, phase.stand, *states, moving)
    both = {"left": (wrench.taylor[0:3], wrench.taylor[3:6]), "right": (wrench.taylor[6:9], wrench.taylor[9:12])}
    loads = engine.inertial(motions)
    residual = engine.residual(motions, loads, both, states, torque.taylor)
    measured, contacts = _measured(
        gait, biped, engine, index, motions, states, (torque.taylor, rate.taylor), both, middles, spans
    )
    return Enclosed(measured, residual, contacts, loads, middles, spans)


def first_stretches(gait: Gait, index: int, longest: float = _FIRST) -> list[Stretch]:
    """A phase's sections in equal parts of at most ``longest`` s, an even number each."""
    found = []
    for number, piece in enumerate(gait.pieces[index]):
        parts = 2 * max(1, int(np.ceil(piece.duration / longest / 2.0)))
        found += [Stretch(number, k / parts, (k + 1) / parts) for k in range(parts)]
    return found


class _Rows:
    """Taylor models that are filled section by section."""

    def __init__(self, width: int, count: int) -> None:
        self.taylor = Taylor(np.zeros((DEGREE + 1, width, count)), np.zeros((width, count)))

    def put(self, mask: npt.NDArray[np.int64], coefficients: Array, radius: Array, scale: float) -> None:
        self.taylor.c[:, :, mask] = coefficients * scale
        self.taylor.r[:, mask] = (radius + _GAMMA * np.abs(coefficients).sum(axis=0)) * scale * (1.0 + _GAMMA)


def _shifted(table: Array, middle: Array, half: Array) -> tuple[Array, Array]:
    """Coefficients (DEGREE + 1, n, N) and radii (n, N) of polynomials (n, k) of s with s = middle + half σ."""
    count = table.shape[1]
    found, sizes = np.zeros((count, len(table), len(middle))), np.zeros((len(table), len(middle)))
    for power in range(count):
        for k in range(power + 1):
            term = table[:, power, None] * (comb(power, k) * middle ** (power - k) * half**k)
            found[k] += term
            sizes += np.abs(term)
    kept = np.zeros((DEGREE + 1, *found.shape[1:]))
    kept[: min(count, DEGREE + 1)] = found[: DEGREE + 1]
    return kept, np.abs(found[DEGREE + 1 :]).sum(axis=0) + _GAMMA * (count + 1) * sizes


def _series(table: Array, middle: Array, half: Array) -> tuple[Array, Array]:
    """Coefficients (DEGREE + 1, n, N) and radii (n, N) of Chebyshev series (n, m) on s from 0 to 1.

    Taylor's at the stretch's middle: derivatives are series again, whose sum of sizes bounds what is left out.
    """
    terms = max(table.shape[1], 1)
    x = 2.0 * middle - 1.0
    basis = np.polynomial.chebyshev.chebvander(x, terms - 1).T  # (m, N)
    wrong = _UNIT * 8.0 * (1.0 + np.arange(terms)) ** 2  # of the basis, by its recursion
    slope = np.zeros((terms, terms))  # of the basis: T_k' as a series
    for k in range(1, terms):
        slope[k - 1 :: -2, k] = 2.0 * k
        if k % 2:
            slope[0, k] = float(k)
    found, radius = np.zeros((DEGREE + 1, len(table), len(middle))), np.zeros((len(table), len(middle)))
    now, sizes = table, np.abs(table)
    for k in range(DEGREE + 2):
        scale = (2.0 * half) ** k / factorial(k)
        if k > DEGREE:
            radius += sizes.sum(axis=1)[:, None] * scale * (1.0 + 1e-9)
            break
        found[k] = now @ basis * scale
        radius += (sizes @ (wrong + _GAMMA * (k + terms)))[:, None] * scale
        now, sizes = now @ slope.T, sizes @ slope.T
    return found, radius


def _measured(
    gait: Gait,
    biped: Biped,
    engine: EnclosedRobot,
    index: int,
    motions: dict[int, BodyMotion],
    states: tuple[Taylor, Taylor, Taylor],
    torques: tuple[Taylor, Taylor],
    both: dict[str, tuple[Taylor, Taylor]],
    middles: Array,
    spans: Array,
) -> tuple[Measured, list[tuple[Taylor, Taylor, Taylor]]]:
    """The phase's numbers, and its other foot's contacts."""
    phase, robot = gait.motion.phases[index].straight, biped.robot
    leg, pivot = biped.leg(phase.other_foot), biped.pivot(phase)
    foot, torso = motions[leg.sole_body], motions[robot.torso_body]
    stands = biped.leg(phase.support)
    own = motions[stands.sole_body]

    def point(x: Array) -> tuple[Taylor, Taylor, Taylor]:
        """Of the other sole, in its frame."""
        return foot.point(leg.sole_position + leg.sole_rotation @ x)

    rotation = foot.rotation.by(leg.sole_rotation)
    push, turn = both[phase.other_foot]
    contacts = []
    if phase.double:
        assert phase.other is not None
        for x, y in biped.corners(phase.contact, phase.other_foot).tolist():
            place, speed, pull = point(np.array([x, y, 0.0]))
            goal = about_vertical(phase.other_heading) @ (x, y, 0.0) + (*phase.other, phase.other_height)
            contacts.append((place - goal[:, None], speed, pull))
    if phase.tips:
        for x, y in biped.corners("toe", phase.support).tolist():
            place, speed, pull = own.point(stands.sole_position + stands.sole_rotation @ np.array([x, y, 0.0]))
            contacts.append((place - np.add(phase.stand, (x, y, 0.0))[:, None], speed, pull))
    ankle, ankle_speed, _ = foot.point(np.zeros(3))
    share = np.zeros((DEGREE + 1, len(middles)))
    share[0] = (middles - gait.motion.borders[index]) / phase.duration
    share[1] = 0.5 * spans / phase.duration
    clock = Taylor(share, np.full(len(middles), 1e-12))
    hip = torso.place + torso.rotation.by(robot.hip_midpoint)
    force, moment = both[phase.support]
    found = Measured(
        *(*states, *torques, gait.moving),
        *(force, moment, push, turn - cross(rotation.by(pivot), push)),
        *(point(pivot)[0], rotation, torso.rotation, hip[2] - phase.height, ankle, ankle_speed),
        *(own.point(stands.sole_position)[0], own.rotation.by(stands.sole_rotation), torso.place),
        centre=lambda: engine.centre(motions),
        profile=lambda lifts, lands: _profile(clock, lifts, lands),
    )
    return found, contacts


def _profile(clock: Taylor, lifts: bool, lands: bool) -> Any:
    """The swing's profile; in a stretch around its top the top."""
    rate = 2.0 if lifts and lands else 1.0
    one = Taylor.constant(np.array(1.0), clock.shape[-1])
    if not (lifts or lands):
        return one
    up, down = clock * rate, (one - clock) * rate
    middle, reach = clock.c[0], np.abs(clock.c[1])
    rising = np.full_like(middle, lifts, dtype=bool) & ((middle + reach <= 0.5 + 1e-9) | (not lands))
    falling = np.full_like(middle, lands, dtype=bool) & ((middle - reach >= 0.5 - 1e-9) | (not lifts)) & ~rising
    x = Taylor(np.where(rising, up.c, np.where(falling, down.c, one.c)), np.where(rising | falling, up.r + down.r, 0.0))
    return x * x * x * ((x * x) * 6.0 - x * 15.0 + 10.0)
