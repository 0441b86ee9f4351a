"""The judged quantities of one episode, from its summary."""

from __future__ import annotations

from typing import Any

from gaitsmith.simulation import Summary


def measure(summary: Summary) -> dict[str, float]:
    """Quantities of :data:`gaitsmith.experiments.limits.QUANTITIES`; those that the episode does not have are absent.

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
    return found | _later(summary.model_dump())


def _later(summary: dict[str, Any]) -> dict[str, float]:
    """Quantities of parts that not every run has."""
    found = {}
    stages = summary["stages"]
    if stages and "heading_drift_deg" in stages[0]:
        turned = any(stage["command"]["yaw_rate"] for stage in stages)
        drifts = [stage["heading_drift_deg"] for stage in stages] if turned else summary["heading_deg"]
        found["heading"] = max(map(abs, drifts))
        walking = [abs(stage["yaw_rate_error"]) for stage in stages if not stage["rest"]]
        if walking:
            found["yaw_rate_error"] = max(walking)
    for name, key in (("torque_step", "torque_step_max"), ("velocity_over", "velocity_over")):
        if summary.get(key):
            found[name] = max(summary[key].values())
    if tracking := summary.get("tracking"):
        pitch, ball = tracking["foot_pitch_deg"], tracking["ball"]
        found["distance_error"] = _relative(tracking["distance"], tracking["planned_distance"])
        found["tilt"] = max(map(abs, tracking["tilt_deg"].values()))
        found["zmp_rms"] = 1e-3 * tracking["zmp_rms_mm"]
        found["strike_error"] = _relative(pitch["strike"], pitch["planned_strike"])
        found["off_error"] = _relative(pitch["off"], pitch["planned_off"])
        if ball:
            found["ball_error"] = _relative(ball["speed"], ball["planned_speed"])
    return found


def _relative(value: float | None, planned: float | None) -> float:
    """Error as a share of what was planned; 0 where nothing was."""
    return abs((value or 0.0) / planned - 1.0) if planned else 0.0
