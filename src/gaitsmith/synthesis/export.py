"""A gait as rows of numbers: CSV for tables and scripts, MCAP for Foxglove and the ROS 2 tools."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.files import write_text_atomic
from gaitsmith.robots import Robot
from gaitsmith.simulation.record import Log
from gaitsmith.synthesis.biped import biped_from
from gaitsmith.synthesis.full_state import StateFinder
from gaitsmith.synthesis.gait import Gait, unrolled

Array = npt.NDArray[np.float64]
FORMATS = ("csv", "mcap")
_LARGEST = 2_000_000  # rows
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


def gait_rows(gait: Gait, robot: Robot, rate: float, steps: int = 1) -> Array:
    """(N, columns) rows at a fixed rate, both ends of the motion included where the rate allows.

    Time; base position and quaternion w x y z; joint angles; base linear (world) and angular (body) velocity; joint
    velocities; the accelerations likewise; joint torques; left, then right contact wrench about the sole frame's
    origin, world axes.

    Args:
        gait: the gait.
        robot: the robot that it was planned for.
        rate: Hz.
        steps: of a cyclic gait.

    Raises:
        BadInput: a rate that is not positive or gives more than two million rows.
    """
    if not (np.isfinite(rate) and rate > 0.0):
        raise BadInput("--rate", rate, "a positive number of rows per second")
    biped = biped_from(robot)
    whole = unrolled(gait, biped.partner, biped.sign, steps)
    count = int(np.floor(whole.duration * rate * (1.0 + 1e-12))) + 1
    if count > _LARGEST:
        raise BadInput("--rate", rate, f"at most {_LARGEST / whole.duration:.6g} for {whole.duration:g} s")
    times = np.arange(count) / rate
    finder, borders = StateFinder(robot), whole.motion.borders
    index = np.clip(np.searchsorted(borders, times, side="right") - 1, 0, len(borders) - 2)
    rows = np.zeros((count, len(column_names(robot.joint_names))))
    nq, nv = robot.model.nq, robot.model.nv
    for number, phase in enumerate(whole.motion.phases):
        mask = np.flatnonzero(index == number)
        if len(mask) == 0:
            continue
        q, v, a = whole.joints(number, times[mask])
        torque, wrench = whole.torques(number, times[mask]), whole.wrenches(number, times[mask])
        for k, row in enumerate(mask):
            state = finder.find(phase.support, phase.foothold, q[:, k], v[:, k], a[:, k])
            rows[row, 1 : 1 + nq] = state.position
            rows[row, 1 + nq : 1 + nq + nv] = state.velocity
            rows[row, 1 + nq + nv : 1 + nq + 2 * nv] = state.acceleration
        rows[mask, 1 + nq + 2 * nv :] = np.vstack([torque, wrench]).T
    rows[:, 0] = times
    return rows


def export_gait(gait: Gait, robot: Robot, path: Path, form: str, rate: float, steps: int = 1) -> int:
    """Write a gait's rows, whole or not at all; returns their number.

    Raises:
        BadInput: an unknown format, a rate that cannot be used, or a file that cannot be written.
    """
    if form not in FORMATS:
        raise BadInput("--format", form, f"one of {', '.join(FORMATS)}")
    rows = gait_rows(gait, robot, rate, steps)
    names = column_names(robot.joint_names)
    if form == "csv":
        lines = [",".join(names)] + [",".join(repr(value) for value in row) for row in rows.tolist()]
        write_text_atomic(path, "\n".join(lines) + "\n")
    else:
        notes = {"robot": gait.robot, "motion": gait.motion.name, "rate": rate}
        Log(("time", *names[1:]), rows, notes=notes).write(path)
    return len(rows)
