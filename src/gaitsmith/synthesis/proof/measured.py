"""A phase of a gait at instants, by MuJoCo's kinematics and inverse dynamics alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from gaitsmith.synthesis.gaits.full_state import StateFinder
from gaitsmith.synthesis.gaits.gait import Gait
from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.motions.motion import about_vertical
from gaitsmith.synthesis.proof.quantities import Measured, about_toe, along_sole

Array = npt.NDArray[np.float64]
CLOSURE = ("position_mm", "velocity", "acceleration")
_Foot = tuple[Array, ...]  # as StateFinder.foot gives it


@dataclass(eq=False)
class Errors:
    """How far a file's numbers are from physics: the largest of all instants; NaN if any is.

    Attributes:
        closure: of the contact points in double support: mm, m/s, m/s².
        residual: of the equations of motion, of the weight.
        edge: moment about an edge that a foot turns about, or about a line sole's line, of weight times height.
        air: wrench on feet in the air, of the weight.
    """

    closure: dict[str, float] = field(default_factory=lambda: dict.fromkeys(CLOSURE, 0.0))
    residual: float = 0.0
    edge: float = 0.0
    air: float = 0.0


def larger(one: float, two: float) -> float:
    """The larger number; NaN if either is."""
    return float(np.maximum(one, two))


def smaller(one: float, two: float) -> float:
    """The smaller number; NaN if either is."""
    return float(np.minimum(one, two))


def rise(s: Array, lifts: bool, lands: bool) -> Array:
    """The swing's profile at shares (N,) of its phase: 10 s³ - 15 s⁴ + 6 s⁵ up, and down, to 1 in between."""
    rate = 2.0 if lifts and lands else 1.0
    up = np.clip(rate * s, 0.0, 1.0) if lifts else np.ones_like(s)
    down = np.clip(rate * (1.0 - s), 0.0, 1.0) if lands else np.ones_like(s)
    return np.minimum(*(x**3 * (10.0 - 15.0 * x + 6.0 * x**2) for x in (up, down)))


def measure(gait: Gait, biped: Biped, finder: StateFinder, index: int, times: Array, errors: Errors) -> Measured:
    """A phase's numbers (N,) at times within it; errors are added to ``errors``."""
    phase = gait.motion.phases[index].straight
    q, v, a = gait.joints(index, times)
    root = gait.roots(index, times)
    torque, wrench = gait.torques(index, times), gait.wrenches(index, times)
    support, other = (wrench[6:], wrench[:6]) if phase.support == "right" else (wrench[:6], wrench[6:])
    pivot = biped.pivot(phase)
    toe = np.array([(x, y, 0.0) for x, y in biped.corners("toe", phase.support)]).T if phase.tips else None
    leg, robot = biped.leg(phase.other_foot), biped.robot
    heel = -leg.sole_rotation.T @ leg.sole_position
    if phase.double:
        assert phase.other is not None
        corners = np.array([(x, y, 0.0) for x, y in biped.corners(phase.contact, phase.other_foot)]).T
        goals = about_vertical(phase.other_heading) @ corners + np.array([*phase.other, phase.other_height])[:, None]
    feet, bearing, trunk, left = list[_Foot](), list[_Foot](), list[_Foot](), list[Array]()
    for k, state in enumerate(zip(q.T, v.T, a.T, np.moveaxis(root, -1, 0), strict=True)):
        finder.find(phase.support, phase.stand, *state)
        feet.append(finder.foot(phase.other_foot, heel))
        bearing.append(finder.foot(phase.support, np.zeros(3)))
        trunk.append((*finder.body(robot.torso_body), finder.centre_of_mass(), finder.centre_velocity()))
        left.append(finder.residual(torque[:, k], wrench[:, k]))
    errors.residual = larger(errors.residual, np.abs(left).max(initial=0.0) / biped.weight)
    ankle, swing, _, rotation, *_ = moved = _stacked(feet)
    own, _, _, level, *_ = stood = _stacked(bearing)
    body, torso, *centre = _stacked(trunk)
    rows: dict[str, Any] = {"ankle": ankle, "ankle_velocity": swing, "rotation": rotation, "own": own, "level": level}
    rows |= {"pivot": ankle + np.einsum("ijn,j->in", rotation, pivot - heel), "body": body, "torso": torso}
    rows["hip"] = body[2] + np.einsum("jn,j->n", torso[2], robot.hip_midpoint) - phase.height
    if toe is not None:
        _closure(errors, toe, toe + np.array(phase.stand)[:, None], stood)
    if phase.double:
        _closure(errors, corners - heel[:, None], goals, moved)
    rows["turn"] = other[3:] - _cross(np.einsum("ijn,j->in", rows["rotation"], pivot), other[:3])
    if not phase.double:
        lifted = np.abs(wrench if phase.flies else other).max(initial=0.0)
        errors.air = larger(errors.air, lifted / biped.weight)
    elif phase.contact != "flat":
        about = along_sole(rows["turn"], phase.other_heading)[1]
        errors.edge = larger(errors.edge, np.abs(about).max(initial=0.0) / biped.effort)
    if biped.lines:
        about = along_sole(rows["turn"], phase.other_heading)[0]
        errors.edge = larger(errors.edge, np.abs([support[3], about]).max(initial=0.0) / biped.effort)
    share = (times - gait.motion.borders[index]) / phase.duration
    profile: Callable[[bool, bool], Any] = lambda lifts, lands: rise(share, lifts, lands)  # noqa: E731
    found = Measured(
        q,
        v,
        a,
        torque,
        gait.torque_rates(index, times),
        gait.moving,
        support[:3],
        support[3:],
        other[:3],
        centre=lambda: (centre[0], centre[1]),
        profile=profile,
        **rows,
    )
    if phase.tips:
        errors.edge = larger(errors.edge, np.abs(about_toe(found, biped, phase)[1]).max(initial=0.0) / biped.effort)
    return found


def _stacked(feet: list[_Foot]) -> list[Array]:
    """(3, N) and (3, 3, N) of what was found at N instants."""
    return [np.ascontiguousarray(np.moveaxis(np.array(values), 0, -1)) for values in zip(*feet, strict=True)]


def _closure(errors: Errors, points: Array, goals: Array, feet: list[Array]) -> None:
    """Errors of the contact points of the other foot: they must stay where they are.

    Args:
        errors: so far.
        points: (3, n) from the point whose motion is known, sole's frame, m.
        goals: (3, n) where they must be, world, m.
        feet: motion of that point and of the sole, as :meth:`StateFinder.foot` gives it, at all instants.
    """
    place, speed, pull, rotation, spin, turn = feet
    place, speed, pull, spin, turn = (values[:, :, None] for values in (place, speed, pull, spin, turn))
    arm = np.einsum("ijk,jn->ikn", rotation, points)
    swing = _cross(spin, arm)
    found = (1e3 * (place + arm - goals[:, None]), speed + swing, pull + _cross(turn, arm) + _cross(spin, swing))
    for name, error in zip(CLOSURE, found, strict=True):
        errors.closure[name] = larger(errors.closure[name], np.abs(error).max(initial=0.0))


def _cross(one: Array, two: Array) -> Array:
    """(3, ...) products of vectors; NumPy's own takes ten times as long for few."""
    (a, b, c), (d, e, f) = one, two
    return np.array([b * f - c * e, c * d - a * f, a * e - b * d])
