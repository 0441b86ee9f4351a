"""The judged quantities of one episode, from its summary."""

from __future__ import annotations

from gaitsmith.simulation import Summary
from gaitsmith.simulation.summary import Tracking


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
