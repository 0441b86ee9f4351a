"""Figures 5 to 11 of the gait template's paper, in its layout: the reference is red, what was is blue."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitsmith.reproduction.steps import Step
from gaitsmith.view.canvas import BAND, COMMAND, LEFT, RIGHT, THIRD, above, figure, in_words, sampled
from gaitsmith.view.recording import Recording

Array = npt.NDArray[np.float64]
_TOLD, _WAS = RIGHT, LEFT
_STRIDES = 3.0  # s that a figure of strides shows


@contextmanager
def _panels(record: Recording, title: str, rows: int, height: float) -> Iterator[tuple[Figure, list[Axes]]]:
    with figure(title, height, f"{record.title}; {record.conditions}") as made:
        axes = list(np.atleast_1d(made.subplots(rows, 1, sharex=True)))
        yield made, axes
        axes[-1].set_xlabel("time, s")


def _pair(axis: Axes, time: Array, told: Array, was: Array, label: str) -> None:
    axis.plot(time, was, color=_WAS, linewidth=1.0, label="actual")
    axis.plot(time, told, color=_TOLD, linewidth=1.4, linestyle="--", label="reference")
    axis.set_ylabel(label)


def speed_and_attitude(record: Recording, title: str) -> Figure:
    """Fig. 5, Fig. 8: forward and lateral speed, then roll and pitch."""
    at = sampled(record)
    time = record.time[at]
    with _panels(record, title, 3, 7.0) as (made, axes):
        for column, name in enumerate(("v_x", "v_y")):
            _pair(axes[column], time, record.speed_command[at, column], record.speed[at, column], f"{name}, m/s")
        for column, (name, colour) in enumerate((("roll", THIRD), ("pitch", COMMAND))):
            axes[2].plot(time, np.degrees(record.tilt[at, column]), color=colour, linewidth=0.9, label=name)
        axes[2].set_ylabel("torso, °")
        axes[2].set_xlim(float(time[0]), float(time[-1]))
        above(axes[0], 2)
        above(axes[2], 2)
    return made


def joints(record: Recording, indices: npt.NDArray[np.int64]) -> Figure:
    """Fig. 6: the driving joints of the right leg."""
    at = sampled(record, record.window(_STRIDES))
    time = record.time[at]
    with _panels(record, "Fig. 6: joint angles of the right leg at the highest speed", len(indices), 7.5) as (
        made,
        axes,
    ):
        for axis, joint in zip(axes, indices, strict=True):
            told, was = (np.degrees(values[at, joint]) for values in (record.joint_desired, record.joint_position))
            name = in_words(record.robot.joint_names[joint]).partition(" ")[2]
            _pair(axis, time, told, was, f"{name}, °")
        axes[-1].set_xlim(float(time[0]), float(time[-1]))
        above(axes[0], 2)
    return made


def speed_and_height(record: Recording) -> Figure:
    """Fig. 7: speed and support height."""
    at = sampled(record)
    time = record.time[at]
    with _panels(record, "Fig. 7: the support height changes in steps", 2, 5.2) as (made, axes):
        _pair(axes[0], time, record.speed_command[at, 0], record.speed[at, 0], "v_x, m/s")
        _pair(axes[1], time, record.height_command[at], record.height[at], "hips above the\nstance sole, m")
        axes[-1].set_xlim(float(time[0]), float(time[-1]))
        above(axes[0], 2)
    return made


def feet(record: Recording) -> Figure:
    """Fig. 9: both soles relative to the torso, desired and actual; stance is shaded."""
    at = sampled(record, record.window(_STRIDES))
    time = record.time[at]
    with figure("Fig. 9: soles relative to the hips", 7.0, f"{record.title}; {record.conditions}") as made:
        grid = made.subplots(3, 2, sharex=True, sharey="row")
        for row, name in enumerate(("x, forward, m", "y, left, m", "z, up, m")):
            for side, axis in enumerate(grid[row]):
                column = 3 * side + row
                _pair(
                    axis,
                    time,
                    record.foot_desired[at, column],
                    record.foot_actual[at, column],
                    name if not side else "",
                )
                bears, edge = record.walking[at] & (record.stance[at] == side), axis.get_xaxis_transform()
                axis.fill_between(time, 0.0, 1.0, where=bears, transform=edge, color=BAND, zorder=0, label="stance")
        for side, leg in enumerate(record.robot.legs):
            grid[0][side].set_title(f"{leg.name} leg")
            grid[-1][side].set_xlabel("time, s")
        grid[0][0].set_xlim(float(time[0]), float(time[-1]))
        made.legend(*grid[0][0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return made


def height_and_lift(record: Recording, steps: list[Step]) -> Figure:
    """Fig. 10: the torso over the end of the right leg; support height left, lift right."""
    lifted = record.time >= next((step.time for step in steps if step.lift != steps[0].lift), record.time[-1])
    change = int(np.argmax(lifted)) if lifted.any() else len(record.time)
    with figure("Fig. 10: support height and lift", 4.6, f"{record.title}; {record.conditions}") as made:
        axes = made.subplots(1, 2, sharey=True)
        titles = ("variable support height", "variable lift")
        for axis, span, title in zip(axes, (slice(0, change), slice(change, None)), titles, strict=True):
            if len(record.time[span]) < 2:
                continue
            at = sampled(record, span)
            time = record.time[at]
            axis.plot(time, -record.foot_actual[at, 5], color=_WAS, linewidth=0.9, label="hips over the right sole")
            axis.plot(time, record.height_command[at], color=_TOLD, linestyle="--", label="reference height")
            own = [step for step in steps if step.side == 1 and time[0] <= step.time <= time[-1]]
            when = [step.time for step in own]
            axis.plot(when, [step.hip for step in own], "o", ms=4, mfc="none", color=THIRD, label="support")
            low = [step.hip - step.raised for step in own]
            axis.plot(when, low, "o", ms=4, mfc="none", color=COMMAND, label="support less lift")
            wanted = [step.height - step.lift for step in own]
            axis.plot(when, wanted, "_", ms=9, mew=1.5, color=_TOLD, label="reference less lift")
            axis.set(title=title, xlabel="time, s", xlim=(float(time[0]), float(time[-1])))
        axes[0].set_ylabel("height, m")
        made.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=5)
    return made


def cycles(steps: list[Step], record: Recording) -> Figure:
    """Fig. 11: reference and actual duration of every step."""
    with figure("Fig. 11: variable walking cycle", 4.4, f"{record.title}; {record.conditions}") as made:
        axis = made.subplots()
        numbers = np.arange(1, len(steps) + 1)
        told = [step.period for step in steps]
        axis.plot(numbers, told, "o", ms=5, mfc="none", color=_TOLD, label="reference")
        for side, marker in ((0, "."), (1, "x")):
            own = np.array([step.side == side for step in steps])
            taken = np.array([step.duration for step in steps])
            name = record.robot.legs[side].name
            axis.plot(numbers[own], taken[own], marker, ms=5, color=_WAS, label=f"actual, {name} swings")
        longest = max(*told, *(step.duration for step in steps))
        axis.set(xlabel="step", ylabel="duration, s", ylim=(0.0, 1.1 * longest))
        above(axis, 3)
    return made
