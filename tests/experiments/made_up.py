"""Summaries of episodes that nobody ran."""

from __future__ import annotations

from typing import Any

from gaitsmith.simulation.fall import Fall
from gaitsmith.simulation.summary import QpCounts, Stage, StageCommand, Summary, TickTimes

REASON = (
    "the torso tilted by more than 60 degrees; first limit hit: torque of left_knee saturated, at 4.9 s; then others"
)


def made_up_stage(**given: Any) -> Stage:
    """A stage walked without any error."""
    command = StageCommand(vx=0.3, vy=0.0, period=0.4, alpha=0.5, height=0.7, lift=0.1, width=0.0375, yaw_rate=0.0)
    fields: dict[str, Any] = {
        "t0": 0.0,
        "t1": 10.0,
        "rest": False,
        "command": command,
        "scored": (8.0, 10.0),
        "vx_mean": 0.3,
        "vx_error": 0.0,
        "vy_mean": 0.0,
        "vy_error": 0.0,
        "height_mean": 0.7,
        "height_error": 0.0,
        "yaw_rate_mean": 0.0,
        "yaw_rate_error": 0.0,
        "heading_drift_deg": 0.0,
        "roll_deg": (-0.1, 0.1),
        "pitch_deg": (-0.1, 0.1),
        "settled_roll_deg": (-0.1, 0.1),
        "settled_pitch_deg": (-0.1, 0.1),
    }
    return Stage(**{**fields, **given})


def made_up_summary(fell_at: float | None = None, pushed_at: float | None = None, **given: Any) -> Summary:
    """An episode of 16 s in which nothing went wrong, unless it fell."""
    fall = None if fell_at is None else Fall(time=fell_at, phase="left stance, 10 % of the step", reason=REASON)
    fields: dict[str, Any] = {
        "fell": fall is not None,
        "fall": fall,
        "interrupted": False,
        "robot": "made_up",
        "preset": "default",
        "state": "true",
        "terrain": "flat",
        "seed": 0,
        "duration": 16.0 if fell_at is None else fell_at,
        "steps": 40,
        "stages": (made_up_stage(),),
        "drift": 0.01,
        "distance": 3.0,
        "yaw_deg": (-1.0, 2.0),
        "heading_deg": (-1.0, 2.0),
        "min_foot_separation": 0.08,
        "leg_contacts": 0,
        "torque_peak": {"knee": 80.0},
        "torque_saturated": {"knee": 0.0},
        "torque_step_max": {"knee": 9.0},
        "velocity_peak": {"knee": 5.0},
        "velocity_over": {"knee": 0.0},
        "control_state": "walking",
        "refused": {},
        "memory_mb": None,
        "log": None,
        "qp": QpCounts(solves=1000, fallbacks=2, infeasible=0),
        "tick_us": TickTimes(median=20.0, p99=40.0, max=90.0, overruns=0),
        "realtime_factor": 9.0,
        "pushes": () if pushed_at is None else (pushed_at,),
        "warnings": (),
    }
    return Summary(**{**fields, **given})
