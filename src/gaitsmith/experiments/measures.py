"""The judged quantities of one episode, from its summary."""

from __future__ import annotations

from gaitsmith.simulation import Summary


def measure(summary: Summary) -> dict[str, float]:
    """Quantities of :data:`gaitsmith.experiments.limits.QUANTITIES`; those that the episode does not have are absent.

    Errors are the largest magnitudes over all walking stages, in SI units; ``speed_bias`` is signed and of the last
    walking stage. Roll and pitch, in degrees, are the largest magnitudes over every stage, rests and the beginnings
    of stages included.
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
    return found
