"""A run's log as what the figures draw."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from gaitsmith.log import Log
from gaitsmith.robots import Robot
from gaitsmith.view.recording import Array, LegTrace, Recording

_SIDES, _AXES = ("left", "right"), ("x", "y", "z")


def recording_of(
    log: Log, robot: Robot, ticks: tuple[Array, npt.NDArray[np.int64]] = (np.zeros(0), np.zeros(0, dtype=np.int64))
) -> Recording:
    """What the figures draw, from a log and the robot that walked.

    Args:
        log: of one run; speed, attitude and places are the true ones, or those believed where nobody knew the truth.
        robot: gives joint names, limits and soles.
        ticks: durations of control ticks, µs, and how many took so long, if they are known.

    Raises:
        BadInput: a column is missing from the log.
    """

    def columns(*names: str) -> Array:
        return np.column_stack([log.column(name) for name in names])

    def per_joint(field: str) -> Array:
        return columns(*(f"{field}.{name}" for name in robot.joint_names))

    true = "true." if "true.torso_yaw" in log.columns else "believed."
    walking = log.column("mode") != 0.0
    stance = log.column("stance")
    left, right = log.column(true + "hip_height_left"), log.column(true + "hip_height_right")
    ends = [f"{side}.{axis}" for side in _SIDES for axis in _AXES]
    return Recording(
        title=robot.card.name,
        time=log.time,
        speed_command=columns("command.speed_x", "command.speed_y") * walking[:, None],
        speed=columns(true + "com_velocity_x", true + "com_velocity_y"),
        tilt=columns(true + "torso_roll", true + "torso_pitch"),
        yaw=log.column(true + "torso_yaw"),
        height_command=log.column("command.height"),
        height=np.choose(np.clip(stance, 0, 2).astype(int), [left, right, 0.5 * (left + right)]),
        stance=stance,
        step_count=log.column("step_count"),
        joint_names=robot.joint_names,
        joint_desired=per_joint("joint_desired"),
        joint_position=per_joint("joint_position"),
        torque=per_joint("torque"),
        torque_limit=np.asarray(robot.torque_limit),
        foot_desired=columns(*(f"foot_desired.{end}" for end in ends)),
        foot_actual=columns(*(f"foot_actual.{end}" for end in ends)),
        sole_position=columns(*(f"{true}{side}_sole_{axis}" for side in _SIDES for axis in _AXES)),
        torso_position=columns(true + "torso_x", true + "torso_y"),
        zmp=columns("zmp.left.x", "zmp.left.y", "zmp.right.x", "zmp.right.y"),
        tick_us=ticks[0],
        tick_counts=ticks[1],
        legs=(_leg(robot, 0), _leg(robot, 1)),
    )


def _leg(robot: Robot, side: int) -> LegTrace:
    leg = robot.legs[side]
    joints = tuple(int(index) for index in leg.joint_indices)
    return LegTrace(leg.name, joints, leg.sole.heel, leg.sole.toe, leg.sole.half_width)
