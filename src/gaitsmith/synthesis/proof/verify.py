"""A gait file against physics: every bound, condition and figure in it recomputed, without the planner.

Kinematics and inverse dynamics are MuJoCo's, limits are the card's, bounds are those of
:mod:`gaitsmith.synthesis.proof.definitions`. Torques and contact wrenches are taken from the file and never derived
from the residual; a file that disagrees with physics fails.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from gaitsmith.robots import Robot
from gaitsmith.synthesis.files.gait_file import claims_hash
from gaitsmith.synthesis.gaits.full_state import StateFinder
from gaitsmith.synthesis.gaits.gait import Gait
from gaitsmith.synthesis.gaits.support import contact_points, hull, inside
from gaitsmith.synthesis.gaits.worst import Worst
from gaitsmith.synthesis.motions.biped import Biped, biped_from
from gaitsmith.synthesis.motions.motion import Phase
from gaitsmith.synthesis.proof.borders import SEAM, conditions, durations, jumps, objective, seams
from gaitsmith.synthesis.proof.certificate import (
    claimed_at,
    disagrees,
    entries,
    missing,
    ranked,
    tally,
    unloaded,
)
from gaitsmith.synthesis.proof.definitions import LOADED, Bound, phase_bounds
from gaitsmith.synthesis.proof.measured import Errors, larger, measure, smaller
from gaitsmith.synthesis.proof.quantities import Measured, corner_heights, own_heights

Array = npt.NDArray[np.float64]
CLOSURE = {"position_mm": 0.1, "velocity": 0.005, "acceleration": 0.5}
DENSE = 200  # instants a phase
TORQUE_JUMP = 0.01  # N·m
RESIDUAL = 1e-6  # of the weight
WRENCH_JUMP = 1e-5  # of the weight
EDGE = 1e-6  # of weight times height: moment about the edge or the line that a foot turns about
AIR = 1e-9  # of the weight: wrench on a foot in the air
UNLOADED = 1e-9  # of the weight: what a foot that bears next to nothing may exert beyond its cones
PENETRATION = 0.1  # mm
OBJECTIVE = 1e-9  # relative


@dataclass(eq=False)
class Verdict:
    """What physics says of a gait.

    Attributes:
        worst: every constraint's worst value.
        closure: largest error of the contact points in double support: mm, m/s, m/s².
        torque_jump: largest jump of a joint torque where sections meet, and at the cyclic seam, N·m.
        wrench_jump: the same of a contact wrench, of the weight.
        dynamics_residual: largest entry of the equations' residual, as a share of the weight.
        penetration: deepest point of a foot below the ground, mm.
        clearance: lowest point of the swing sole in the middle half of single support, mm.
        zmp_margin: smallest distance of the ZMP from the support sole's edge in single support, mm.
        hull_margin: smallest distance of the ZMP from the hull of all contact points, mm.
        seam: largest jumps of base pose, joint velocity and joint acceleration where phases or sections meet.
        conditions: (what, wanted, found, allowed) of every number that the motion's conditions fix.
        objective: J of (16).
        bounds: the bounds in the file, which the constraints were computed with.
        checked: conditions, bounds and certificate entries that were looked at.
        rigorous: for all times; None if not asked for.
        problems: what failed, in words.
    """

    worst: dict[str, Worst] = field(default_factory=dict)
    closure: dict[str, float] = field(default_factory=lambda: dict.fromkeys(CLOSURE, 0.0))
    torque_jump: float = 0.0
    wrench_jump: float = 0.0
    dynamics_residual: float = 0.0
    penetration: float = 0.0
    clearance: float = np.inf
    zmp_margin: float = np.inf
    hull_margin: float = np.inf
    seam: dict[str, float] = field(default_factory=lambda: dict.fromkeys(SEAM, 0.0))
    conditions: list[tuple[str, float, float, float]] = field(default_factory=list)
    objective: float = 0.0
    bounds: dict[str, float] = field(default_factory=dict)
    checked: int = 0
    rigorous: dict[str, Any] | None = None
    problems: list[str] = field(default_factory=list)

    @property
    def ok(self) -> bool:
        """Whether file and physics agree and every constraint holds."""
        return not self.problems

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "ok": self.ok,
            "problems": self.problems,
            "checked": self.checked,
            "worst": [item.as_dict() for item in ranked(self.worst)],
            "closure": self.closure,
            "torque_jump": self.torque_jump,
            "wrench_jump": self.wrench_jump,
            "dynamics_residual": self.dynamics_residual,
            "penetration_mm": self.penetration,
            "clearance_mm": self.clearance,
            "zmp_margin_mm": self.zmp_margin,
            "zmp_hull_margin_mm": self.hull_margin,
            "seam": self.seam,
            "conditions": [{"quantity": n, "wanted": w, "found": f} for n, w, f, _ in self.conditions],
            "objective": self.objective,
            "bounds": self.bounds,
            "rigorous": self.rigorous,
        }


def verify(gait: Gait, robot: Robot, dense: int = DENSE, report: Callable[[int, int], None] | None = None) -> Verdict:
    """Check a gait against MuJoCo.

    Args:
        gait: the gait.
        robot: the robot that it was planned for.
        dense: instants a phase.
        report: called with the number of phases done, and of all.
    """
    with np.errstate(all="ignore"):  # what is not a number becomes a problem of the verdict
        return _verified(gait, robot, dense, report)


def _verified(gait: Gait, robot: Robot, dense: int, report: Callable[[int, int], None] | None) -> Verdict:
    biped, finder, verdict = biped_from(robot), StateFinder(robot, gait.motion.slope), Verdict(bounds=dict(gait.bounds))
    rows, verdict.problems = entries(gait.certificate)
    if gait.certificate.get("claims") != claims_hash(gait):
        verdict.problems.append("the certificate is of other phases, limits, conditions, bounds or parameters")
    points = gait.certificate.get("dense_points")
    claims = claimed_at(rows, gait, points if type(points) is int else 2)
    for row in claims.get(-1, []):
        when = f"{row['time']:.6g} s is no instant of {row['phase'][:40]}"
        verdict.problems.append(f"{row['constraint'][:60]} in the file's certificate: {when}")
    borders, errors, light = gait.motion.borders, Errors(), 0.0
    beyond: dict[str, Worst] = {}
    for index, phase in enumerate(gait.motion.phases):
        times = np.linspace(borders[index], borders[index + 1], dense)
        found = measure(gait, biped, finder, index, times, errors)
        bounds = phase_bounds(found, biped, gait.bounds, gait.motion, index)
        tally(verdict.worst, beyond, phase, bounds, times)
        light = larger(light, unloaded(bounds))
        _figures(verdict, biped, gait, index, found)
        _compare(verdict, claims.get(index, []), gait, biped, finder, index)
        verdict.checked += len(bounds)
        if report is not None:
            report(index + 1, len(gait.motion.phases))
    verdict.closure, verdict.dynamics_residual = errors.closure, errors.residual
    verdict.torque_jump, verdict.wrench_jump = jumps(gait, biped)
    verdict.seam = seams(gait, biped, finder)
    verdict.conditions = conditions(gait, biped, finder)
    verdict.problems += durations(gait)
    verdict.checked += len(rows) + len(verdict.conditions)
    _judge(verdict, beyond, errors, light)
    verdict.problems += missing(rows, verdict.worst) if rows else []
    _judge_objective(verdict, gait, biped, finder)
    return verdict


def _figures(verdict: Verdict, biped: Biped, gait: Gait, index: int, found: Measured) -> None:
    """Penetration, clearance and ZMP margins of one phase, mm."""
    phase = gait.motion.phases[index].straight
    heights = corner_heights(found, biped, phase) + (
        own_heights(found, biped, phase) if phase.flies or phase.tips else []
    )
    lowest = 1e3 * np.min(heights, axis=0)
    verdict.penetration = larger(verdict.penetration, -lowest.min())
    if phase.double and phase.rise:
        return  # with soles at two heights there is no plane for a ZMP
    if not phase.flies:
        near = any(item.flies for item in gait.motion.phases[max(index - 1, 0) : index + 2])
        bare = near & (found.force[2] + found.push[2] < LOADED * biped.weight)  # next to a flight there is no ZMP
        places = inside(hull(contact_points(biped, phase)), _zmp(found, phase))
        margin = 1e3 * float(places[~bare].min(initial=np.inf))
        verdict.hull_margin = smaller(verdict.hull_margin, margin)
        if phase.double:
            return
        verdict.zmp_margin = smaller(verdict.zmp_margin, margin)
    count = len(lowest)
    begin = count // 2 if gait.motion.lifts(index) else 0
    end = count // 2 if gait.motion.lands(index) else count
    verdict.clearance = smaller(verdict.clearance, lowest[begin : max(end, begin + 1)].min())


def _zmp(found: Measured, phase: Phase) -> Array:
    """(2, N) zero moment point of both wrenches on the ground, world, m; eq. (12)."""
    x, y, z = found.own - np.array([0.0, 0.0, phase.height])[:, None]
    load = found.force[2] + found.push[2]
    mx = found.moment[0] + y * found.force[2] - z * found.force[1] + found.turn[0] + found.pivot[1] * found.push[2]
    my = found.moment[1] - x * found.force[2] + z * found.force[0] + found.turn[1] - found.pivot[0] * found.push[2]
    return np.array([-my / load, mx / load])


def _compare(
    verdict: Verdict, rows: list[dict[str, Any]], gait: Gait, biped: Biped, finder: StateFinder, index: int
) -> None:
    """The certificate's entries of one phase, each at its own time."""
    if not rows:
        return
    first, last = gait.motion.borders[index : index + 2]
    times = np.clip([row["time"] for row in rows], first, last)
    found = measure(gait, biped, finder, index, times, Errors())
    bounds: list[Bound] = phase_bounds(found, biped, gait.bounds, gait.motion, index)
    texts = (disagrees(row, bounds, k) for k, row in enumerate(rows))
    verdict.problems += [text for text in texts if text]


def _judge(verdict: Verdict, beyond: dict[str, Worst], errors: Errors, light: float) -> None:
    """Everything that fails, in words."""
    problems = verdict.problems
    for item in ranked(beyond):
        text = f"{item.value:.6g} of {item.limit:.6g} {item.unit} at {item.time:.4g} s ({item.phase})"
        problems.append(f"{item.constraint}: {text}")
    limits = [(f"closure {name}", verdict.closure[name], limit, "") for name, limit in CLOSURE.items()]
    limits += [
        ("dynamics residual", verdict.dynamics_residual, RESIDUAL, " of the weight"),
        ("torque jump", verdict.torque_jump, TORQUE_JUMP, " N·m"),
        ("wrench jump", verdict.wrench_jump, WRENCH_JUMP, " of the weight"),
        ("wrench on the foot in the air", errors.air, AIR, " of the weight"),
        ("moment about an edge", errors.edge, EDGE, " of weight times height"),
        ("force beyond the cones of a foot that bears next to nothing", light, UNLOADED, " of the weight"),
        ("penetration", verdict.penetration, PENETRATION, " mm"),
    ]
    limits += [(f"jump of {name} where phases or sections meet", verdict.seam[name], SEAM[name], "") for name in SEAM]
    problems += [
        f"{name}: {found:.3g}{unit}, allowed {limit:g}" for name, found, limit, unit in limits if not found <= limit
    ]
    for name, wanted, found, allowed in verdict.conditions:
        if not abs(wanted - found) <= allowed:
            problems.append(f"{name}: {found:.6g}, wanted {wanted:.6g}")
    for name, margin in (("ZMP margin", verdict.zmp_margin), ("ZMP hull margin", verdict.hull_margin)):
        if np.isnan(margin):
            problems.append(f"{name}: not a number")


def _judge_objective(verdict: Verdict, gait: Gait, biped: Biped, finder: StateFinder) -> None:
    """J of the file's own curves against the certificate's."""
    told, weight = (gait.certificate.get(key) for key in ("objective", "wrench_weight"))
    for key, value in (("objective", told), ("wrench_weight", weight)):
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0.0 <= value < np.inf:
            verdict.problems.append(f"the certificate's {key} is no number from 0")
            return
    efforts = gait.certificate.get("effort_weights")
    if not isinstance(efforts, dict) or not set(efforts) <= set(gait.joint_names):
        verdict.problems.append("the certificate's effort_weights are no weights of the joints")
        return
    if not all(type(value) in (int, float) and 0.0 < value < np.inf for value in efforts.values()):
        verdict.problems.append("the certificate's effort_weights are no positive numbers")
        return
    joints = np.array([float(efforts.get(name, 1.0)) for name in gait.joint_names])
    verdict.objective = objective(gait, biped, finder, float(weight or 0.0), joints)
    if not abs(verdict.objective - float(told or 0.0)) <= OBJECTIVE * max(1.0, abs(verdict.objective)):
        verdict.problems.append(
            f"objective: {told:.8g} in the file's certificate, {verdict.objective:.8g} by its curves"
        )
