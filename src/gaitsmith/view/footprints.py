"""Top view: where the soles stood and when, where they were told to stand, the torso's path, the planned ZMP."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from gaitsmith.view.canvas import BAD, COMMAND, LEFT, PUSH, RIGHT, THIRD, figure, sampled, sole_corners
from gaitsmith.view.landings import landings
from gaitsmith.view.recording import Array, Recording

_LINE = 2.6  # legs' lengths along a row of the walk
_ROWS = 6  # at most; a longer walk gets longer rows
_STRAIGHT = 3.0  # length over breadth of a walk that is written in rows
_TIMES = 12  # steps of a row that can carry their times
_APART = 0.1  # m between two times of one side
_GAP = 0.05  # m: a ZMP that jumps farther starts a new curve


def draw_footprints(recording: Recording) -> Figure:
    """Soles at the middle of every stance with the time of touchdown, seen from above, to scale.

    A straight walk is written in rows, like text: its breadth would be lost beside its length.
    """
    low, high = _extent(recording)
    length, breadth = high - low
    size = float(np.max(recording.height_command)) or 1.0
    straight = length > _STRAIGHT * breadth and length > _LINE * size
    rows = min(math.ceil(length / (_LINE * size)), _ROWS) if straight else 1
    shape = breadth / (length / rows)
    height = min(2.0 + rows * max(9.0 * min(shape, 0.7), 0.9), 12.0)
    with figure(f"{recording.title}: footprints from above", height, recording.conditions) as made:
        axes = list(np.atleast_1d(made.subplots(rows, 1)))
        for row, axis in enumerate(axes):
            start = low[0] + row * length / rows
            span = _within(recording, start, start + length / rows) if rows > 1 else slice(None)
            draw_path(axis, recording, max(1, round(_steps(recording) / rows / _TIMES)), span)
            axis.set(xlim=(start, start + length / rows), ylim=(low[1], high[1]), ylabel="y, m")
            axis.set_aspect("equal", adjustable="box")
        axes[-1].set_xlabel("x, m" + (", rows from left to right, then down" if rows > 1 else ""))
        handles, labels = axes[0].get_legend_handles_labels()
        made.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return made


def draw_path(axis: Axes, recording: Recording, stride: int = 1, span: slice = slice(None)) -> None:
    """Everything of the top view on some axes; every ``stride``-th sole carries its time, s."""
    begin, end, _ = span.indices(len(recording.time))
    for side, colour in enumerate((LEFT, RIGHT)):
        leg, stood = recording.robot.legs[side], _stances(recording, side, begin, end)
        shape = sole_corners(leg.sole)
        places = [placed(recording, side, np.array([middle]), shape) for _, middle in stood]
        axis.add_collection(PolyCollection(places, facecolors=f"{colour}40", edgecolors=colour, linewidths=1.0))
        axis.plot([], [], color=colour, linewidth=4.0, alpha=0.6, label=f"{leg.name} sole, time in s")
        last, up = np.inf, side == 0
        for (first, _), corners in list(zip(stood, places, strict=True))[::stride]:
            if float(np.linalg.norm(corners.mean(axis=0) - last)) < _APART:
                continue  # the numbers would lie on each other
            last = corners.mean(axis=0)
            place = last[0], corners[:, 1].max() if up else corners[:, 1].min()
            axis.annotate(
                f"{recording.time[first]:.1f}", place,
                xytext=(0.0, 2.0 if up else -2.0), textcoords="offset points", ha="center",
                va="bottom" if up else "top", fontsize=8.0, color=colour, annotation_clip=True, clip_on=True,
            )  # fmt: skip
    told = [item for item in landings(recording) if recording.time[begin] <= item.time <= recording.time[end - 1]]
    if told:
        x, y = np.array([item.told for item in told]).T
        axis.plot(x, y, "x", color=COMMAND, markersize=5.0, markeredgewidth=1.2, zorder=4, label="told to land")
        x, y = np.array([item.came for item in told]).T
        axis.plot(x, y, ".", color=COMMAND, markersize=4.0, zorder=4, label="landed")
    zmp = _zmp_path(recording, span)
    axis.plot(zmp[:, 0], zmp[:, 1], color=THIRD, linewidth=1.2, zorder=3, label="planned ZMP")
    path = recording.torso_position[sampled(recording, span)]
    axis.plot(path[:, 0], path[:, 1], color=COMMAND, linewidth=1.0, label="torso")
    for push in recording.pushes:
        at = int(np.searchsorted(recording.time, push.begin))
        if begin <= at < end:
            x, y = recording.torso_position[at]
            reach = 0.25 * np.array(push.impulse[:2]) / max(float(np.linalg.norm(push.impulse)), 1e-9)
            arrow = {"arrowstyle": "->", "color": PUSH, "linewidth": 2.0, "shrinkA": 0.0}
            axis.annotate("", (x + reach[0], y + reach[1]), xytext=(x, y), arrowprops=arrow, annotation_clip=True)
            axis.annotate(f"push {push.words}", (x, y), xytext=(6.0, 6.0), textcoords="offset points", color=PUSH,
                          fontsize=9.0, clip_on=True)  # fmt: skip
    if recording.fell is not None and end == len(recording.time):
        axis.plot(*recording.torso_position[-1], "X", color=BAD, markersize=10.0, zorder=5, label="fell")


def _within(recording: Recording, low: float, high: float) -> slice:
    """Samples from the first to the last with a sole between two x, m."""
    rim = recording.robot.legs[0].sole.toe
    x = recording.sole_position[:, [0, 3]]
    seen = np.flatnonzero(np.any((x > low - rim) & (x < high + rim), axis=1))
    return slice(int(seen[0]), int(seen[-1]) + 1) if len(seen) else slice(0, 1)


def _steps(recording: Recording) -> int:
    """Stances that can carry a time."""
    return max(sum(len(_stances(recording, side)) for side in (0, 1)), 1)


def _extent(recording: Recording) -> tuple[Array, Array]:
    """Lowest and highest x and y of all soles, with a rim, m."""
    soles = recording.sole_position.reshape(-1, 2, 3)
    sole = recording.robot.legs[0].sole
    rim = np.array([sole.heel + 0.02, 0.09]), np.array([sole.toe + 0.02, 0.09])
    return soles.min(axis=(0, 1))[:2] - rim[0], soles.max(axis=(0, 1))[:2] + rim[1]


def _stances(recording: Recording, side: int, begin: int = 0, end: int | None = None) -> list[tuple[int, int]]:
    """First and middle sample of every stretch in which a leg is the stance leg, or both are."""
    stop = len(recording.time) if end is None else end
    stance = recording.stance[begin:stop]
    standing = (stance == side) | (stance == 2)
    edges = begin + np.flatnonzero(np.diff(np.concatenate([[False], standing, [False]]).astype(int)))
    return [(int(a), int(a + (b - a) // 2)) for a, b in edges.reshape(-1, 2)]


def placed(recording: Recording, side: int, index: npt.NDArray[np.int64], points: Array) -> Array:
    """Points of the sole frame in the world; the sole is taken to head where the torso does."""
    cos, sin = np.cos(recording.yaw[index]), np.sin(recording.yaw[index])
    origin = recording.sole_position[index, 3 * side : 3 * side + 2]
    x, y = points[:, 0], points[:, 1]
    return origin + np.stack([cos * x - sin * y, sin * x + cos * y], axis=1)


def _zmp_path(recording: Recording, span: slice = slice(None)) -> Array:
    """Planned ZMP under the stance sole in the world, broken where it jumps to the other sole, (m, 2)."""
    at = np.arange(len(recording.time))[sampled(recording, span)]
    path = np.full((len(at), 2), np.nan)
    for side in (0, 1):
        mine = recording.stance[at] == side
        index = at[mine]
        if len(index):
            path[mine] = placed(recording, side, index, recording.zmp[index, 2 * side : 2 * side + 2])
    jumps = np.flatnonzero(np.hypot(*np.diff(path, axis=0).T) > _GAP)
    path[jumps] = np.nan
    return path
