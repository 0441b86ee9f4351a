"""Where each swing foot landed, against where it was told to land when it touched down."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from gaitsmith.view.canvas import LEFT, LIMIT, RIGHT, above, figure, mark_events
from gaitsmith.view.recording import Array, Recording


class Landing(NamedTuple):
    """A touchdown: time, s, side (0 left), sole in the world as told and as it came, (2,) m, and told minus came.

    ``error`` is in the heading frame: forward and to the left, m.
    """

    time: float
    side: int
    told: Array
    came: Array
    error: Array


def landings(recording: Recording) -> list[Landing]:
    """Every touchdown of a walk by the template: the sole that becomes the stance sole, in the last row before."""
    stance, found = recording.stance, []
    for row in np.flatnonzero(np.diff(stance) != 0.0):
        side = int(stance[row + 1])
        if side > 1 or stance[row] != 1 - side or not recording.walking[row]:
            continue
        error = recording.foothold[row] - recording.foot_actual[row, 3 * side : 3 * side + 2]
        cos, sin = np.cos(recording.yaw[row]), np.sin(recording.yaw[row])
        came = recording.sole_position[row + 1, 3 * side : 3 * side + 2]
        told = recording.sole_position[row, 3 * side : 3 * side + 2] + np.array(
            [cos * error[0] - sin * error[1], sin * error[0] + cos * error[1]]
        )
        found.append(Landing(float(recording.time[row + 1]), side, told, came, error))
    return found


def draw_landings(recording: Recording) -> Figure:
    """By how much each swing sole missed the place that it was told, forward and to the left, over time."""
    found = landings(recording)
    times, sides = np.array([item.time for item in found]), np.array([item.side for item in found])
    errors = -1e3 * np.array([item.error for item in found]).reshape(-1, 2)
    what = f"landing minus foothold that was told, {len(found)} steps"
    with figure(f"{recording.title}: {what}", 5.2, recording.conditions) as made:
        axes = made.subplots(2, 1, sharex=True)
        for column, (axis, name) in enumerate(zip(axes, ("forward", "to the left"), strict=True)):
            axis.axhline(0.0, color=LIMIT, linewidth=1.0)
            for side, (leg, colour) in enumerate(zip(recording.robot.legs, (LEFT, RIGHT), strict=True)):
                mine = sides == side
                axis.plot(times[mine], errors[mine, column], "o", ms=4.0, color=colour, label=f"{leg.name} sole")
            if len(found):
                rms = float(np.sqrt(np.mean(errors[:, column] ** 2)))
                axis.set_title(f"{name}   rms {rms:.1f} mm", fontsize=11.0)
            axis.set_ylabel("mm")
        axes[-1].set_xlabel("time of touchdown, s")
        axes[-1].set_xlim(float(recording.time[0]), float(recording.time[-1]))
        above(axes[0], 2)
        mark_events(axes, recording)
    return made
