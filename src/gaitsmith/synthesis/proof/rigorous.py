"""Every bound at every instant: enclosures of the gait over stretches of time, halved where they are too wide."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from gaitsmith.robots import Robot
from gaitsmith.synthesis.gaits.gait import Gait
from gaitsmith.synthesis.motions.biped import Biped, biped_from
from gaitsmith.synthesis.motions.motion import Phase
from gaitsmith.synthesis.proof.box import Box, stability
from gaitsmith.synthesis.proof.definitions import ROUNDING, Bound, phase_bounds
from gaitsmith.synthesis.proof.dynamics import EnclosedRobot
from gaitsmith.synthesis.proof.enclosure import Enclosed, enclose, first_stretches
from gaitsmith.synthesis.proof.quantities import about_toe, corner_heights, own_heights
from gaitsmith.synthesis.proof.ranges import suprema
from gaitsmith.synthesis.proof.taylor import Taylor

Array = npt.NDArray[np.float64]
_TIGHT = 1e-6  # share of a range, to which reported values are known
_WIDE = 1e-7  # share of a range: stretches with larger radii are halved
_FINE = 1e-10  # the same where a foot has no load yet, and all its bounds are met exactly
_COARSE = 0.02  # the same of what only has to be small
_ROUNDS = 8
_EQUATIONS = {"closure": 1e-4, "closure velocity": 0.005, "closure acceleration": 0.5}  # m, m/s, m/s²
_RESIDUAL = 1e-6  # of the weight
_PENETRATION = 1e-4  # m
_LINE = 1e-6  # of weight times height


@dataclass(frozen=True)
class Range:
    """A constraint over all times.

    Attributes:
        constraint: its name.
        low, high: between which its value lies at every instant of every phase; of a contact its cone's value, which is
            at most 0.
        limit: what it is closest to, or beyond.
        unit: of the three.
        time: s, where it is closest.
        phase: name of the phase there.
        violation: share of the range; negative inside.
        allowed: the largest violation that counts as none.
    """

    constraint: str
    low: float
    high: float
    limit: float
    unit: str
    time: float
    phase: str
    violation: float
    allowed: float

    @property
    def ok(self) -> bool:
        """Whether it is proved."""
        return self.violation <= self.allowed

    def joined(self, other: Range) -> Range:
        """Over the times of both: the place is the worse one's."""
        worse = self if self.violation - self.allowed >= other.violation - other.allowed else other
        return replace(worse, low=min(self.low, other.low), high=max(self.high, other.high))

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "constraint": self.constraint,
            "range": [_finite(self.low), _finite(self.high)],
            "limit": self.limit,
            "unit": self.unit,
            "time": self.time,
            "phase": self.phase,
            "violation": _finite(self.violation),
        }


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def proof_of(
    gait: Gait, robot: Robot, box: Box | None = None, report: Callable[[int, int], None] | None = None
) -> tuple[dict[str, Any], list[str]]:
    """The proof as plain data for JSON, and what it could not prove in words.

    Raises:
        BadInput: as :func:`prove`.
    """
    ranges = prove(gait, robot, report)
    problems = [
        f"rigorous: {item.constraint}: {item.low:.8g} to {item.high:.8g} {item.unit}, limit {item.limit:.8g}, "
        f"at {item.time:.4g} s ({item.phase})"
        for item in ranges
        if not item.ok
    ]
    found = {"ok": not problems, "worst": [item.as_dict() for item in ranges]}
    return found | {"box": None if box is None else stability(gait, robot, box)}, problems


def prove(gait: Gait, robot: Robot, report: Callable[[int, int], None] | None = None) -> list[Range]:
    """Every bound of :func:`phase_bounds`, the closure and the equations of motion, for all times; the worst first.

    Args:
        gait: the gait.
        robot: the robot that it was planned for.
        report: called with the number of phases done, and of all.

    Raises:
        BadInput: the robot has joints that the equations do not know.
    """
    biped, engine = biped_from(robot), EnclosedRobot(robot, gait.motion.slope)
    found: dict[str, Range] = {}
    for index, phase in enumerate(gait.motion.phases):
        todo = first_stretches(gait, index)
        for turn in range(_ROUNDS):
            enclosed = enclose(gait, biped, engine, index, todo)
            limits = phase_bounds(enclosed.measured, biped, gait.bounds, gait.motion, index)
            equations = _equations(enclosed, biped, phase)
            bounds, wide = [*limits, *equations], np.zeros(len(todo), dtype=bool)
            landing = [gait.motion.takes_over(index) and item.section == 0 and item.begin == 0.0 for item in todo]
            for items, share in ((limits, np.where(landing, _FINE, _WIDE)), (equations, _COARSE)):
                for bound in items:
                    wide |= ~(bound.value.r <= share * bound.span)
            last = turn == _ROUNDS - 1
            done = np.flatnonzero(~wide | last)
            if len(done):
                _add(found, gait, index, bounds, enclosed, done)
            todo = [half for k in np.flatnonzero(wide) for half in todo[k].halves()]
            if last or not todo:
                break
        if report is not None:
            report(index + 1, len(gait.motion.phases))
    return sorted(found.values(), key=lambda item: (item.ok, -item.violation))


def _equations(enclosed: Enclosed, biped: Biped, phase: Phase) -> list[Bound]:
    """What must vanish, or nearly: the residual, the gaps of the closed chain, and the sole below the ground."""
    found = []
    for row in range(enclosed.residual.shape[0]):
        value = enclosed.residual[row] * (1.0 / biped.weight)
        found.append(Bound("dynamics residual", "weights", value, -_RESIDUAL, _RESIDUAL, 2.0 * _RESIDUAL))
    for contact in enclosed.contacts:
        for (name, most), rows, unit in zip(_EQUATIONS.items(), contact, ("m", "m/s", "m/s²"), strict=True):
            found += [Bound(name, unit, rows[k], -most, most, 2.0 * most) for k in range(3)]
    if biped.lines:
        for moment in (enclosed.measured.moment[0], enclosed.measured.turn[0]):
            value = moment * (1.0 / biped.effort)
            found.append(Bound("moment about a sole's line", "weights·m", value, -_LINE, _LINE, 2.0 * _LINE))
    if phase.tips:
        value = about_toe(enclosed.measured, biped, phase)[1] * (1.0 / biped.effort)
        found.append(Bound("moment about the toe's edge", "weights·m", value, -_LINE, _LINE, 2.0 * _LINE))
    heights = corner_heights(enclosed.measured, biped, phase)
    for height in heights + (own_heights(enclosed.measured, biped, phase) if phase.flies or phase.tips else []):
        found.append(Bound("height of a sole", "m", height, -_PENETRATION, np.inf, 0.1 * biped.height))
    return found


def _add(
    found: dict[str, Range],
    gait: Gait,
    index: int,
    bounds: list[Bound],
    enclosed: Enclosed,
    done: npt.NDArray[np.int64],
) -> None:
    """The suprema of one phase's bounds, above and below, over some of its stretches."""
    names = list(dict.fromkeys((bound.name, side) for bound in bounds for side in (1.0, -1.0)))
    number = {name: k for k, name in enumerate(names)}
    rows: list[Taylor] = []
    groups: list[int] = []
    spans: dict[tuple[str, float], Bound] = {}
    for bound in bounds:
        value = bound.value if isinstance(bound.value, Taylor) else None
        assert value is not None
        for side in (1.0, -1.0):
            limit = bound.high if side > 0.0 else bound.low
            shift = limit if np.isfinite(limit) else 0.0
            rows.append((value - shift)[done] * (side / bound.span))
            groups.append(number[bound.name, side])
            spans[bound.name, side] = bound
    c, r = np.stack([row.c for row in rows], axis=1), np.stack([row.r for row in rows])
    best = suprema(c, r, np.array(groups), len(names), _TIGHT, ROUNDING)
    phase = gait.motion.phases[index].name
    for bound in {bound.name: bound for bound in bounds}.values():
        up, down = number[bound.name, 1.0], number[bound.name, -1.0]
        shifts = [limit if np.isfinite(limit) else 0.0 for limit in (bound.high, bound.low)]
        high, low = shifts[0] + bound.span * best.most[up], shifts[1] - bound.span * best.most[down]
        over = best.most[up] if np.isfinite(bound.high) else -np.inf
        under = best.most[down] if np.isfinite(bound.low) else -np.inf
        side = up if over >= under else down
        k = int(done[best.stretch[side]])
        time = float(enclosed.middles[k] + 0.5 * enclosed.spans[k] * best.place[side])
        nearest = bound.high if side == up else bound.low
        low, high, nearest = (_shown(float(value), bound.sine) for value in (low, high, nearest))
        worst, allowed = float(max(over, under)), bound.allowed
        new = Range(bound.name, low, high, nearest, _unit(bound), time, phase, worst, allowed)
        found[bound.name] = new if bound.name not in found else found[bound.name].joined(new)


def _unit(bound: Bound) -> str:
    """Of a contact its cone's value, a share of the weight, is bounded and not the ratio."""
    if bound.load is None:
        return bound.unit
    shares = "weights" if bound.power == 1 else "weights²"
    return shares if bound.unit == "of the load" else f"{shares}·{bound.unit}"


def _shown(value: float, sine: bool) -> float:
    """The angle of a sine."""
    return float(np.arcsin(np.clip(value, -1.0, 1.0))) if sine else value
