"""A run in words, for terminals and pages: stages, distances, times, steps, pushes, a plan that was followed."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gaitsmith.simulation.summary import Stage, Summary, Tracking

_TURN = 5.0  # degrees; a smaller one is a wobble
STAGE_HEADINGS = (
    *("time\ns", "commanded\nm/s", "mean v_x\nm/s", "v_x error\nmm/s", "v_y error\nmm/s"),
    *("roll\n°", "pitch\n°", "height error\nmm", "yaw rate error\nrad/s"),
)


def stage_row(stage: Stage) -> tuple[str, ...]:
    """A stage of constant command in words."""
    command = "rest"
    if not stage.rest:
        command = f"{stage.command.vx:.2f}" + (f", {stage.command.vy:.2f}" if stage.command.vy else "")
        command += f", {stage.command.yaw_rate:+.2f} rad/s" if stage.command.yaw_rate else ""
    return (
        f"{stage.t0:.1f} to {stage.t1:.1f}",
        command,
        f"{stage.vx_mean:.4f}",
        f"{1e3 * stage.vx_error:+.1f}",
        f"{1e3 * stage.vy_error:+.1f}",
        *(f"{low:+.2f} to {high:+.2f}" for low, high in (stage.roll_deg, stage.pitch_deg)),
        f"{1e3 * stage.height_error:+.1f}",
        f"{stage.yaw_rate_error:+.3f}",
    )


def run_lines(summary: Summary) -> list[str]:
    """What was walked, how long ticks took, what the QP did, steps and pushes, and the plan; a line each."""
    tick, qp = summary.tick_us, summary.qp
    lines = [
        f"walked {summary.distance:.2f} m in {summary.steps} steps; farthest from the start {summary.drift:.3f} m; "
        f"heading {summary.heading_deg[0]:+.1f} to {summary.heading_deg[1]:+.1f}°",
        f"foot separation at least {100 * summary.min_foot_separation:.1f} cm; leg contacts {summary.leg_contacts}",
        f"tick {tick.median:.1f} µs median, {tick.p99:.1f} µs in 99 %, {tick.max:.0f} µs longest, "
        f"{tick.overruns} over the control period",
        f"whole-body QP: {qp.solves} solved, {qp.fallbacks} fallbacks, {qp.infeasible} infeasible",
        f"{summary.duration:.2f} s simulated, {summary.realtime_factor:.1f} times real time",
        *stride_lines(summary),
    ]
    return lines + ([] if summary.tracking is None else _tracking_lines(summary.tracking))


def stride_lines(summary: Summary) -> list[str]:
    """Step times, steps that could not change, and what became of every push, a line each."""
    lines, times = [], summary.step_time
    if times is not None:
        lines.append(f"steps of {times.mean:.3f} s, from {times.min:.3f} to {times.max:.3f} s")
    if summary.steps_held:
        lines.append(f"{summary.steps_held} steps stayed as they were: a gait on the way could not be planned")
    for k, (began, recovered) in enumerate(zip(summary.pushes, summary.recovered, strict=False)):
        when = "never began" if began is None else f"at {began:.2f} s, not recovered from"
        if recovered is not None:
            when = f"at {began:.2f} s, recovered from after {recovered:.2f} s"
        lines.append(f"push {k + 1} {when}")
    return lines


def _tracking_lines(tracking: Tracking) -> list[str]:
    """How well a planned gait was followed, a line each."""
    tilt, pitch, ball = tracking.tilt_deg, tracking.foot_pitch_deg, tracking.ball
    lines = [
        f"plan: {tracking.distance:.3f} of {tracking.planned_distance:.3f} m; torso off by at most "
        f"{tilt['roll']:.2f}° roll, {tilt['pitch']:.2f}° pitch; real ZMP {tracking.zmp_rms_mm:.1f} mm off (rms)"
    ]
    if abs(tracking.planned_turn_deg) > _TURN:
        lines.append(f"turn: {tracking.turn_deg:.1f} of {tracking.planned_turn_deg:.1f}°")
    if pitch is not None:
        lines.append(
            f"foot pitch: heel strike {pitch.strike:.1f} of {pitch.planned_strike:.1f}°, "
            f"toe-off {pitch.off:.1f} of {pitch.planned_off:.1f}°"
        )
    if ball is not None:
        lines.append(f"ball: {ball.speed:.2f} of {ball.planned_speed:.2f} m/s, went {ball.travel:.2f} m")
    return lines
