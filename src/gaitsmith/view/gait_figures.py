"""Figures of a planned gait: stick figures, joints with their limits, ZMP and CoG over the footprints, reactions."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from gaitsmith.robots import Robot
from gaitsmith.synthesis.gaits.gait import Gait
from gaitsmith.synthesis.gaits.support import contact_points, depths, hull
from gaitsmith.synthesis.motions.biped import biped_from
from gaitsmith.synthesis.motions.motion import SIDES, Phase, about_vertical
from gaitsmith.view.canvas import BAND, COMMAND, LEFT, LIMIT, RIGHT, THIRD, above, figure, save, sole_corners
from gaitsmith.view.gait_trace import Array, GaitTrace
from gaitsmith.view.sticks import draw_sticks

_UNROLLED = 4  # steps of a cyclic gait in the figures of places


def draw_gait_joints(trace: GaitTrace) -> Figure:
    """Angles, speeds and torques of both legs' joints."""
    robot, samples, (left, right) = trace.robot, trace.samples, trace.robot.legs
    rows = len(left.joint_indices)
    with figure(f"{trace.title}, joints", 2.0 * rows + 0.6, trace.conditions) as made:
        grid = made.subplots(rows, 3, sharex=True)
        for row, (one, two) in enumerate(zip(left.joint_indices, right.joint_indices, strict=True)):
            speed, torque = robot.velocity_limit[one], robot.torque_limit[one]
            curves = (
                (samples.position[:, 7:], (robot.position_low[one], robot.position_high[one]), "angle, rad"),
                (samples.velocity[:, 6:], (-speed, speed), "speed, rad/s"),
                (samples.torque, (-torque, torque), "torque, N·m"),
            )
            name = robot.joint_names[one].replace("left_", "")
            for axes, (values, limits, unit) in zip(grid[row], curves, strict=True):
                title = f"{name}, limits {limits[0]:.3g} to {limits[1]:.3g}"
                trace.sides(axes, values[:, one], values[:, two], title)
                low, high = axes.get_ylim()
                for limit in limits:
                    if low - 0.5 * (high - low) <= limit <= high + 0.5 * (high - low):
                        axes.axhline(float(limit), color=LIMIT, ls="--")
                axes.set_ylabel(unit)
        _finish(made, grid)
    return made


def draw_ground(trace: GaitTrace) -> Figure:
    """ZMP and CoG over footprints and support polygons, from above and with time; and how far inside they are."""
    places = np.vstack([trace.samples.zmp, trace.samples.com[:, :2]])
    length, breadth = np.nanmax(places, axis=0) - np.nanmin(places, axis=0) + 0.25  # no ZMP in flight
    height = float(np.clip(9.0 * breadth / length, 1.8, 4.5))
    with figure(f"{trace.title}, ZMP and CoG", height + 5.4, trace.conditions) as made:
        top, forward, sideways, margin = made.subplots(4, 1, height_ratios=(height, 1.3, 1.3, 1.3))
        draw_plane(top, trace)
        draw_over_time((forward, sideways), trace)
        draw_margin(margin, trace)
        margin.set_xlabel("time, s")
    return made


def draw_plane(axes: Axes, trace: GaitTrace) -> None:
    """From above: footprints, support polygons, ZMP and CoG; numbers are times, s."""
    draw_supports(axes, trace.robot, trace.gait.motion.phases, BAND)
    for values, colour, name in ((trace.samples.com[:, :2], THIRD, "CoG"), (trace.samples.zmp, COMMAND, "ZMP")):
        axes.plot(*values.T, color=colour, lw=1.2, label=name)
    last = np.array([np.inf, 0.0])
    for k in np.linspace(0, len(trace.time) - 1, 16).astype(int):
        x, y = trace.samples.zmp[k]
        if np.hypot(x - last[0], y - last[1]) < 0.04 * (np.ptp(trace.samples.com[:, 0]) + 0.25):
            continue
        last = trace.samples.zmp[k]
        axes.plot(x, y, "o", color=COMMAND, markersize=3.0)
        axes.annotate(
            f"{trace.time[k]:.1f}", (x, y), xytext=(3, 3), textcoords="offset points", fontsize=8.0, color=COMMAND
        )
    axes.set_title("from above; shaded: support polygons; numbers: time, s", fontsize=10.0)
    above(axes, 2)


def draw_supports(axes: Axes, robot: Robot, phases: Collection[Phase], colour: str) -> None:
    """Footprints and support polygons from above, to scale."""
    biped = biped_from(robot)
    for phase in phases:
        if not phase.flies:
            axes.add_patch(Polygon(hull(contact_points(biped, phase)), facecolor=colour, edgecolor="none", zorder=0))
    feet = [(side, phase.place(side), phase.facing(side)) for phase in phases for side in SIDES]
    for side, place, heading in dict.fromkeys(feet):
        if place is not None:
            leg, edge = (0, LEFT) if side == "left" else (1, RIGHT)
            corners = place + sole_corners(robot.legs[leg].sole) @ about_vertical(heading)[:2, :2].T
            axes.add_patch(Polygon(corners, fill=False, edgecolor=edge))
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="x, m", ylabel="y, m")


def draw_over_time(axes: tuple[Axes, Axes], trace: GaitTrace) -> None:
    """ZMP and CoG forward and sideways, with the support polygon's extent."""
    extent = _extents(trace)
    for column, (axis, name) in enumerate(zip(axes, ("x", "y"), strict=True)):
        axis.fill_between(
            trace.time, extent[:, column, 0], extent[:, column, 1], color=BAND, step="post", label="support polygon"
        )
        axis.plot(trace.time, trace.samples.com[:, column], color=THIRD, label="CoG")
        axis.plot(trace.time, trace.samples.zmp[:, column], color=COMMAND, lw=1.2, label="ZMP")
        axis.set_ylabel(f"{name}, m")
        axis.set_xlim(float(trace.time[0]), float(trace.time[-1]))
    axes[0].legend(loc="upper left", fontsize=9.0)


def draw_margin(axes: Axes, trace: GaitTrace) -> None:
    """Distance of ZMP and CoG from the edge of the support polygon; negative outside."""
    trace.shade(axes)
    for values, colour, name in ((trace.samples.com[:, :2], THIRD, "CoG"), (trace.samples.zmp, COMMAND, "ZMP")):
        inside = depths(biped_from(trace.robot), trace.samples.phases, values)
        axes.plot(trace.time, 1e3 * inside, color=colour, lw=1.2, label=name)
    axes.axhline(0.0, color=LIMIT, linewidth=1.0)
    axes.set_ylabel("inside the\npolygon, mm")


def _extents(trace: GaitTrace) -> Array:
    """(N, 2, 2) lowest and highest x and y of the support polygon, m."""
    biped, found = biped_from(trace.robot), dict[Phase, Array]()
    for phase in trace.samples.phases:
        if phase not in found:
            corners = np.full((1, 2), np.nan) if phase.flies else contact_points(biped, phase)
            found[phase] = np.stack([corners.min(axis=0), corners.max(axis=0)], axis=1)
    return np.array([found[phase] for phase in trace.samples.phases])


def draw_reactions(trace: GaitTrace) -> Figure:
    """Force and moment of the ground on either sole."""
    wrench = trace.samples.wrench.T
    with figure(f"{trace.title}, ground reactions", 6.0, trace.conditions) as made:
        grid = made.subplots(2, 3, sharex=True)
        for k, axes in enumerate(grid.flat):
            title = f"{('force', 'moment')[k // 3]} {'xyz'[k % 3]}"
            trace.sides(axes, wrench[k], wrench[6 + k], title)
            axes.set_ylabel(("N", "N·m")[k // 3])
        _finish(made, grid)
    return made


def _finish(made: Figure, grid: npt.NDArray[np.object_]) -> None:
    """Legend and axis of time of panels."""
    made.legend(*grid[0][0].get_legend_handles_labels(), loc="outside upper right", ncols=2)
    for axes in grid[-1]:
        axes.set_xlabel("time, s")


def write_gait_figures(gait: Gait, robot: Robot, folder: Path) -> list[Path]:
    """Write all figures of a gait into a folder, as PNG and SVG; returns the PNGs' paths.

    Raises:
        BadInput: the folder cannot be written.
    """
    trace = GaitTrace(gait, robot)
    places = GaitTrace(gait, robot, _UNROLLED) if trace.cyclic else trace
    folder.mkdir(parents=True, exist_ok=True)
    figures = {
        "sticks": draw_sticks(places),
        "joints": draw_gait_joints(trace),
        "ground": draw_ground(places),
        "reactions": draw_reactions(trace),
    }
    return [save(made, folder / f"{name}.png") for name, made in figures.items()]
