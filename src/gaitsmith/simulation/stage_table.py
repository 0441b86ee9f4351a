"""Stages, steps and pushes of a run in words, for terminals and pages."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gaitsmith.simulation.summary import Stage, Summary

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
