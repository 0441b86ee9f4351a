"""Stages of a run as rows of a table, for terminals and pages."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gaitsmith.simulation.summary import Stage

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
