"""Top view: where the soles stood, the torso's path, and the planned ZMP."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from gaitsmith.view.canvas import COMMAND, LEFT, RIGHT, THIRD, above, figure, sampled, sole_corners
from gaitsmith.view.recording import Array, Recording

_PLOT_SHAPE = 2.6  # width over height of the plot, to find the scale of its axes
_ALIKE = 1.5  # a larger ratio of the scales is drawn as it is, and said
_GAP = 0.05  # m: a ZMP that jumps farther starts a new curve


def draw_footprints(recording: Recording) -> Figure:
    """Soles at the middle of every stance, the torso's path, and the planned ZMP, seen from above."""
    with figure(f"{recording.title}: footprints from above", 4.8) as made:
        axis = made.subplots()
        for side, colour in enumerate((LEFT, RIGHT)):
            leg = recording.robot.legs[side]
            shape = sole_corners(leg.sole)
            places = [_placed(recording, side, np.array([index]), shape) for index in _stances(recording, side)]
            axis.add_collection(PolyCollection(places, facecolors=f"{colour}55", edgecolors=colour, linewidths=1.0))
            axis.plot([], [], color=colour, linewidth=4.0, alpha=0.6, label=f"{leg.name} sole")
        zmp = _zmp_path(recording)
        axis.plot(zmp[:, 0], zmp[:, 1], color=THIRD, linewidth=1.4, zorder=3, label="planned ZMP")
        path = recording.torso_position[sampled(recording)]
        axis.plot(path[:, 0], path[:, 1], color=COMMAND, linewidth=1.2, label="torso")
        stretch = _frame(axis, recording)
        note = f"   (drawn {stretch:.0f} times larger than x)" if stretch > 1.0 else ""
        axis.set(xlabel="x, m", ylabel=f"y, m{note}")
        above(axis, 4)
    return made


def _frame(axis: Axes, recording: Recording) -> float:
    """Set the axes' limits around all footholds; how many times larger y is drawn than x, 1 if alike."""
    soles = recording.sole_position.reshape(-1, 2, 3)
    low = soles.min(axis=(0, 1))[:2] - np.array([0.25, 0.12])
    high = soles.max(axis=(0, 1))[:2] + np.array([0.35, 0.12])
    length, breadth = high - low
    stretch = float(length / breadth / _PLOT_SHAPE)
    if stretch < _ALIKE:
        length, breadth = max(length, _PLOT_SHAPE * breadth), max(breadth, length / _PLOT_SHAPE)
        axis.set_aspect("equal", adjustable="box")
        stretch = 1.0
    middle = (low + high) / 2
    axis.set_xlim(middle[0] - length / 2, middle[0] + length / 2)
    axis.set_ylim(middle[1] - breadth / 2, middle[1] + breadth / 2)
    return stretch


def _stances(recording: Recording, side: int) -> list[int]:
    """One sample in the middle of every stretch in which a leg is the stance leg, or both are."""
    standing = (recording.stance == side) | (recording.stance == 2)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], standing, [False]]).astype(int)))
    return [int(a + (b - a) // 2) for a, b in edges.reshape(-1, 2)]


def _placed(recording: Recording, side: int, index: npt.NDArray[np.int64], points: Array) -> Array:
    """Points of the sole frame in the world; the sole is taken to head where the torso does."""
    cos, sin = np.cos(recording.yaw[index]), np.sin(recording.yaw[index])
    origin = recording.sole_position[index, 3 * side : 3 * side + 2]
    x, y = points[:, 0], points[:, 1]
    return origin + np.stack([cos * x - sin * y, sin * x + cos * y], axis=1)


def _zmp_path(recording: Recording) -> Array:
    """Planned ZMP under the stance sole in the world, broken where it jumps to the other sole, (m, 2)."""
    at = np.arange(len(recording.time))[sampled(recording)]
    path = np.full((len(at), 2), np.nan)
    for side in (0, 1):
        mine = recording.stance[at] == side
        index = at[mine]
        if len(index):
            path[mine] = _placed(recording, side, index, recording.zmp[index, 2 * side : 2 * side + 2])
    jumps = np.flatnonzero(np.hypot(*np.diff(path, axis=0).T) > _GAP)
    path[jumps] = np.nan
    return path
