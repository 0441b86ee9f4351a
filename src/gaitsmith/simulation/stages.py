"""Means of a stage: over whole strides, so that what swings with the step averages out."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from gaitsmith.compiled import Vector
from gaitsmith.simulation.summary import Stage, StageCommand

SCORED = 2.0  # s at the end of a stage over which means are taken
REMEMBERED = 8.0  # s of signals kept for strides that are longer, and for those of a plan, which are all alike
ENTERED, LEFT = "entered its loop", "left its loop"  # what is told of a plan
Array = npt.NDArray[np.float64]


class Span(NamedTuple):
    """A stage before it is measured: control ticks [first, last), whether at rest, and the command.

    A plan that goes through a loop does so from tick ``loop`` on. One without a loop is measured as a whole: by its
    ``way`` ahead and to the left, m. Both are None for any other walk.
    """

    first: int
    last: int
    rest: bool
    command: StageCommand
    loop: int | None = None
    way: tuple[float, float] | None = None


def scored_window(
    first: int, last: int, touchdowns: npt.NDArray[np.int64], control_step: float, loop: int | None = None
) -> tuple[int, int]:
    """Ticks [begin, end) over which a stage's means are taken.

    The largest even number of strides (a stride is two steps) between touchdowns of the same leg that fits into the
    last 2 s of the stage, or into the last 8 s of a plan's loop, as late as possible; a single stride if no two fit;
    the latest stride of the last 8 s if none fits; else these 2 s as they are.

    Args:
        first: tick at which the stage begins.
        last: tick after its end.
        touchdowns: (m, 2) tick and new stance leg of every step, in order of time.
        control_step: s.
        loop: tick at which a plan enters its loop, None without one.
    """
    begin, earliest = (max(first, last - round(span / control_step)) for span in (SCORED, REMEMBERED))
    known = touchdowns[(touchdowns[:, 0] >= earliest) & (touchdowns[:, 0] <= last)]
    ticks = known[known[:, 0] >= (begin if loop is None else loop)]
    best: tuple[int, int, int] | None = None
    for leg in (0, 1):
        own = ticks[ticks[:, 1] == leg, 0]
        strides = len(own) - 1
        strides -= strides % 2 if strides > 1 else 0
        if strides >= 1:
            found = (strides, int(own[-1]), int(own[-1 - strides]))
            best = found if best is None else max(best, found)
    if best is not None:
        return best[2], best[1]
    for leg in known[::-1, 1][:2]:
        own = known[known[:, 1] == leg, 0]
        if len(own) > 1:
            return int(own[-2]), int(own[-1])
    return begin, last


def _range_deg(span: tuple[float, float] | Array) -> tuple[float, float]:
    """Lowest and highest in degrees."""
    return float(np.degrees(np.min(span))), float(np.degrees(np.max(span)))


class Signals(NamedTuple):
    """What stages are measured by, over ticks: CoM velocity (m/s), hip above the stance sole (m), angles (rad)."""

    speed_x: Vector
    speed_y: Vector
    height: Vector
    roll: Vector
    pitch: Vector
    heading: Vector


def _means_ahead(speed_x: Vector, speed_y: Vector, heading: Vector, turn: float) -> tuple[float, float]:
    """Mean velocity ahead and to the left of a heading that turns evenly: a torso that sways is no slower, m/s."""
    share = (np.arange(len(heading)) + 0.5) / len(heading) - 0.5
    away = heading - np.mean(heading) - turn * share
    cos, sin = np.cos(away), np.sin(away)
    return float(np.mean(cos * speed_x - sin * speed_y)), float(np.mean(sin * speed_x + cos * speed_y))


def measure_stage(
    span: Span,
    start: int,
    signals: Signals,
    touchdowns: npt.NDArray[np.int64],
    roll: tuple[float, float],
    pitch: tuple[float, float],
    turned: float,
    control_step: float,
) -> Stage:
    """A stage that has at least one tick.

    Args:
        span: of the stage.
        start: tick of the first row of the signals.
        signals: up to the stage's end, at least the last 8 s of it.
        touchdowns: (m, 2) tick and new stance leg, at least those in the last 8 s.
        roll: lowest and highest over the stage, rad.
        pitch: the same.
        turned: change of the heading over the stage, less what was commanded, rad.
        control_step: s.
    """
    first, last, rest, command, loop, way = span
    begin, end = max(first, last - round(SCORED / control_step)), last
    settled = slice(begin - start, end - start)
    if not rest:
        begin, end = scored_window(first, last, touchdowns, control_step, loop)
    scored = slice(begin - start, end - start)
    before = max(begin - 1, start, 0)
    turn = float(signals.heading[end - 1 - start] - signals.heading[before - start])
    yaw_rate = turn / (max(end - 1 - before, 1) * control_step)
    vx, vy = _means_ahead(signals.speed_x[scored], signals.speed_y[scored], signals.heading[scored], turn)
    if way is not None:
        begin, end = first, last
        vx, vy = (part / ((last - first) * control_step) for part in way)
    height = float(np.mean(signals.height[scored]))
    return Stage(
        t0=first * control_step,
        t1=last * control_step,
        rest=rest,
        command=command,
        scored=(begin * control_step, end * control_step),
        vx_mean=vx,
        vx_error=vx - command.vx,
        vy_mean=vy,
        vy_error=vy - command.vy,
        height_mean=height,
        height_error=height - command.height,
        yaw_rate_mean=yaw_rate,
        yaw_rate_error=yaw_rate - command.yaw_rate,
        heading_drift_deg=float(np.degrees(turned)),
        roll_deg=_range_deg(roll),
        pitch_deg=_range_deg(pitch),
        settled_roll_deg=_range_deg(signals.roll[settled]),
        settled_pitch_deg=_range_deg(signals.pitch[settled]),
    )
