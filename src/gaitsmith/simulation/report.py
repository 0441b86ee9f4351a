"""The summary of a run, and a fall explained, from what was seen of it: while it goes or from its log."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from gaitsmith.control.state import FAULT, STATE_NAMES
from gaitsmith.log.columns import Columns
from gaitsmith.robots import Robot
from gaitsmith.simulation.fall import Cause, Fall
from gaitsmith.simulation.monitor import DIVERGED, SANK, TILTED, TOUCHED, Monitor
from gaitsmith.simulation.scenario import Scenario
from gaitsmith.simulation.summary import QpCounts, Summary

_HOW = {
    TILTED: "the torso tilted by more than 60 degrees",
    SANK: "the hip sank below half the commanded height",
    TOUCHED: "a body other than a foot touched the ground",
    DIVERGED: "simulation diverged",
}
_SHOWN = 3


def _last(columns: Columns, name: str) -> float:
    """Present value of a column; 0 where a controller does not report it."""
    found = columns.find(name)
    return 0.0 if found is None else float(found[0])


def refused_readings(columns: Columns) -> dict[str, int]:
    """Ticks in which readings were replaced, by sensor."""
    found = columns.find("refused")
    return {} if found is None else dict(zip(columns.labels("refused"), map(int, found), strict=True))


def phase_in_words(columns: Columns) -> str:
    """Stance leg and share of the step; of a robot that has been braked, those at which it was."""
    braked, walking = _last(columns, "control_state") == FAULT, _last(columns, "mode") == 1.0
    stance, period = int(_last(columns, "stance")), _last(columns, "command.period")
    legs, words = columns.labels("sole_force"), "standing"
    if (walking or braked) and stance < len(legs) and period > 0.0:
        words = f"{legs[stance]} stance, {100.0 * _last(columns, 'step_time') / period:.0f} % of the step"
    return f"{words}, then braked" if braked else words


def explain(monitor: Monitor, time: float, phase: str, refused: dict[str, int], cause: str) -> Fall:
    """The fall that a monitor has just seen.

    Args:
        time: s.
        phase: of the step, in words.
        refused: ticks with replaced readings, by sensor.
        cause: likeliest, in words.
    """
    hits = monitor.dated_hits(time)
    reason = _HOW[monitor.state]
    for k, (name, when) in enumerate(hits[: 1 + _SHOWN]):
        reason += (f"; first limit hit: {name},", f"; then {name}", f", {name}")[min(k, 2)] + f" at {when:.3f} s"
    reason += "" if hits else "; no limit was hit in the last step"
    unusable = ", ".join(f"{count} of {sensor}" for sensor, count in refused.items() if count)
    reason += f"; ticks with replaced readings: {unusable}" if unusable else ""
    return Fall(time=time, phase=phase, reason=reason, cause=Cause(what=cause))


def sum_up(scenario: Scenario, robot: Robot, monitor: Monitor, columns: Columns, **rest: Any) -> Summary:
    """A run in numbers.

    Args:
        columns: telemetry and truth as they are at the end.
        rest: fields of the summary that none of these knows.
    """
    kept, joints, true, ticks = monitor.kept, monitor.kept.joints, monitor.prefix, max(monitor.ticks, 1)

    def per_joint(values: npt.NDArray[np.float64]) -> dict[str, float]:
        return dict(zip(monitor.joint_names, values.tolist(), strict=True))

    def degrees(span: tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]) -> tuple[float, float]:
        low, high = (float(np.degrees(value[0])) for value in span)
        return (low, high) if kept.upright[0] else (0.0, 0.0)

    return Summary(
        **rest,
        fell=rest["fall"] is not None,
        robot=robot.card.name,
        **{name: getattr(scenario, name) for name in ("preset", "state", "terrain", "seed")},
        steps=int(_last(columns, "step_count")),
        stages=monitor.stages(),
        drift=_last(columns, true + "excursion"),
        distance=monitor.distance,
        yaw_deg=degrees(kept.yaws),
        heading_deg=degrees(kept.headings),
        min_foot_separation=_last(columns, true + "least_separation"),
        leg_contacts=int(_last(columns, true + "leg_contacts")),
        torque_peak=per_joint(joints.torque_peak),
        torque_saturated=per_joint(joints.torque_saturated / ticks),
        torque_step_max=per_joint(joints.torque_step),
        velocity_peak=per_joint(joints.velocity_peak),
        velocity_over=per_joint(joints.velocity_over / ticks),
        control_state=STATE_NAMES[int(_last(columns, "control_state"))],
        refused=refused_readings(columns),
        qp=QpCounts(**{name: int(_last(columns, f"qp_{name}")) for name in QpCounts.model_fields}),
    )
