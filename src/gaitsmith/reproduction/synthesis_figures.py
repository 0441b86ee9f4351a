"""Figures 4 to 12 of the gait synthesis' paper, in its layout, with the real ZMP beside the planned one."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitsmith.reproduction.real import Real
from gaitsmith.view.canvas import COMMAND, GRID, LEFT, LIMIT, RIGHT, THIRD, above, figure, in_words
from gaitsmith.view.gait_figures import draw_supports
from gaitsmith.view.gait_trace import GaitTrace
from gaitsmith.view.sticks import draw_shots, draw_side


def two_sticks(static: GaitTrace, dynamic: GaitTrace) -> Figure:
    """Fig. 4: static and dynamic walking from the side, then from the front."""
    conditions = f"{static.title}; static: {static.conditions}; dynamic: {dynamic.conditions}"
    with figure("Fig. 4: stick figures of static and dynamic cyclic walking", 9.0, conditions) as made:
        grid = made.subplots(3, 2, height_ratios=(3.2, 1.5, 1.5))
        for column, (trace, name) in enumerate(((static, "static"), (dynamic, "dynamic"))):
            draw_side(grid[0][column], trace, legend=False)
            grid[0][column].set_title(f"{name}, from the side")
            draw_shots(grid[1][column], trace, 1, 6)
            grid[1][column].set_title(f"{name}, from the front", fontsize=10.0)
            foot = grid[2][column]
            for side, (chain, colour) in enumerate(zip(trace.chains(), (LEFT, RIGHT), strict=True)):
                foot.plot(trace.time, trace.bodies[:, chain[-1], 2], color=colour, label=trace.robot.legs[side].name)
            trace.shade(foot)
            foot.set(xlabel="time, s", ylabel="ankle z, m")
        above(grid[2][0], 2)
    return made


def one_sticks(trace: GaitTrace, title: str) -> Figure:
    """Fig. 7: a whole motion from the side and from the front."""
    with figure(title, 7.4, f"{trace.title}; {trace.conditions}") as made:
        side, front = made.subplots(2, 1, height_ratios=(3.0, 1.6))
        draw_side(side, trace)
        draw_shots(front, trace, 1)
    return made


def torques(static: GaitTrace, dynamic: GaitTrace) -> Figure:
    """Fig. 5: torques of both legs' joints over a step."""
    joints = static.robot.legs[1].joint_indices
    conditions = f"{static.title}; the right leg supports first; shaded: both feet on the ground"
    with figure("Fig. 5: joint torques of cyclic walking", 11.0, conditions) as made:
        grid = made.subplots(len(joints), 2, sharex="col", sharey="row")
        for column, (trace, name) in enumerate(((static, "static"), (dynamic, "dynamic"))):
            left, right = trace.robot.legs
            for row, (one, two) in enumerate(zip(left.joint_indices, right.joint_indices, strict=True)):
                title = f"{name}, {in_words(trace.robot.joint_names[two]).partition(' ')[2]}"
                trace.sides(grid[row][column], trace.samples.torque[:, one], trace.samples.torque[:, two], title)
                if column == 0:
                    grid[row][column].set_ylabel("N·m")
            grid[-1][column].set_xlabel("time, s")
        made.legend(*grid[0][0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return made


def angles(trace: GaitTrace, title: str) -> Figure:
    """Fig. 8: joint angles."""
    left, right = trace.robot.legs
    with figure(title, 8.4, f"{trace.title}; {trace.conditions}; shaded: both feet on the ground") as made:
        grid = made.subplots(3, 2, sharex=True)
        pairs = list(zip(left.joint_indices, right.joint_indices, strict=True))
        for axes, (one, two) in zip(grid.flat, pairs, strict=False):
            name = in_words(trace.robot.joint_names[one]).partition(" ")[2]
            trace.sides(axes, trace.samples.position[:, 7 + one], trace.samples.position[:, 7 + two], name)
            axes.set_ylabel("rad")
        for axes in grid[-1]:
            axes.set_xlabel("time, s")
        made.legend(*grid[0][0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return made


def swing_joints(trace: GaitTrace) -> Figure:
    """Fig. 11: joint angles of the leg that kicks, and the kick from the side."""
    swings = next(phase.other_foot for phase in trace.gait.motion.phases if not phase.double)
    leg = trace.robot.legs[0 if swings == "left" else 1]
    with figure(f"Fig. 11: joints of the swing leg ({swings})", 7.0, f"{trace.title}; {trace.conditions}") as made:
        curves, side = made.subplots(2, 1, height_ratios=(2.4, 1.2))
        styles = [(colour, line) for line in ("-", "--") for colour in (LEFT, RIGHT, THIRD)]
        for joint, name, (colour, line) in zip(leg.joint_indices, leg.joints, styles, strict=False):
            angle, label = trace.samples.position[:, 7 + joint], in_words(name).partition(" ")[2]
            curves.plot(trace.time, angle, color=colour, linestyle=line, label=label)
        for border in trace.gait.motion.borders[1:-1]:
            curves.axvline(float(border), color=LIMIT, linewidth=0.8, linestyle=":")
        trace.shade(curves)
        curves.set(xlabel="time, s; dotted: borders of the phases", ylabel="rad")
        curves.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=9.0)
        draw_shots(side, trace, 0)
    return made


def real_zmp(parts: Sequence[Real], names: Sequence[str], conditions: Sequence[str], title: str) -> Figure:
    """Figs. 6, 10, 12: real ZMP and CoG from above and over time, with the planned support polygons."""
    walked = "; ".join(f"{name}: {condition}" for name, condition in zip(names, conditions, strict=True))
    shown = f"{walked}; boxes: planned footprints; grey: support polygons"
    with figure(f"{title}: real ZMP and CoG in closed loop", 10.0, shown) as made:
        grid = made.subplots(4, len(parts), squeeze=False, height_ratios=(2.2, 1.2, 1.2, 1.2))
        for column, (real, name) in enumerate(zip(parts, names, strict=True)):
            phases = dict.fromkeys(real.plan.phases)
            draw_supports(grid[0][column], real.run.robot, phases, GRID)
            begin = real.time <= 1.1 * sum(phase.duration for phase in phases)
            grid[0][column].plot(*real.com[begin].T, color=THIRD, lw=1.2)
            grid[0][column].plot(*real.zmp[begin].T, color=COMMAND, lw=0.9)
            grid[0][column].set_title(f"{name}, from above")
            _over_time(list(grid[1:, column]), real)
        grid[1][0].set_ylabel("x, m")
        grid[2][0].set_ylabel("y, m")
        grid[3][0].set_ylabel("inside the\npolygon, mm")
        made.legend(*grid[1][0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return made


def _over_time(axes: Sequence[Axes], real: Real) -> None:
    for row, axis in enumerate(axes[:2]):
        axis.plot(real.time, real.com[:, row], color=THIRD, label="real CoG")
        axis.plot(real.time, real.zmp[:, row], color=COMMAND, lw=0.9, label="real ZMP")
        axis.plot(real.time, real.plan.zmp[:, row], color=RIGHT, lw=0.9, ls="--", label="planned ZMP")
    axes[2].plot(real.time, 1e3 * real.com_inside, color=THIRD)
    axes[2].plot(real.time, 1e3 * real.zmp_inside, color=COMMAND, lw=0.9)
    axes[2].axhline(0.0, color=LIMIT, linewidth=1.0)
    for axis in axes:
        axis.set_xlim(float(real.time[0]), float(real.time[-1]))
    axes[2].set_xlabel("time, s")
