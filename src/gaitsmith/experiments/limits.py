"""Named quantities, how an episode's summary gives them, limits on them, and verdicts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from gaitsmith.simulation import Summary
from gaitsmith.simulation.summary import Tracking

Verdict = Literal["pass", "miss", "report", "skipped", "not run"]


class Quantity(NamedTuple):
    """How a number is called and shown: ``scale`` times the SI value, in ``unit``; ``least``: more is better."""

    label: str
    unit: str
    scale: float = 1.0
    digits: int = 1
    least: bool = False


QUANTITIES: dict[str, Quantity] = {
    "speed_error": Quantity("speed error", "mm/s", 1e3),
    "lateral_error": Quantity("lateral speed error", "mm/s", 1e3),
    "speed_bias": Quantity("speed bias", "mm/s", 1e3),
    "height_error": Quantity("steady height error", "mm", 1e3),
    "roll": Quantity("roll", "°", 1.0, 2),
    "pitch": Quantity("pitch", "°", 1.0, 2),
    "drift": Quantity("drift", "m", 1.0, 3),
    "yaw": Quantity("yaw", "°"),
    "heading": Quantity("heading error", "°", 1.0, 2),
    "yaw_rate_error": Quantity("yaw rate error", "mrad/s", 1e3),
    "separation": Quantity("separation", "cm", 1e2, least=True),
    "leg_contacts": Quantity("leg contacts", "", 1.0, 0),
    "saturated": Quantity("torque saturated", "% of ticks", 1e2, 2),
    "torque_step": Quantity("torque step", "N·m/ms"),
    "velocity_over": Quantity("velocity over its limit", "% of ticks", 1e2, 2),
    "distance_error": Quantity("distance error", "%", 1e2, 2),
    "tilt": Quantity("tilt from the plan", "°", 1.0, 2),
    "zmp_rms": Quantity("ZMP from the plan", "mm rms", 1e3),
    "strike_error": Quantity("heel strike pitch error", "%", 1e2, 0),
    "off_error": Quantity("toe-off pitch error", "%", 1e2, 0),
    "ball_error": Quantity("ball speed error", "%", 1e2, 0),
    "tick_median": Quantity("median", "µs"),
    "tick_p99": Quantity("99th percentile", "µs"),
    "tick_max": Quantity("longest", "µs", 1.0, 0),
    "overruns": Quantity("overruns", "", 1.0, 0),
    "qp_fallbacks": Quantity("QP fallback", "% of ticks", 1e2, 3),
    "allocations": Quantity("allocations", "", 1.0, 0),
    "start_up": Quantity("start to first tick", "s"),
    "realtime_factor": Quantity("times real time", "", least=True),
}
"""Every quantity that is judged or reported."""


class Limit(NamedTuple):
    """A bound on one quantity, in SI units (degrees and µs where the quantity has them).

    Attributes:
        quantity: a name of :data:`QUANTITIES`.
        bound: the largest value allowed, or the smallest where more is better.
    """

    quantity: str
    bound: float

    @property
    def least(self) -> bool:
        """Whether the bound is the smallest value allowed."""
        return QUANTITIES[self.quantity].least

    def met(self, value: float) -> bool:
        """Whether a value keeps the limit; one that is not a number does not."""
        return value >= self.bound if self.least else value <= self.bound

    def worst(self, values: Sequence[float]) -> float:
        """The value farthest on the wrong side."""
        return min(values) if self.least else max(values)

    def target(self) -> str:
        """The limit in words."""
        label, unit, scale, *_ = QUANTITIES[self.quantity]
        return f"{label} {'≥' if self.least else '≤'} {scale * self.bound:g}{_spaced(unit)}"


class Finding(NamedTuple):
    """A measured quantity beside its limit; None without one."""

    quantity: str
    value: float | None
    limit: Limit | None

    def verdict(self) -> Verdict:
        """``not run`` without a value, ``report`` without a limit."""
        if self.limit is None:
            return "report"
        if self.value is None:
            return "not run"
        return "pass" if self.limit.met(self.value) else "miss"

    def document(self) -> dict[str, Any]:
        """As plain data, in SI units (degrees and µs where the quantity has them)."""
        bound = None if self.limit is None else {"at_least" if self.limit.least else "at_most": self.limit.bound}
        return {"quantity": self.quantity, "value": self.value, "limit": bound, "verdict": self.verdict()}


@dataclass(frozen=True)
class Judgement:
    """Verdict of one trial over all its episodes.

    Attributes:
        verdict: ``miss`` if anything missed; ``report`` if the trial is not judged.
        findings: the worst of every quantity, limits first.
        falls: number of episodes that fell.
    """

    verdict: Verdict
    findings: tuple[Finding, ...]
    falls: int


def judge(
    limits: Sequence[Limit],
    reported: Sequence[str],
    episodes: Sequence[Mapping[str, float]],
    falls: int,
    *,
    allowed: int = 0,
    judged: bool = True,
) -> Judgement:
    """Judge a trial by its worst episode; a fall too many is a miss whatever the numbers say.

    Args:
        reported: quantities without a limit; of several episodes the value farthest from zero.
        episodes: measured quantities of each finished episode.
        falls: how many of them fell.
        allowed: how many may.
        judged: False to report only.
    """
    findings = []
    for limit in limits:
        values = [episode[limit.quantity] for episode in episodes if limit.quantity in episode]
        findings.append(Finding(limit.quantity, limit.worst(values) if values else None, limit))
    for name in reported:
        values = [episode[name] for episode in episodes if name in episode]
        findings.append(Finding(name, max(values, key=abs) if values else None, None))
    verdict: Verdict = "pass"
    if not episodes:
        verdict = "not run"
    elif not judged:
        verdict = "report"
    elif falls > allowed or any(finding.verdict() not in ("pass", "report") for finding in findings):
        verdict = "miss"
    return Judgement(verdict, tuple(findings), falls)


def shown(quantity: str, value: float | None) -> str:
    """A value with its unit."""
    _, unit, scale, digits, _ = QUANTITIES[quantity]
    return "–" if value is None else f"{scale * value:.{digits}f}{_spaced(unit)}"


def _spaced(unit: str) -> str:
    return unit if unit in ("", "°") else f" {unit}"


def measure(summary: Summary) -> dict[str, float]:
    """Values of :data:`QUANTITIES` from the summary of one episode; what the episode does not have is absent.

    Errors are the largest magnitudes over all walking stages, in SI units; ``speed_bias`` is signed and of the last
    walking stage. Roll, pitch and heading error, in degrees, are the largest magnitudes over every stage, rests and
    the beginnings of stages included.
    """
    found: dict[str, float] = {
        "drift": summary.drift,
        "separation": summary.min_foot_separation,
        "leg_contacts": float(summary.leg_contacts),
        "yaw": max(map(abs, summary.yaw_deg)),
        "saturated": max(summary.torque_saturated.values(), default=0.0),
        "torque_step": max(summary.torque_step_max.values(), default=0.0),
        "velocity_over": max(summary.velocity_over.values(), default=0.0),
    }
    if summary.qp.solves:
        found["qp_fallbacks"] = summary.qp.fallbacks / summary.qp.solves
    if summary.stages:
        found["roll"] = max(abs(angle) for stage in summary.stages for angle in stage.roll_deg)
        found["pitch"] = max(abs(angle) for stage in summary.stages for angle in stage.pitch_deg)
    walking = [stage for stage in summary.stages if not stage.rest]
    if walking:
        found["speed_error"] = max(abs(stage.vx_error) for stage in walking)
        found["lateral_error"] = max(abs(stage.vy_error) for stage in walking)
        found["height_error"] = max(abs(stage.height_error) for stage in walking)
        found["speed_bias"] = walking[-1].vx_error
        found["yaw_rate_error"] = max(abs(stage.yaw_rate_error) for stage in walking)
    turned = any(stage.command.yaw_rate for stage in walking)
    found["heading"] = max(map(abs, (s.heading_drift_deg for s in summary.stages) if turned else summary.heading_deg))
    return found | (_tracked(summary.tracking) if summary.tracking else {})


def _tracked(tracking: Tracking) -> dict[str, float]:
    """What a planned gait is judged by, beside the plan."""
    found = {
        "distance_error": _relative(tracking.distance, tracking.planned_distance),
        "tilt": max(map(abs, tracking.tilt_deg.values())),
        "zmp_rms": 1e-3 * tracking.zmp_rms_mm,
    }
    pitch = tracking.foot_pitch_deg
    found["strike_error"] = _relative(pitch.strike, pitch.planned_strike) if pitch else 0.0
    found["off_error"] = _relative(pitch.off, pitch.planned_off) if pitch else 0.0
    if tracking.ball:
        found["ball_error"] = _relative(tracking.ball.speed, tracking.ball.planned_speed)
    return found


def _relative(value: float, planned: float) -> float:
    """Error as a share of what was planned; 0 where nothing was."""
    return abs(value / planned - 1.0) if planned else 0.0
