"""What the figures draw: plain arrays of one run, read from its log."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from gaitsmith.log import Log
from gaitsmith.robots import Robot

Array = npt.NDArray[np.float64]
_SIDES, _AXES = ("left", "right"), ("x", "y", "z")


class Stage(NamedTuple):
    """Stretch of constant commanded speed: begin and end (s), forward and lateral speed (m/s)."""

    begin: float
    end: float
    speed_x: float
    speed_y: float


class Recording:
    """One run, sampled at n instants; SI units, radians.

    Args:
        log: of the run; speed, attitude and places are the true ones, or those believed where nobody knew the truth.
        robot: that walked; gives joint names, limits and soles.
        ticks: durations of control ticks, µs, from short to long, and how many took so long, if they are known.

    Attributes:
        title: robot and scenario, for the figures' titles.
        time: (n,) s.
        speed_command, speed: (n, 2) forward and lateral, of the CoM in the heading frame, m/s.
        tilt: (n, 2) roll and pitch of the torso, rad.
        yaw: (n,) rad.
        height_command, height: (n,) hip midpoint above the stance sole, m.
        stance: (n,) 0 left, 1 right, 2 both.
        joint_desired, joint_position: (n, nj) rad.
        torque: (n, nj) N·m.
        foot_desired, foot_actual: (n, 6) left and right sole relative to the hip midpoint, heading frame, m.
        sole_position: (n, 6) left and right sole frame, world, m.
        torso_position: (n, 2) world, m.
        zmp: (n, 4) planned, x and y in the left and the right sole frame, m.

    Raises:
        BadInput: a column is missing from the log.
    """

    def __init__(
        self,
        log: Log,
        robot: Robot,
        ticks: tuple[Array, npt.NDArray[np.int64]] = (np.zeros(0), np.zeros(0, dtype=np.int64)),
    ) -> None:
        def columns(*names: str) -> Array:
            return np.column_stack([log.column(name) for name in names])

        def per_joint(field: str) -> Array:
            return columns(*(f"{field}.{name}" for name in robot.joint_names))

        true = "true." if "true.torso_yaw" in log.columns else "believed."
        ends = [f"{side}.{axis}" for side in _SIDES for axis in _AXES]
        left, right = log.column(true + "hip_height_left"), log.column(true + "hip_height_right")
        self.robot, self.title, self.time = robot, robot.card.name, log.time
        self.tick_us, self.tick_counts = ticks
        self.speed_command = columns("command.speed_x", "command.speed_y") * (log.column("mode") != 0.0)[:, None]
        self.speed = columns(true + "com_velocity_x", true + "com_velocity_y")
        self.tilt = columns(true + "torso_roll", true + "torso_pitch")
        self.yaw = log.column(true + "torso_yaw")
        self.stance = log.column("stance")
        self.height_command = log.column("command.height")
        self.height = np.choose(np.clip(self.stance, 0, 2).astype(int), [left, right, 0.5 * (left + right)])
        self.joint_desired, self.joint_position = per_joint("joint_desired"), per_joint("joint_position")
        self.torque = per_joint("torque")
        self.foot_desired = columns(*(f"foot_desired.{end}" for end in ends))
        self.foot_actual = columns(*(f"foot_actual.{end}" for end in ends))
        self.sole_position = columns(*(f"{true}{side}_sole_{axis}" for side in _SIDES for axis in _AXES))
        self.torso_position = columns(true + "torso_x", true + "torso_y")
        self.zmp = columns("zmp.left.x", "zmp.left.y", "zmp.right.x", "zmp.right.y")

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
