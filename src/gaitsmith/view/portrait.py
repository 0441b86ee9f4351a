"""A robot from the front and from its left: links as lines, joint axes by role, soles, centre of mass."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from gaitsmith.view.canvas import COMMAND, LEFT, LIMIT, RIGHT, THIRD, figure

Array = NDArray[np.float64]
_COLOURS = {"roll": RIGHT, "pitch": LEFT, "yaw": THIRD, "": LIMIT}
_SHORT = 0.35  # of an axis's length: seen from its end, it is a dot


@dataclass(frozen=True)
class DrawnJoint:
    """A joint: its role in the leg (empty outside the legs), anchor and axis (3,) in the world, m."""

    name: str
    role: str
    anchor: Array
    axis: Array


@dataclass(frozen=True)
class Portrait:
    """What is drawn, in the world: x forward, y left, z up, m.

    Attributes:
        bones: (n, 2, 3) ends of the links.
        soles: (n, 3) corners of each sole.
        com: (3,) centre of mass.
        named: joints whose names are written, such as those of the left leg.
    """

    title: str
    bones: Array
    joints: Sequence[DrawnJoint]
    soles: Sequence[Array]
    com: Array
    named: Sequence[str]


def draw_portrait(portrait: Portrait) -> Figure:
    """Front view (the robot's left is on the right) and side view (it looks to the right)."""
    with figure(portrait.title, 7.0) as made:
        front, side = made.subplots(1, 2, sharey=True)
        size = float(np.ptp(portrait.bones[..., 2])) or 1.0
        for axes, across, name in ((front, 1, "from the front"), (side, 0, "from its left")):
            _view(axes, portrait, across, size)
            axes.set_title(name)
            axes.set_xlabel("y, m (left)" if across else "x, m (forward)")
        front.set_ylabel("z, m")
        _names(side, portrait, size)
        shown = {joint.role for joint in portrait.joints}
        handles = [
            Line2D([], [], color=_COLOURS[role], linewidth=3.0, label=role or "outside the legs")
            for role in _COLOURS
            if role in shown
        ]
        handles.append(Line2D([], [], color=COMMAND, linewidth=4.0, label="sole"))
        handles.append(Line2D([], [], color=COMMAND, marker="P", linestyle="", label="centre of mass"))
        made.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    return made


def _view(axes: Axes, portrait: Portrait, across: int, size: float) -> None:
    """One view: `across` is the world's axis that goes to the right."""
    pick = [across, 2]
    for bone in portrait.bones:
        axes.plot(*bone[:, pick].T, color="#C5CAD0", linewidth=5.0, solid_capstyle="round", zorder=1)
    for joint in portrait.joints:
        reach = 0.035 * size * joint.axis[pick]
        colour, anchor = _COLOURS[joint.role], joint.anchor[pick]
        if np.linalg.norm(joint.axis[pick]) < _SHORT:
            axes.plot(*anchor, marker="o", color=colour, markersize=6.0, zorder=4 if joint.role else 2)
        else:
            ends = np.array([anchor - reach, anchor + reach])
            axes.plot(*ends.T, color=colour, linewidth=3.0, zorder=3 if joint.role else 2)
    for sole in portrait.soles:
        closed = np.vstack([sole, sole[:1]])
        axes.plot(*closed[:, pick].T, color=COMMAND, linewidth=4.0, zorder=3)
    axes.plot(*portrait.com[pick], marker="P", color=COMMAND, markersize=11.0, zorder=5)
    axes.plot([portrait.com[across]] * 2, [0.0, portrait.com[2]], color=COMMAND, linewidth=0.8, linestyle=":", zorder=1)
    axes.axhline(0.0, color=LIMIT, linewidth=1.0, zorder=0)
    axes.set_aspect("equal", adjustable="datalim")


def _names(axes: Axes, portrait: Portrait, size: float) -> None:
    """Names beside the joints that are to be named, from above down, none over another."""
    wanted = [joint for joint in portrait.joints if joint.name in portrait.named]
    right = max(float(portrait.bones[..., 0].max()), *(float(joint.anchor[0]) for joint in wanted)) + 0.08 * size
    last = np.inf
    for joint in sorted(wanted, key=lambda joint: -joint.anchor[2]):
        last = min(float(joint.anchor[2]), last - 0.045 * size)
        axes.annotate(
            f"{joint.name} ({joint.role})",
            xy=(float(joint.anchor[0]), float(joint.anchor[2])),
            xytext=(right, last),
            fontsize=8.0,
            va="center",
            color=_COLOURS[joint.role],
            arrowprops={"arrowstyle": "-", "color": LIMIT, "linewidth": 0.6},
        )
