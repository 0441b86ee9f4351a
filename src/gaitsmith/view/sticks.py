"""Stick figures of a planned gait: to scale from the side with the feet's paths, and one after the other in time."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitsmith.view.canvas import COMMAND, LEFT, LIMIT, RIGHT, THIRD, figure
from gaitsmith.view.gait_trace import GaitTrace

_DENSE = 0.055  # m between two torsos in the side view, in legs of half a metre; scaled with the robot
_SHOTS = 12  # figures one after the other
_FEW = 6  # borders of a motion that is shown at its borders
_WALKS = 0.3  # of the robot's height: travelled, from which one side view shows the motion
_BALL = 0.05  # m, radius


def draw_sticks(trace: GaitTrace) -> Figure:
    """From the side and from the front."""
    size = float(trace.head[:, 2].max())
    walks = travel(trace) > _WALKS * size
    heights = [9.3 * 1.2 * size / _breadth(trace, axis) for axis in (0, 1)]
    if walks:
        heights[0] = min(9.3 * 1.2 * size / (travel(trace) + 0.6 * size), 5.0)
    with figure(f"{trace.title}, stick figures", sum(heights) + 2.4, trace.conditions) as made:
        side, front = made.subplots(2, 1, height_ratios=heights)
        if walks:
            draw_side(side, trace)
            side.set_title("from the side, light to dark in time")
        else:
            draw_shots(side, trace, 0)
            side.set_title("from the side, one after the other")
        draw_shots(front, trace, 1)
        front.set_title("from the front (its left is on the right), one after the other")
    return made


def travel(trace: GaitTrace) -> float:
    """How far the torso goes forward, m."""
    return float(np.ptp(trace.bodies[:, trace.robot.torso_body, 0]))


def _shots(trace: GaitTrace, most: int = _SHOTS) -> list[int]:
    """Instants one after the other: the borders of a motion of a few phases, else evenly in time."""
    borders = trace.gait.motion.borders
    if _FEW <= len(borders) <= _SHOTS:
        return [int(np.argmin(np.abs(trace.time - border))) for border in borders]
    return [int(k) for k in np.linspace(0, len(trace.time) - 1, most)]


def _apart(trace: GaitTrace, axis: int) -> float:
    """From one of the figures to the next, m."""
    centre = trace.bodies[:, trace.robot.torso_body, axis][None, :, None]
    wide = np.ptp(np.concatenate([trace.soles[..., axis], trace.edges[..., axis]], axis=-1) - centre)
    return 1.1 * max(float(wide), 0.35 * float(trace.head[:, 2].max()))


def _breadth(trace: GaitTrace, axis: int) -> float:
    return _apart(trace, axis) * (len(_shots(trace)) + 0.3)


def draw_side(axes: Axes, trace: GaitTrace, legend: bool = True) -> None:
    """All figures where they are, from the side."""
    count = int(np.clip(travel(trace) / (_DENSE * float(trace.head[:, 2].max()) / 0.5), 8, 60))
    for order, k in enumerate(np.linspace(0, len(trace.time) - 1, count).astype(int)):
        _figure(axes, trace, k, 0, 0.0, 0.25 + 0.75 * order / count)
    for side, (soles, colour, chain) in enumerate(zip(trace.soles, (LEFT, RIGHT), trace.chains(), strict=True)):
        name = trace.robot.legs[side].name
        axes.plot(soles[:, 1, 0], soles[:, 1, 2], color=colour, linewidth=1.6, label=f"{name} toe")
        ankle = trace.bodies[:, chain[-1]]
        axes.plot(ankle[:, 0], ankle[:, 2], color=colour, linewidth=1.0, linestyle="--", label=f"{name} ankle")
    axes.axhline(0.0, color=COMMAND, linewidth=1.0)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="x, m", ylabel="z, m")
    if legend:
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, fontsize=9.0, borderaxespad=0.1)


def draw_shots(axes: Axes, trace: GaitTrace, axis: int, most: int = _SHOTS) -> None:
    """At most ``most`` figures side by side, each with its time; ``axis`` goes to the right."""
    sign, size = (1.0, -1.0)[axis], float(trace.head[:, 2].max())
    places = trace.bodies[:, trace.robot.torso_body, axis]
    apart, chosen = _apart(trace, axis), _shots(trace, most)
    ball, borders = trace.gait.motion.parameters, trace.gait.motion.borders
    for order, k in enumerate(chosen):
        moved = apart * order - sign * places[k]
        _figure(axes, trace, k, axis, moved, 1.0, sign)
        if axis == 0 and "ball_1" in ball and trace.time[k] <= borders[3] + trace.time[1]:
            x, angle = ball["ball_1"] + trace.robot.legs[0].sole.toe + _BALL, np.linspace(0.0, 2.0 * np.pi, 40)
            circle = x + moved + _BALL * np.cos(angle), _BALL + _BALL * np.sin(angle)
            axes.plot(*circle, color=THIRD, linewidth=1.2)
    axes.axhline(0.0, color=COMMAND, linewidth=1.0)
    axes.set_xticks([apart * order for order in range(len(chosen))], [f"{trace.time[k]:.2f}" for k in chosen])
    axes.plot([-0.6 * apart, -0.6 * apart + 0.1], [1.0 * size] * 2, color=COMMAND, linewidth=3.0)
    axes.annotate("0.1 m", (-0.6 * apart, 0.98 * size), va="top", fontsize=9.0)
    axes.set(xlim=(-0.65 * apart, apart * (len(chosen) - 0.35)), ylim=(-0.05 * size, 1.1 * size))
    axes.set_aspect("equal", adjustable="box")
    axes.grid(visible=False, axis="x")
    axes.set(xlabel="time, s", ylabel="z, m")


def _figure(axes: Axes, trace: GaitTrace, k: int, axis: int, moved: float, shade: float, sign: float = 1.0) -> None:
    """One stick figure."""
    trunk = np.array([trace.bodies[k, trace.robot.torso_body], trace.head[k]])
    lines = [(trunk, COMMAND, 1.6)]
    for sole, chain, colour in zip((trace.soles, trace.edges)[axis], trace.chains(), (LEFT, RIGHT), strict=True):
        lines += [(trace.bodies[k, chain], colour, 1.0), (sole[k], colour, 2.0)]
        lines += [(np.array([trace.bodies[k, chain[-1]], sole[k, end]]), LIMIT, 0.6) for end in (0, 1)]
    for points, colour, width in lines:
        axes.plot(sign * points[:, axis] + moved, points[:, 2], color=colour, alpha=shade, lw=width)
