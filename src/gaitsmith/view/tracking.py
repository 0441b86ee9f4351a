"""Desired against actual over time: speed, height, joints, feet, torques (Han 2023, Figs. 5-7, 9); time of a tick."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from gaitsmith.view.canvas import COMMAND, LEFT, LIMIT, RIGHT, THIRD, above, figure, mark_events, mark_stages, sampled
from gaitsmith.view.recording import Array, Recording

_GAIT_WINDOW = 3.0  # s: a few strides
_BINS = 80  # of the histogram of durations


@contextmanager
def _panels(
    recording: Recording, what: str, time: Array, height: float, ratios: tuple[float, ...]
) -> Iterator[tuple[Figure, list[Axes]]]:
    """A figure of panels over one axis of time."""
    with figure(f"{recording.title}: {what}", height, recording.conditions) as made:
        axes = list(np.atleast_1d(made.subplots(len(ratios), 1, sharex=True, height_ratios=ratios)))
        yield made, axes
        axes[-1].set_xlabel("time, s")
        axes[-1].set_xlim(float(time[0]), float(time[-1]))


def _pair(axis: Axes, time: Array, actual: Array, wanted: Array, name: str = "commanded") -> None:
    """What was, and what was asked for."""
    axis.plot(time, actual, color=LEFT, label="actual", linewidth=1.0)
    axis.plot(time, wanted, color=COMMAND, label=name, linestyle="--")


def draw_speed(recording: Recording) -> Figure:
    """Commanded and actual CoM speed, and the torso's roll and pitch below (Fig. 5)."""
    at = sampled(recording)
    time = recording.time[at]
    with _panels(recording, "speed and attitude", time, 7.5, (2.2, 1.2, 1.2)) as (made, axes):
        for column, name in enumerate(("forward", "lateral")):
            _pair(axes[column], time, recording.speed[at, column], recording.speed_command[at, column])
            axes[column].set_ylabel(f"{name}\nm/s")
        for column, (name, colour) in enumerate((("roll", RIGHT), ("pitch", THIRD))):
            axes[2].plot(time, np.degrees(recording.tilt[at, column]), color=colour, label=name, linewidth=1.0)
        axes[2].set_ylabel("torso tilt\n°")
        above(axes[0], 2)
        above(axes[2], 2)
        mark_stages(axes, recording)
    return made


def draw_height(recording: Recording) -> Figure:
    """Commanded and actual height of the hip midpoint above the stance sole (Fig. 7)."""
    at = sampled(recording)
    time, wanted = recording.time[at], recording.height_command
    with _panels(recording, "hip height above the stance sole", time, 4.2, (1.0,)) as (made, axes):
        _pair(axes[0], time, recording.height[at], wanted[at])
        middle = 0.5 * (wanted.min() + wanted.max())
        half = max(0.05, 0.75 * float(np.ptp(wanted)))  # a few mm must not fill the plot
        half = max(half, min(float(np.max(np.abs(recording.height - middle))), 0.3))
        axes[0].set(ylabel="height, m", ylim=(middle - half, middle + half))
        above(axes[0], 2)
        mark_stages(axes, recording)
    return made


def draw_joints(recording: Recording) -> Figure:
    """Desired and actual joint angles of the left leg over a few strides at the highest speed (Fig. 6)."""
    at = sampled(recording, recording.window(_GAIT_WINDOW))
    time, leg = recording.time[at], recording.robot.legs[0]
    rows = len(leg.joints)
    with _panels(recording, f"joints of the {leg.name} leg", time, 1.2 + 1.5 * rows, (1.0,) * rows) as (made, axes):
        for axis, joint, name in zip(axes, leg.joint_indices, leg.joints, strict=True):
            wanted, actual = (np.degrees(a[at, joint]) for a in (recording.joint_desired, recording.joint_position))
            _pair(axis, time, actual, wanted, "desired")
            axis.set_ylabel("angle, °")
            axis.set_title(f"{name}   rms error {np.sqrt(np.mean((wanted - actual) ** 2)):.2f}°")
        above(axes[0], 2)
    return made


def draw_feet(recording: Recording) -> Figure:
    """Desired and actual sole positions relative to the hip midpoint over a few strides (Fig. 9)."""
    at = sampled(recording, recording.window(_GAIT_WINDOW))
    time = recording.time[at]
    what = "soles relative to the hip midpoint, heading frame"
    with _panels(recording, what, time, 7.5, (1.0,) * 3) as (made, axes):
        for row, (axis, name) in enumerate(zip(axes, ("x, forward", "y, left", "z, up"), strict=True)):
            for side, (leg, colour) in enumerate(zip(recording.robot.legs, (LEFT, RIGHT), strict=True)):
                axis.plot(time, recording.foot_actual[at, 3 * side + row], color=colour, label=f"{leg.name}, actual")
                desired = recording.foot_desired[at, 3 * side + row]
                axis.plot(time, desired, color=COMMAND, label="desired" if side else None, linestyle="--", lw=1.2)
            axis.set_ylabel(f"{name}\nm")
        above(axes[0], 3)
    return made


def draw_torques(recording: Recording) -> Figure:
    """Torques of both legs' joints, left and right in one panel, with their limits."""
    at = sampled(recording)
    time, robot = recording.time[at], recording.robot
    left, right = robot.legs
    rows = len(left.joints)
    with _panels(recording, "joint torques and their limits", time, 1.2 + 1.6 * rows, (1.0,) * rows) as (made, axes):
        for axis, a, b in zip(axes, left.joint_indices, right.joint_indices, strict=True):
            axis.plot(time, recording.torque[at, a], color=LEFT, label="left", linewidth=0.7)
            axis.plot(time, recording.torque[at, b], color=RIGHT, label="right", linewidth=0.7, alpha=0.8)
            limit = float(max(robot.torque_limit[a], robot.torque_limit[b]))
            for bound in (-limit, limit):
                axis.axhline(bound, color=LIMIT, linestyle=":", label="limit" if bound > 0 else None)
            axis.set(ylim=(-1.12 * limit, 1.12 * limit), ylabel="N·m")
            names = f"{robot.joint_names[a]}, {robot.joint_names[b]}"
            axis.set_title(f"{names}   limit {limit:.0f} N·m", fontsize=11.0)
        above(axes[0], 3)
        mark_events(axes, recording)
    return made


def draw_timing(recording: Recording) -> Figure:
    """Histogram of the tick's duration, both axes logarithmic, with median and 99th percentile."""
    ticks, counts = recording.tick_us, recording.tick_counts
    below = np.cumsum(counts)
    with figure(f"{recording.title}: duration of a control tick", 4.2) as made:
        axis = made.subplots()
        median, late = (ticks[np.searchsorted(below, share * below[-1])] for share in (0.5, 0.99))
        edges = np.geomspace(0.9 * ticks.min(), 1.1 * ticks.max(), _BINS)
        axis.hist(ticks, bins=edges.tolist(), weights=counts, color=LEFT, alpha=0.85)
        axis.axvline(median, color=RIGHT, label=f"median {median:.1f} µs")
        axis.axvline(late, color=RIGHT, linestyle="--", label=f"99 % within {late:.1f} µs")
        axis.axvline(ticks.max(), color=LIMIT, linestyle=":", label=f"longest {ticks.max():.0f} µs")
        axis.set(xlabel="duration, µs", ylabel="ticks", xscale="log", yscale="log")
        axis.xaxis.set_major_formatter("{x:g}")  # the formatters of logarithmic axes write markup
        axis.yaxis.set_major_formatter("{x:g}")
        axis.yaxis.set_minor_formatter("")
        axis.xaxis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))  # more labels would touch each other
        axis.xaxis.set_minor_formatter("{x:g}")
        above(axis, 3)
    return made
