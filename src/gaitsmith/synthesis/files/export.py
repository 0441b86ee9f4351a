"""A gait as rows of numbers: CSV for tables and scripts, MCAP for Foxglove and the ROS 2 tools."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.files import regular_target
from gaitsmith.log.record import Log
from gaitsmith.log.table import write_table
from gaitsmith.robots import Robot
from gaitsmith.synthesis.gaits.gait import Gait
from gaitsmith.synthesis.gaits.unrolled import UnrolledGait

Array = npt.NDArray[np.float64]
FORMATS = ("csv", "mcap")
LARGEST = 20_000_000  # numbers in a file, rows times columns
_BLOCK = 2_000  # rows computed at a time
_Report = Callable[[int, int], None]
_AXES = ("x", "y", "z")


def column_names(joints: tuple[str, ...]) -> list[str]:
    """Names with units, in the order of :func:`gait_rows`."""
    found = ["time [s]"]
    found += [f"base_position_{a} [m]" for a in _AXES] + [f"base_quaternion_{a} [-]" for a in ("w", *_AXES)]
    found += [f"{name}_position [rad]" for name in joints]
    found += [f"base_linear_velocity_{a} [m/s]" for a in _AXES] + [f"base_angular_velocity_{a} [rad/s]" for a in _AXES]
    found += [f"{name}_velocity [rad/s]" for name in joints]
    found += [f"base_linear_acceleration_{a} [m/s^2]" for a in _AXES]
    found += [f"base_angular_acceleration_{a} [rad/s^2]" for a in _AXES]
    found += [f"{name}_acceleration [rad/s^2]" for name in joints]
    found += [f"{name}_torque [N.m]" for name in joints]
    for side in ("left", "right"):
        found += [f"{side}_contact_force_{a} [N]" for a in _AXES] + [f"{side}_contact_moment_{a} [N.m]" for a in _AXES]
    return found


def _blocks(whole: UnrolledGait, count: int, rate: float, report: _Report | None) -> Iterator[Array]:
    """The rows, some at a time."""
    for first in range(0, count, _BLOCK):
        times = np.arange(first, min(first + _BLOCK, count)) / rate
        found = whole.at(np.minimum(times, whole.duration))
        parts = (found.position, found.velocity, found.acceleration, found.torque, found.wrench)
        yield np.concatenate([times[:, None], *parts], axis=1)
        if report is not None:
            report(first + len(times), count)


def _prepared(gait: Gait, robot: Robot, rate: float, steps: int) -> tuple[UnrolledGait, int]:
    """What the rows come from, and their number."""
    if not (np.isfinite(rate) and rate > 0.0):
        raise BadInput("--rate", rate, "a positive number of rows per second")
    whole, columns = UnrolledGait(gait, robot, steps), len(column_names(robot.joint_names))
    most = LARGEST // columns
    count = np.floor(whole.duration * rate * (1.0 + 1e-12)) + 1.0
    if count > most:
        valid = f"at most {(most - 1) / whole.duration:.6g} for {whole.duration:g} s"
        raise BadInput("--rate", rate, valid, f"a file holds {most} rows of {columns} numbers at most")
    return whole, int(count)


def gait_rows(gait: Gait, robot: Robot, rate: float, steps: int = 1, report: _Report | None = None) -> Array:
    """(N, columns) rows at a fixed rate, both ends of the motion included where the rate allows.

    Time; base position and quaternion w x y z; joint angles; base linear (world) and angular (body) velocity; joint
    velocities; the accelerations likewise; joint torques; left, then right contact wrench about the sole frame's
    origin, world axes.

    Args:
        gait: the gait.
        robot: the robot that it was planned for.
        rate: Hz.
        steps: of a cyclic gait.
        report: called with the number of rows done, and of all.

    Raises:
        BadInput: a rate that is not positive or gives more than twenty million numbers, or too many steps.
    """
    whole, count = _prepared(gait, robot, rate, steps)
    return np.concatenate(list(_blocks(whole, count, rate, report)))


def export_gait(
    gait: Gait, robot: Robot, path: Path, form: str, rate: float, steps: int = 1, report: _Report | None = None
) -> int:
    """Write a gait's rows, whole or not at all; returns their number.

    Args:
        gait, robot, rate, steps, report: as for :func:`gait_rows`.
        path: the file.
        form: csv or mcap.

    Raises:
        BadInput: an unknown format, a rate or a number of steps that cannot be used, or a file that cannot be written.
    """
    if form not in FORMATS:
        raise BadInput("--format", form, f"one of {', '.join(FORMATS)}")
    regular_target(path)
    names = column_names(robot.joint_names)
    if form == "csv":
        whole, count = _prepared(gait, robot, rate, steps)
        write_table(path, names, _blocks(whole, count, rate, report))
        return count
    rows = gait_rows(gait, robot, rate, steps, report)
    notes = {"robot": gait.robot, "motion": gait.motion.name, "rate": rate}
    Log(("time", *names[1:]), rows, notes=notes).write(path)
    return len(rows)
