"""What the figures draw: plain arrays of one episode, whoever recorded it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


class Stage(NamedTuple):
    """Stretch of constant commanded speed: begin and end (s), forward and lateral speed (m/s)."""

    begin: float
    end: float
    speed_x: float
    speed_y: float


@dataclass(frozen=True)
class LegTrace:
    """One leg of the recorded robot.

    Attributes:
        name: ``left`` or ``right``.
        joints: indices of its joints, hip to ankle.
        heel: sole frame to heel, m.
        toe: sole frame to toe, m.
        half_width: half the sole's width, m; 0 for a line.
    """

    name: str
    joints: tuple[int, ...]
    heel: float
    toe: float
    half_width: float


@dataclass(frozen=True)
class Recording:
    """One episode, sampled at n instants; SI units, radians.

    Attributes:
        title: robot and scenario, for the figures' titles.
        time: (n,) s.
        speed_command: (n, 2) forward and lateral, m/s.
        speed: (n, 2) of the CoM in the heading frame, m/s.
        tilt: (n, 2) roll and pitch of the torso, rad.
        yaw: (n,) rad.
        height_command: (n,) m.
        height: (n,) hip midpoint above the stance sole, m.
        stance: (n,) 0 left, 1 right, 2 both.
        step_count: (n,) steps taken.
        joint_names: nj names.
        joint_desired: (n, nj) rad.
        joint_position: (n, nj) rad.
        torque: (n, nj) N·m.
        torque_limit: (nj,) N·m.
        foot_desired: (n, 6) left and right sole relative to the hip midpoint, heading frame, m.
        foot_actual: (n, 6) the same, as measured.
        sole_position: (n, 6) left and right sole frame, world, m.
        torso_position: (n, 2) world, m.
        zmp: (n, 4) planned, x and y in the left and the right sole frame, m.
        tick_us: durations of control ticks, µs, from short to long; may be empty.
        tick_counts: how many ticks took so long.
        legs: left and right.
    """

    title: str
    time: Array
    speed_command: Array
    speed: Array
    tilt: Array
    yaw: Array
    height_command: Array
    height: Array
    stance: Array
    step_count: Array
    joint_names: tuple[str, ...]
    joint_desired: Array
    joint_position: Array
    torque: Array
    torque_limit: Array
    foot_desired: Array
    foot_actual: Array
    sole_position: Array
    torso_position: Array
    zmp: Array
    tick_us: Array
    tick_counts: npt.NDArray[np.int64]
    legs: tuple[LegTrace, LegTrace]

    def stages(self) -> list[Stage]:
        """Stretches of constant commanded speed, in order."""
        changes = np.any(np.diff(self.speed_command, axis=0) != 0.0, axis=1)
        starts = [0, *(np.flatnonzero(changes) + 1).tolist()]
        ends = [*starts[1:], len(self.time) - 1]
        return [
            Stage(float(self.time[a]), float(self.time[b]), *map(float, self.speed_command[a]))
            for a, b in zip(starts, ends, strict=True)
        ]

    def window(self, length: float) -> slice:
        """The last ``length`` seconds of the fastest commanded stage, where a gait shows best."""
        fastest = max(self.stages(), key=lambda stage: (np.hypot(stage.speed_x, stage.speed_y), stage.end))
        begin, end = np.searchsorted(self.time, [max(fastest.begin, fastest.end - length), fastest.end])
        return slice(int(begin), max(int(end), int(begin) + 2))
