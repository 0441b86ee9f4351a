"""The certificate recomputed without the planner's dynamics: MuJoCo's kinematics and inverse dynamics.

Torques and contact wrenches are taken from the gait file and never derived from the residual; a file that disagrees
with physics fails.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from gaitsmith.robots import Robot
from gaitsmith.splines.polynomial import chebyshev
from gaitsmith.synthesis.gaits.full_state import FullState, StateFinder
from gaitsmith.synthesis.gaits.gait import Gait, follow
from gaitsmith.synthesis.gaits.support import zmp_margin
from gaitsmith.synthesis.motions.biped import Biped, biped_from
from gaitsmith.synthesis.motions.motion import At, Phase
from gaitsmith.synthesis.motions.settings import Bounds
from gaitsmith.synthesis.point.layout import PointLayout
from gaitsmith.synthesis.program.bounds import phase_bounds, quantity_form
from gaitsmith.synthesis.solution.bound_check import BoundTable
from gaitsmith.synthesis.solution.certificate import ALLOWED, BoundMargin, disagreements, merge, ranked

Array = npt.NDArray[np.float64]
_MIRROR3 = np.array([1.0, -1.0, 1.0])
CLOSURE = {"position_mm": 0.1, "velocity": 0.005, "acceleration": 0.5}
TORQUE_JUMP = 0.01  # N·m
RESIDUAL = 1e-6  # of the weight
PENETRATION = 0.1  # mm
SEAM = {"position_m": 1e-6, "angle_rad": 1e-5, "velocity": 1e-4, "acceleration": 1e-2}
CONDITION = 1e-5  # m, m/s or rad


@dataclass(eq=False)
class Verdict:
    """What physics says of a gait.

    Attributes:
        worst: every constraint's worst value.
        closure: largest error of the contact points in double support: mm, m/s, m/s².
        torque_jump: largest jump of a joint torque where sections meet, and at the cyclic seam, N·m.
        dynamics_residual: largest entry of the equations' residual, as a share of the weight.
        penetration: deepest point of a foot below the ground, mm.
        clearance: lowest point of the swing sole in the middle half of single support, mm.
        zmp_margin: smallest distance of the ZMP from the support sole's edge in single support, mm.
        hull_margin: smallest distance of the ZMP from the hull of all contact points, mm.
        seam: largest jumps of base pose, joint velocity and joint acceleration where phases meet.
        conditions: (quantity, wanted, found) of the motion's conditions.
        bounds: the bounds in the file, which the constraints were computed with.
        problems: what failed, in words.
    """

    worst: dict[str, BoundMargin] = field(default_factory=dict)
    closure: dict[str, float] = field(default_factory=lambda: dict.fromkeys(CLOSURE, 0.0))
    torque_jump: float = 0.0
    dynamics_residual: float = 0.0
    penetration: float = 0.0
    clearance: float = np.inf
    zmp_margin: float = np.inf
    hull_margin: float = np.inf
    seam: dict[str, float] = field(default_factory=lambda: dict.fromkeys(SEAM, 0.0))
    conditions: list[tuple[str, float, float]] = field(default_factory=list)
    bounds: dict[str, float] = field(default_factory=dict)
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
            "worst": [item.as_dict() for item in ranked(self.worst)],
            "closure": self.closure,
            "torque_jump": self.torque_jump,
            "dynamics_residual": self.dynamics_residual,
            "penetration_mm": self.penetration,
            "clearance_mm": self.clearance,
            "zmp_margin_mm": self.zmp_margin,
            "zmp_hull_margin_mm": self.hull_margin,
            "seam": self.seam,
            "conditions": [{"quantity": n, "wanted": w, "found": f} for n, w, f in self.conditions],
            "bounds": self.bounds,
        }


class _Recorder:
    """One phase's numbers as MuJoCo gives them, in the layout of a point."""

    def __init__(self, biped: Biped, gait: Gait, phase: int, finder: StateFinder) -> None:
        self.biped, self.gait, self.index, self.finder = biped, gait, phase, finder
        self.phase: Phase = gait.motion.phases[phase]
        self.layout = PointLayout(biped.joints)
        self.other = self.phase.other_foot

    def outputs(self, times: Array, verdict: Verdict) -> tuple[Array, Array, list[FullState]]:
        """Outputs (outputs, N), inputs (inputs, N) and full states; closure and residual go into the verdict."""
        biped, layout, phase = self.biped, self.layout, self.phase
        n, count = biped.joints, len(times)
        q, v, a = self.gait.joints(self.index, times)
        torque, wrench = self.gait.torques(self.index, times), self.gait.wrenches(self.index, times)
        o, z = np.zeros((layout.outputs, count)), np.zeros((layout.inputs, count))
        found = []
        pivot, mirrored = biped.pivot(phase), phase.side < 0
        base = np.array([*phase.foothold, 0.0])
        for k in range(count):
            state = self.finder.find(phase.support, phase.foothold, q[:, k], v[:, k], a[:, k])
            found.append(state)
            o[:, k], moment = self._kinematics(base, pivot)
            support = wrench[6:, k] if phase.support == "right" else wrench[:6, k]
            u = (wrench[:6, k] if phase.support == "right" else wrench[6:, k]).copy()
            u[3:] -= np.cross(moment, u[:3])
            if mirrored:
                flip = np.concatenate([_MIRROR3, -_MIRROR3])
                support, u = support * flip, u * flip
            o[layout.force : layout.force + 6, k] = support
            z[layout.wrench :, k] = u
            for place, w in enumerate((support, u)):
                o[layout.twist + place, k] = w[3:] @ w[:3] / biped.weight
                o[layout.load + place, k] = w[2] ** 2 / biped.weight
            if phase.double:
                self._closure(verdict)
            residual = np.abs(self.finder.residual(torque[:, k], wrench[:, k])).max() / biped.weight
            verdict.dynamics_residual = _larger(verdict.dynamics_residual, residual)
        stack = (biped.mirrored(values.T).T for values in (q, v, a, torque)) if mirrored else (q, v, a, torque)
        z[:n], z[n : 2 * n], z[2 * n : 3 * n], o[:n] = stack
        return o, z, found

    def _kinematics(self, base: Array, pivot: Array) -> tuple[Array, Array]:
        """Kinematic outputs of one instant in local axes, and the pivot seen from the sole's origin in the world's."""
        layout, finder, biped = self.layout, self.finder, self.biped
        m = _MIRROR3 if self.phase.side < 0 else np.ones(3)
        o = np.zeros(layout.outputs)
        place, speed, pull, rotation, omega, alpha = finder.foot(self.other, pivot)
        o[layout.pivot : layout.pivot + 3] = m * (place - base)
        o[layout.pivot_velocity : layout.pivot_velocity + 3] = m * speed
        o[layout.pivot_acceleration : layout.pivot_acceleration + 3] = m * pull
        o[layout.foot_omega : layout.foot_omega + 3] = -m * omega if m[1] < 0 else omega
        o[layout.foot_alpha : layout.foot_alpha + 3] = -m * alpha if m[1] < 0 else alpha
        o[layout.foot_forward] = rotation[0, 0]
        o[layout.foot_yaw], o[layout.foot_roll] = m[1] * rotation[1, 0], m[1] * rotation[2, 1]
        o[layout.foot_pitch] = -rotation[2, 0]
        data, robot = finder.data, biped.robot
        torso = data.xmat[robot.torso_body].reshape(3, 3)
        o[layout.hip_height] = (data.xpos[robot.torso_body] + torso @ robot.hip_midpoint)[2]
        o[layout.torso_yaw], o[layout.torso_roll] = m[1] * torso[1, 0], m[1] * torso[2, 1]
        o[layout.torso_pitch] = -torso[2, 0]
        leg = biped.leg(self.other)
        ankle, ankle_speed, *_ = finder.foot(self.other, -leg.sole_rotation.T @ leg.sole_position)
        o[layout.ankle : layout.ankle + 3] = m * (ankle - base)
        o[layout.ankle_velocity : layout.ankle_velocity + 3] = m * ankle_speed
        return o, rotation @ pivot

    def _closure(self, verdict: Verdict) -> None:
        """Errors of the contact points of the other foot: they must stay where they are."""
        phase = self.phase
        assert phase.other is not None
        for x, y in self.biped.corners(phase.contact, self.other):
            place, speed, pull, *_ = self.finder.foot(self.other, np.array([x, y, 0.0]))
            goal = np.array([phase.other[0] + x, phase.other[1] + y, 0.0])
            errors = (1e3 * np.abs(place - goal).max(), np.abs(speed).max(), np.abs(pull).max())
            for name, error in zip(CLOSURE, errors, strict=True):
                verdict.closure[name] = _larger(verdict.closure[name], error)


def verify(gait: Gait, robot: Robot, dense: int = 400, report: Callable[[int, int], None] | None = None) -> Verdict:
    """Check a gait against MuJoCo.

    Args:
        gait: the gait.
        robot: the robot that it was planned for.
        dense: instants a phase.
        report: called with the number of phases done, and of all.
    """
    with np.errstate(divide="ignore", invalid="ignore"):  # what is not a number becomes a problem of the verdict
        return _verified(gait, robot, dense, report)


def _verified(gait: Gait, robot: Robot, dense: int, report: Callable[[int, int], None] | None) -> Verdict:
    biped, bounds = biped_from(robot), Bounds.model_validate(gait.bounds)
    finder, verdict = StateFinder(robot), Verdict(bounds=dict(gait.bounds))
    borders = gait.motion.borders
    edge_states: list[tuple[FullState, FullState]] = []
    ends: dict[int, tuple[Array, Array]] = {}
    for index, phase in enumerate(gait.motion.phases):
        times = np.linspace(borders[index], borders[index + 1], dense)
        recorder = _Recorder(biped, gait, index, finder)
        o, z, found = recorder.outputs(times, verdict)
        edge_states.append((found[0], found[-1]))
        ends[index] = (o[:, 0], o[:, -1])
        items = phase_bounds(biped, bounds, gait.motion, index)
        merge(
            verdict.worst,
            phase,
            items,
            times,
            BoundTable(recorder.layout, items).values(o, z, np.linspace(0.0, 1.0, dense)),
        )
        _feet(verdict, biped, gait, index, o, recorder.layout)
        margin = 1e3 * zmp_margin(biped, phase, gait.wrenches(index, times))
        verdict.hull_margin = _smaller(verdict.hull_margin, margin)
        if not phase.double:
            verdict.zmp_margin = _smaller(verdict.zmp_margin, margin)
        if report is not None:
            report(index + 1, len(gait.motion.phases))
    _seams(verdict, gait, biped, finder, edge_states)
    for condition in gait.motion.conditions:
        if isinstance(condition, At):
            index = max(condition.border - 1, 0)
            form, constant = quantity_form(biped, gait.motion.phases[index], condition.quantity)
            column = ends[index][1 if condition.border else 0]
            value = constant + sum(factor * column[k] for k, factor in form.items())
            verdict.conditions.append((condition.quantity, condition.value, float(value)))
    _judge(verdict, gait.certificate)
    return verdict


def _feet(verdict: Verdict, biped: Biped, gait: Gait, index: int, o: Array, layout: PointLayout) -> None:
    """Penetration and clearance of one phase."""
    phase = gait.motion.phases[index]
    pivot = biped.pivot(phase)
    heights = [
        o[layout.pivot + 2] - o[layout.foot_pitch] * (x - pivot[0]) + o[layout.foot_roll] * phase.side * (y - pivot[1])
        for x, y in biped.corners("flat", phase.other_foot)
    ]
    lowest = np.min(heights, axis=0)
    verdict.penetration = _larger(verdict.penetration, -1e3 * lowest.min())
    if phase.double:
        return
    count = len(lowest)
    begin = count // 2 if gait.motion.lifts(index) else 0
    end = count // 2 if gait.motion.lands(index) else count
    middle = lowest[begin : max(end, begin + 1)]
    verdict.clearance = _smaller(verdict.clearance, 1e3 * middle.min())


def torque_jump(gait: Gait, biped: Biped) -> float:
    """Largest jump of a joint torque where sections meet, and at the seam of a cyclic gait, N·m."""
    pieces = [piece for group in gait.pieces for piece in group]
    starts = np.array([chebyshev(piece.torque, 0.0) for piece in pieces])
    ends = np.array([chebyshev(piece.torque, 1.0) for piece in pieces])
    jumps = np.abs(ends[:-1] - starts[1:])
    if gait.motion.cyclic:
        again = biped.mirrored(starts[0]) if gait.motion.mirrored else starts[0]
        jumps = np.vstack([jumps, np.abs(ends[-1] - again)])
    return float(jumps.max(initial=0.0))


def _seams(
    verdict: Verdict, gait: Gait, biped: Biped, finder: StateFinder, edges: list[tuple[FullState, FullState]]
) -> None:
    """Jumps where sections and phases meet, the cyclic seam included."""
    verdict.torque_jump = torque_jump(gait, biped)
    pairs = [(before[1], after[0]) for before, after in pairwise(edges)]
    if gait.motion.cyclic:
        image = follow(gait, gait, gait.motion.mirrored, biped.partner, biped.sign)
        first = image.motion.phases[0]
        q, v, a = (values[:, 0] for values in image.joints(0, np.array([image.pieces[0][0].start])))
        pairs.append((edges[-1][1], finder.find(first.support, first.foothold, q, v, a)))
    for end, begin in pairs:
        turn = 2.0 * np.arccos(_smaller(1.0, abs(float(end.position[3:7] @ begin.position[3:7]))))
        found = {
            "position_m": float(np.abs(end.position[:3] - begin.position[:3]).max()),
            "angle_rad": _larger(np.abs(end.position[7:] - begin.position[7:]).max(), turn),
            "velocity": float(np.abs(end.velocity - begin.velocity).max()),
            "acceleration": float(np.abs(end.acceleration - begin.acceleration).max()),
        }
        for name, value in found.items():
            verdict.seam[name] = _larger(verdict.seam[name], value)


def _larger(one: float, two: float) -> float:
    """The larger number; NaN if either is."""
    return float(np.maximum(one, two))


def _smaller(one: float, two: float) -> float:
    """The smaller number; NaN if either is."""
    return float(np.minimum(one, two))


def _judge(verdict: Verdict, stored: dict[str, Any]) -> None:
    """Everything that fails, in words."""
    problems = verdict.problems
    for item in ranked(verdict.worst):
        if not (item.violation <= ALLOWED and np.isfinite(item.value)):
            value = f"{item.value:.6g} of {item.limit:.6g} {item.unit}"
            problems.append(f"{item.constraint}: {value} at {item.time:.4g} s ({item.phase})")
    for name, limit in CLOSURE.items():
        if not verdict.closure[name] <= limit:
            problems.append(f"closure {name}: {verdict.closure[name]:.3g}, allowed {limit:g}")
    if not verdict.dynamics_residual <= RESIDUAL:
        problems.append(f"dynamics residual: {verdict.dynamics_residual:.3g} of the weight, allowed {RESIDUAL:g}")
    if not verdict.torque_jump <= TORQUE_JUMP:
        problems.append(f"torque jump: {verdict.torque_jump:.3g} N·m, allowed {TORQUE_JUMP:g}")
    if not verdict.penetration <= PENETRATION:
        problems.append(f"penetration: {verdict.penetration:.3g} mm, allowed {PENETRATION:g}")
    for name, limit in SEAM.items():
        if not verdict.seam[name] <= limit:
            problems.append(f"{name} jumps where phases meet: {verdict.seam[name]:.3g}, allowed {limit:g}")
    for name, wanted, found in verdict.conditions:
        if not abs(wanted - found) <= CONDITION:
            problems.append(f"{name}: {found:.6g}, wanted {wanted:.6g}")
    for name, margin in (("ZMP margin", verdict.zmp_margin), ("ZMP hull margin", verdict.hull_margin)):
        if np.isnan(margin):
            problems.append(f"{name}: not a number")
    problems += disagreements(stored, verdict.worst)
