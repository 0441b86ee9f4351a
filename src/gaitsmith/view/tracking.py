"""Desired against actual over time: speed and attitude, height, joints, feet, torques (Han 2023, Figs. 5-7 and 9)."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from gaitsmith.view.canvas import (
    COMMAND,
    LEFT,
    LIMIT,
    RIGHT,
    THIRD,
    above,
    figure,
    mark_stages,
    rms,
    sampled,
)
from gaitsmith.view.recording import Recording

_GAIT_WINDOW = 3.0  # s: a few strides


def draw_speed(recording: Recording) -> Figure:
    """Commanded and actual CoM speed, and the torso's roll and pitch below (Fig. 5)."""
    at = sampled(recording)
    time = recording.time[at]
    with figure(f"{recording.title}: speed and attitude", 7.5) as made:
        forward, lateral, attitude = made.subplots(3, 1, sharex=True, height_ratios=(2.2, 1.2, 1.2))
        for axis, column, colour, name in ((forward, 0, LEFT, "forward"), (lateral, 1, LEFT, "lateral")):
            axis.plot(time, recording.speed[at, column], color=colour, label="actual", linewidth=1.0)
            axis.plot(time, recording.speed_command[at, column], color=COMMAND, label="commanded", linestyle="--")
            axis.set_ylabel(f"{name}\nm/s")
        attitude.plot(time, np.degrees(recording.tilt[at, 0]), color=RIGHT, label="roll", linewidth=1.0)
        attitude.plot(time, np.degrees(recording.tilt[at, 1]), color=THIRD, label="pitch", linewidth=1.0)
        attitude.set_ylabel("torso tilt\n°")
        attitude.set_xlabel("time, s")
        attitude.set_xlim(float(time[0]), float(time[-1]))
        above(forward, 2)
        above(attitude, 2)
        mark_stages([forward, lateral, attitude], recording)
    return made


def draw_height(recording: Recording) -> Figure:
    """Commanded and actual height of the hip midpoint above the stance sole (Fig. 7)."""
    at = sampled(recording)
    time = recording.time[at]
    with figure(f"{recording.title}: hip height above the stance sole", 4.2) as made:
        axis = made.subplots()
        axis.plot(time, recording.height[at], color=LEFT, label="actual", linewidth=1.0)
        axis.plot(time, recording.height_command[at], color=COMMAND, label="commanded", linestyle="--")
        middle = 0.5 * (recording.height_command.min() + recording.height_command.max())
        half = max(0.05, 0.75 * float(np.ptp(recording.height_command)))  # a few mm must not fill the plot
        reach = float(np.max(np.abs(recording.height - middle)))
        axis.set_ylim(middle - max(half, min(reach, 0.3)), middle + max(half, min(reach, 0.3)))
        axis.set(xlabel="time, s", ylabel="height, m", xlim=(float(time[0]), float(time[-1])))
        above(axis, 2)
        mark_stages([axis], recording)
    return made


def draw_joints(recording: Recording) -> Figure:
    """Desired and actual joint angles of the left leg over a few strides at the highest speed (Fig. 6)."""
    at = sampled(recording, recording.window(_GAIT_WINDOW))
    time = recording.time[at]
    leg = recording.legs[0]
    rows = len(leg.joints)
    with figure(f"{recording.title}: joints of the {leg.name} leg", 1.2 + 1.5 * rows) as made:
        axes = np.atleast_1d(made.subplots(rows, 1, sharex=True))
        for axis, joint in zip(axes, leg.joints, strict=True):
            desired, actual = recording.joint_desired[at, joint], recording.joint_position[at, joint]
            axis.plot(time, np.degrees(actual), color=LEFT, label="actual")
            axis.plot(time, np.degrees(desired), color=COMMAND, label="desired", linestyle="--", linewidth=1.2)
            axis.set_ylabel("angle, °")
            axis.set_title(f"{recording.joint_names[joint]}   rms error {np.degrees(rms(desired - actual)):.2f}°")
        above(axes[0], 2)
        axes[-1].set_xlabel("time, s")
        axes[-1].set_xlim(float(time[0]), float(time[-1]))
    return made


def draw_feet(recording: Recording) -> Figure:
    """Desired and actual sole positions relative to the hip midpoint over a few strides (Fig. 9)."""
    at = sampled(recording, recording.window(_GAIT_WINDOW))
    time = recording.time[at]
    with figure(f"{recording.title}: soles relative to the hip midpoint, heading frame", 7.5) as made:
        axes = made.subplots(3, 1, sharex=True)
        for row, (axis, name) in enumerate(zip(axes, ("x, forward", "y, left", "z, up"), strict=True)):
            for side, colour in enumerate((LEFT, RIGHT)):
                column = 3 * side + row
                label = recording.legs[side].name
                axis.plot(time, recording.foot_actual[at, column], color=colour, label=f"{label}, actual")
                axis.plot(
                    time,
                    recording.foot_desired[at, column],
                    color=COMMAND,
                    label="desired" if side else None,
                    linestyle="--",
                    linewidth=1.2,
                )
            axis.set_ylabel(f"{name}\nm")
        above(axes[0], 3)
        axes[-1].set_xlabel("time, s")
        axes[-1].set_xlim(float(time[0]), float(time[-1]))
    return made


def draw_torques(recording: Recording) -> Figure:
    """Torques of both legs' joints, left and right in one panel, with their limits."""
    at = sampled(recording)
    time = recording.time[at]
    left, right = recording.legs
    rows = len(left.joints)
    with figure(f"{recording.title}: joint torques and their limits", 1.2 + 1.6 * rows) as made:
        axes = np.atleast_1d(made.subplots(rows, 1, sharex=True))
        for axis, a, b in zip(axes, left.joints, right.joints, strict=True):
            axis.plot(time, recording.torque[at, a], color=LEFT, label="left", linewidth=0.7)
            axis.plot(time, recording.torque[at, b], color=RIGHT, label="right", linewidth=0.7, alpha=0.8)
            limit = max(float(recording.torque_limit[a]), float(recording.torque_limit[b]))
            for bound in (-limit, limit):
                axis.axhline(bound, color=LIMIT, linestyle=":", label="limit" if bound > 0 else None)
            axis.set_ylim(-1.12 * limit, 1.12 * limit)
            axis.set_ylabel("N·m")
            names = f"{recording.joint_names[a]}, {recording.joint_names[b]}"
            axis.set_title(f"{names}   limit {limit:.0f} N·m", fontsize=11.0)
        above(axes[0], 3)
        axes[-1].set_xlabel("time, s")
        axes[-1].set_xlim(float(time[0]), float(time[-1]))
    return made
