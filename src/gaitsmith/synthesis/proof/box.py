"""Stability for a whole box of errors: masses, friction and footholds that differ from the plan's, at all times.

The bodies move as planned. Each body's mass and inertia lie within a share of the model's, whatever the others do; the
ground's friction lies in a range; while both feet stand, the other sole lies up to a distance from its foothold along
x and along y. What the motion then takes from the ground must come from within the hull of the contact points (12),
from inside the friction cone, and must press. In double support that is said of both feet together, because the
controller chooses how they share.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.robots import Robot
from gaitsmith.synthesis.gaits.gait import Gait
from gaitsmith.synthesis.gaits.support import contact_points, hull
from gaitsmith.synthesis.motions.biped import Biped, biped_from
from gaitsmith.synthesis.motions.motion import Phase
from gaitsmith.synthesis.proof.dynamics import EnclosedRobot
from gaitsmith.synthesis.proof.enclosure import Enclosed, enclose, first_stretches
from gaitsmith.synthesis.proof.ranges import bernstein
from gaitsmith.synthesis.proof.taylor import Taylor

Array = npt.NDArray[np.float64]
_FACES = 32  # of the pyramid inside the friction cone: half a percent is lost
_BISECTIONS = 14  # of a margin: to a tenth of a millimetre
_LONGEST = 0.005  # s: of the stretches
_LARGEST = {"mass": 0.5, "friction": 5.0, "foothold": 0.5}
_FORM = "mass=SHARE,friction=LOW:HIGH,foothold=METRES, any of them"


@dataclass(frozen=True)
class Box:
    """Errors to be borne.

    Attributes:
        mass: largest relative error of every body's mass.
        friction: least and largest coefficient of the ground; the plan's twice if None.
        foothold: largest error of the other sole's place along x and along y, m.
    """

    mass: float = 0.0
    friction: tuple[float, float] | None = None
    foothold: float = 0.0


def box_from(text: str) -> Box:
    """The box that a text names, such as ``mass=.05,friction=.5:1,foothold=.01``.

    Raises:
        BadInput: an unknown name, a name given twice, or a number out of range.
    """
    found: dict[str, Any] = {}
    for part in text.split(","):
        name, _, value = (word.strip() for word in part.partition("="))
        try:
            numbers = tuple(float(word) for word in value.split(":"))
        except ValueError:
            numbers = ()
        most = _LARGEST.get(name, -1.0)
        fits = len(numbers) == 1 + (name == "friction") and all(0.0 <= x <= most for x in numbers)
        if not fits or name in found or list(numbers) != sorted(numbers):
            raise BadInput("--box", part.strip()[:60], _FORM, "mass up to 0.5, friction up to 5, foothold up to 0.5 m")
        found[name] = numbers if name == "friction" else numbers[0]
    return Box(**found)


@dataclass(frozen=True)
class _Rows:
    """What must be at most 0: matrices on every body's force and moment about the world's origin.

    Attributes:
        name: of the constraint.
        unit: of the margin per newton of normal force.
        force, moment: (3, k).
    """

    name: str
    unit: str
    force: Array
    moment: Array


def stability(gait: Gait, robot: Robot, box: Box) -> dict[str, Any]:
    """What is proved for all of the box, and where nothing is; plain data for JSON."""
    biped, engine = biped_from(robot), EnclosedRobot(robot, gait.motion.slope)
    found: dict[str, dict[str, Any]] = {}
    for index, phase in enumerate(gait.motion.phases):
        if phase.flies:
            continue
        enclosed = enclose(gait, biped, engine, index, first_stretches(gait, index, _LONGEST))
        for rows in _constraints(biped, phase.straight, box, gait.bounds["friction"]):
            most = _sums(enclosed, box.mass, rows.force, rows.moment).max(axis=0)
            uneven = rows.name == "ZMP" and phase.double and phase.rise != 0.0
            if uneven:  # with soles at two heights there is no plane for a ZMP
                most = np.full_like(most, np.inf)
            entry = found.setdefault(
                rows.name, {"constraint": rows.name, "margin": np.inf, "unit": rows.unit, "unproved": []}
            )
            ratio = rows.name != "normal force"
            margin = _margin(enclosed, box.mass, rows) if ratio else -float(most.max()) / biped.weight
            entry["margin"] = entry["margin"] if uneven else min(entry["margin"], margin)
            entry["unproved"] += _stretches(phase.name, enclosed, ~(most < 0.0))
    items = list(found.values())
    return asdict(box) | {"proved": not any(item["unproved"] for item in items), "constraints": items}


def _constraints(biped: Biped, phase: Phase, box: Box, planned: float) -> list[_Rows]:
    """ZMP, friction and unilateral contact of all that stands on the ground in a phase."""
    corners = hull(contact_points(biped, phase))
    sides = np.roll(corners, -1, axis=0) - corners
    x, y = np.array([sides[:, 1], -sides[:, 0]]) / np.linalg.norm(sides, axis=1)
    shrink = box.foothold * (np.abs(x) + np.abs(y)) if phase.double else 0.0
    room = x * corners[:, 0] + y * corners[:, 1] - shrink
    none = np.zeros_like(x)
    level = phase.height  # moments about a point at the height of the soles: M - h z × F
    found = [_Rows("ZMP", "m", np.array([level * x, level * y, -room]), np.array([y, -x, none]))]
    least = planned if box.friction is None else box.friction[0]
    angles = (2.0 * np.arange(_FACES) + 1.0) * np.pi / _FACES
    cone = np.array([np.cos(angles), np.sin(angles), np.full(_FACES, -least * np.cos(np.pi / _FACES))])
    found.append(_Rows("friction", "of the load", cone, np.zeros((3, _FACES))))
    found.append(_Rows("normal force", "weights", np.array([[0.0], [0.0], [-1.0]]), np.zeros((3, 1))))
    return found


def _sums(enclosed: Enclosed, mass: float, force: Array, moment: Array | None = None) -> Array:
    """(k, N) upper bounds of the rows over every stretch, for all masses."""
    forces, moments = enclosed.loads
    rows: Taylor = forces.by(force)
    if moment is not None:
        rows = rows + moments.by(moment)
    total, (least, most) = rows.sum(0), bernstein(rows)
    return np.asarray(bernstein(total)[1] + mass * np.maximum(np.abs(least), np.abs(most)).sum(axis=0))


def _margin(enclosed: Enclosed, mass: float, rows: _Rows) -> float:
    """The largest margin per newton of normal force that is proved in all stretches; by bisection."""
    low, high = -1.0, 1.0
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        force = rows.force + np.array([[0.0], [0.0], [middle]])
        proved = bool((_sums(enclosed, mass, force, rows.moment) < 0.0).all())
        low, high = (middle, high) if proved else (low, middle)
    return low


def _stretches(name: str, enclosed: Enclosed, open_: npt.NDArray[np.bool_]) -> list[dict[str, Any]]:
    """Spans of time that are not proved, neighbours joined."""
    found: list[dict[str, Any]] = []
    for k in np.flatnonzero(open_).tolist():
        begin, end = (float(enclosed.middles[k] + side * enclosed.spans[k]) for side in (-0.5, 0.5))
        if found and abs(found[-1]["to"] - begin) < 1e-9:
            found[-1]["to"] = end
        else:
            found.append({"phase": name, "from": begin, "to": end})
    return found
