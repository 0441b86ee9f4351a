"""Steps of a walk, from its log: how long, how far, how high, and what was told."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gaitsmith.reports.run import Run

_SETTLE = 4  # steps after a change that are not counted


@dataclass(frozen=True)
class Step:
    """A step that has ended.

    Attributes:
        time: of touchdown, s.
        side: of the leg that swung, 0 left.
        duration, period: that it took and that was told, s.
        length: of this foothold ahead of the other, along the heading, m.
        speed, height, lift: told, m/s and m.
        hip: mean height of the hips above the stance sole, m.
        raised: height of the swing sole above the stance sole at its highest, m.
        since: steps since the last change of what is told.
    """

    time: float
    side: int
    duration: float
    period: float
    length: float
    speed: float
    height: float
    lift: float
    hip: float
    raised: float
    since: int


def steps_of(run: Run) -> list[Step]:
    """All steps between two touchdowns of a walk by the template."""
    log, record = run.log, run.recording
    told = {name: log.column(f"command.{name}") for name in ("period", "height", "lift", "speed_x")}
    ends = np.flatnonzero((np.diff(record.stance) != 0.0) & record.walking[1:] & (record.stance[1:] < 2)) + 1
    found: list[Step] = []
    before, since = None, 0
    for first, last in pairwise(ends):
        side = int(record.stance[last])
        now = tuple(float(values[last - 1]) for values in told.values())
        since = since + 1 if now == before else 0
        before = now
        other, own = 3 * (1 - side), 3 * side
        heading = np.array([np.cos(record.yaw[last]), np.sin(record.yaw[last])])
        ahead = record.sole_position[last, own : own + 2] - record.sole_position[last, other : other + 2]
        swing, stance = record.sole_position[first:last, own + 2], record.sole_position[first:last, other + 2]
        found.append(
            Step(
                time=float(record.time[last]),
                side=side,
                duration=float(log.column("step_duration")[last]),
                period=now[0],
                length=float(ahead @ heading),
                speed=now[3],
                height=now[1],
                lift=now[2],
                hip=float(np.mean(record.height[first:last])),
                raised=float(swing.max() - np.mean(stance)),  # a sole that lands may be on its heel or toe
                since=since,
            )
        )
    return found


def settled(steps: list[Step]) -> list[Step]:
    """Those that come a few steps after a change."""
    return [step for step in steps if step.since >= _SETTLE]
