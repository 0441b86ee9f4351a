"""A run's summary for people."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from gaitsmith.cli.dispatch import Styled, Table, Text
from gaitsmith.simulation.stage_table import STAGE_HEADINGS, run_lines, stage_row

if TYPE_CHECKING:
    from gaitsmith.robots import Robot
    from gaitsmith.simulation import Summary

_SHOWN_FAULTS = 12


def report(summary: Summary, robot: Robot, folder: Path | None, ours: bool = True) -> Iterator[Text]:
    """Stages, torques against limits, times, and what went wrong; ``ours`` is who controlled, whose falls replay."""
    title = f"{summary.robot}, preset {summary.preset}, {summary.state} state, {summary.terrain}"
    yield Table(STAGE_HEADINGS, map(stage_row, summary.stages), left=(), title=title)
    yield _joint_table(summary, robot)
    yield from closing_lines(summary)
    if summary.fall is not None:
        fall = summary.fall
        yield Styled(f"FELL at {fall.time:.2f} s, {fall.phase}: {fall.reason}", "bold red")
        if fall.cause is not None:
            tests = f"; gaitsmith why {folder} tests it" if folder and ours else ""
            yield f"likeliest cause: {fall.cause.what}{tests}"
    if summary.interrupted:
        yield Styled(f"interrupted after {summary.duration:.2f} s", "bold yellow")
    if folder is not None:
        yield f"written to {folder}"


def _joint_table(summary: Summary, robot: Robot) -> Table:
    """Torque and speed of every joint against their limits."""
    headings = (
        *("joint", "torque\nN·m", "limit\nN·m", "of limit", "at limit\nof ticks", "largest step\nN·m in 1 tick"),
        *("speed\nrad/s", "limit\nrad/s", "over limit\nof ticks"),
    )
    rows = []
    for name, most, fastest in zip(robot.joint_names, robot.torque_limit, robot.velocity_limit, strict=True):
        peak = summary.torque_peak[name]
        torque = (f"{peak:.1f}", f"{most:.0f}", f"{100 * peak / most:.0f} %")
        steps = (f"{100 * summary.torque_saturated[name]:.2f} %", f"{summary.torque_step_max[name]:.1f}")
        speed = (f"{summary.velocity_peak[name]:.2f}", f"{fastest:.1f}", f"{100 * summary.velocity_over[name]:.2f} %")
        rows.append((name, *torque, *steps, *speed))
    over = {name for shares in (summary.torque_saturated, summary.velocity_over) for name in shares if shares[name]}
    return Table(headings, rows, title="joints", red=over)


def closing_lines(summary: Summary) -> list[str]:
    """Everything else, a line each."""
    lines = run_lines(summary)
    if summary.log is not None:
        lines.append(f"log: {summary.log.rows} rows, {summary.log.dropped} dropped")
    lines += [f"{f.time:.3f} s: {f.component}, {f.type}: {f.reaction}" for f in summary.faults[:_SHOWN_FAULTS]]
    if len(summary.faults) > _SHOWN_FAULTS:
        lines.append(f"{len(summary.faults) - _SHOWN_FAULTS} more faults in the summary")
    refused = ", ".join(f"{count} of {sensor}" for sensor, count in summary.refused.items() if count)
    if refused:
        lines.append(f"ticks with replaced readings: {refused}")
    return lines + [f"physics engine: {warning}" for warning in summary.warnings]
