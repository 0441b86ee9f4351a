"""Figures of a planned gait: stick figures, joints with their limits, ZMP and CoG over the footprints, reactions."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from gaitsmith.robots import Robot
from gaitsmith.synthesis.gaits.gait import Gait
from gaitsmith.synthesis.gaits.unrolled import UnrolledGait
from gaitsmith.view.canvas import BAND, COMMAND, LEFT, LIMIT, RIGHT, THIRD, figure, save, sole_corners

_SAMPLES = 60  # a phase
_STICKS = 30  # figures in a stick plot
_WALKS = 0.5  # m travelled, from which figures seen from the side need no spreading
_APART = (0.3, 0.3)  # m, from the side and from the front


class _Trace:
    """A gait sampled: time (N,), its samples, places of the bodies (N, bodies, 3) and of heel and toe (N, 2, 3), m."""

    def __init__(self, gait: Gait, robot: Robot) -> None:
        self.gait, self.robot, self.title = gait, robot, f"{robot.card.name}: {gait.motion.name}"
        self.time = np.linspace(0.0, gait.duration, _SAMPLES * len(gait.motion.phases))
        self.samples, data = UnrolledGait(gait, robot, 1).at(self.time), mujoco.MjData(robot.model)
        self.bodies = np.zeros((len(self.time), robot.model.nbody, 3))
        self.soles = np.zeros((len(robot.legs), len(self.time), 2, 3))
        for k, position in enumerate(self.samples.position):
            data.qpos[:] = position
            mujoco.mj_kinematics(robot.model, data)
            self.bodies[k] = data.xpos
            for leg, soles in zip(robot.legs, self.soles, strict=True):
                site = data.site(leg.sole_site)
                for end, x in enumerate((-leg.sole.heel, leg.sole.toe)):
                    soles[k, end] = site.xpos + x * site.xmat.reshape(3, 3)[:, 0]

    def sides(self, axes: Axes, left: npt.NDArray[np.float64], right: npt.NDArray[np.float64], title: str) -> None:
        """A curve of either side over time, double support shaded."""
        borders = self.gait.motion.borders
        for index, phase in enumerate(self.gait.motion.phases):
            if phase.double:
                axes.axvspan(borders[index], borders[index + 1], color=BAND, zorder=0)
        axes.set_xlim(float(borders[0]), float(borders[-1]))
        axes.plot(self.time, left, color=LEFT, label="left")
        axes.plot(self.time, right, color=RIGHT, label="right")
        axes.set_title(title, fontsize=9.0)


def _sticks(trace: _Trace) -> Figure:
    robot, torso = trace.robot, trace.robot.torso_body
    # Figures that would stand on the same spot are spread along time.
    stays = np.ptp(trace.bodies[:, torso, 0]) < _WALKS
    spacing = (_APART[0] if stays else 0.0, _APART[1])
    with figure(trace.title, 3.6 if stays else 7.0) as made:
        side, front = made.subplots(2, 1)
        chosen = np.linspace(0, len(trace.time) - 1, _STICKS).astype(int)
        chains = [[torso, *robot.model.jnt_bodyid[leg.joint_indices + 1]] for leg in robot.legs]
        for axes, axis, sign, title in ((side, 0, 1.0, "from the side"), (front, 1, -1.0, "from the front")):
            for order, k in enumerate(chosen):
                trunk = trace.bodies[k, torso]
                lines = [(np.array([trunk, trunk + np.array([0.0, 0.0, 0.3])]), COMMAND, 1.0)]
                for sole, chain, colour in zip(trace.soles, chains, (LEFT, RIGHT), strict=True):
                    lines += [(trace.bodies[k, chain], colour, 1.0), (sole[k], colour, 1.6)]
                for points, colour, width in lines:
                    along, shade = sign * points[:, axis] + spacing[axis] * order, 0.25 + 0.75 * order / _STICKS
                    axes.plot(along, points[:, 2], color=colour, alpha=shade, lw=width)
            axes.set_aspect("equal")
            axes.set(title=title, ylabel="z, m")
        side.set_xlabel("x, m" + (", figures spread along time" if stays else ""))
        front.set_xlabel("y, m, figures spread along time")
    return made


def _joints(trace: _Trace) -> Figure:
    robot, samples, (left, right) = trace.robot, trace.samples, trace.robot.legs
    rows = len(left.joint_indices)
    with figure(f"{trace.title}, joints", 2.0 * rows) as made:
        grid = made.subplots(rows, 3, sharex=True)
        for row, (one, two) in enumerate(zip(left.joint_indices, right.joint_indices, strict=True)):
            speed, torque = robot.velocity_limit[one], robot.torque_limit[one]
            curves = (
                (samples.position[:, 7:], (robot.position_low[one], robot.position_high[one]), "rad"),
                (samples.velocity[:, 6:], (-speed, speed), "rad/s"),
                (samples.torque, (-torque, torque), "N·m"),
            )
            name = robot.joint_names[one].replace("left_", "")
            for axes, (values, limits, unit) in zip(grid[row], curves, strict=True):
                title = f"{name}, limits {limits[0]:g} to {limits[1]:g}"
                trace.sides(axes, values[:, one], values[:, two], title)
                low, high = axes.get_ylim()
                for limit in limits:
                    if low - 0.5 * (high - low) <= limit <= high + 0.5 * (high - low):
                        axes.axhline(float(limit), color=LIMIT, ls="--")
                axes.set_ylabel(unit)
        _finish(grid)
    return made


def _ground(trace: _Trace) -> Figure:
    with figure(f"{trace.title}, ZMP and CoG over the footprints", 5.0) as made:
        axes = made.subplots()
        phases = trace.gait.motion.phases
        stood = [(phase.support, phase.foothold) for phase in phases]
        for side, place in dict.fromkeys([*stood, *((phase.other_foot, phase.other) for phase in phases)]):
            if place is not None:
                leg, colour = (0, LEFT) if side == "left" else (1, RIGHT)
                corners = place + sole_corners(trace.robot.legs[leg].sole)
                axes.add_patch(Polygon(corners, fill=False, edgecolor=colour))
        axes.plot(*trace.samples.com.T[:2], color=THIRD, label="CoG")
        axes.plot(*trace.samples.zmp.T, color=COMMAND, lw=1.0, label="ZMP")
        axes.set_aspect("equal", adjustable="datalim")
        axes.set(xlabel="x, m", ylabel="y, m")
        axes.legend(loc="upper right")
    return made


def _reactions(trace: _Trace) -> Figure:
    wrench = trace.samples.wrench.T
    with figure(f"{trace.title}, ground reactions", 6.0) as made:
        grid = made.subplots(2, 3, sharex=True)
        for k, axes in enumerate(grid.flat):
            title = f"{('force', 'moment')[k // 3]} {'xyz'[k % 3]}, {('N', 'N·m')[k // 3]}"
            trace.sides(axes, wrench[k], wrench[6 + k], title)
        _finish(grid)
    return made


def _finish(grid: npt.NDArray[np.object_]) -> None:
    """Legend and axis of time of panels."""
    grid[0][0].legend(loc="best")
    for axes in grid[-1]:
        axes.set_xlabel("time, s")


def write_gait_figures(gait: Gait, robot: Robot, folder: Path) -> list[Path]:
    """Write all figures of a gait into a folder; returns their paths.

    Raises:
        BadInput: the folder cannot be written.
    """
    trace = _Trace(gait, robot)
    folder.mkdir(parents=True, exist_ok=True)
    figures = {"sticks": _sticks, "joints": _joints, "ground": _ground, "reactions": _reactions}
    return [save(draw(trace), folder / f"{name}.png") for name, draw in figures.items()]
