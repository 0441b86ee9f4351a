"""Figures of a planned gait: stick figures, joints with their limits, ZMP and CoG over the footprints, reactions."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from gaitsmith.robots import Robot
from gaitsmith.synthesis.gaits.gait import Gait
from gaitsmith.synthesis.gaits.unrolled import Samples, UnrolledGait
from gaitsmith.view.canvas import BAND, COMMAND, LEFT, LIMIT, RIGHT, THIRD, figure, save

Array = npt.NDArray[np.float64]
_SAMPLES = 60  # a phase
_STICKS = 30  # figures in a stick plot
_WALKS = 0.5  # m travelled, from which figures seen from the side need no spreading
_APART = (0.3, 0.3)  # m, from the side and from the front


@dataclass(frozen=True, eq=False)
class _Trace:
    """A gait sampled: time (N,), its samples, places of the bodies (N, bodies, 3) and of heel and toe (N, 2, 3), m."""

    time: Array
    samples: Samples
    bodies: Array
    soles: dict[str, Array]


def _sample(gait: Gait, robot: Robot) -> _Trace:
    time = np.linspace(0.0, gait.duration, _SAMPLES * len(gait.motion.phases))
    samples, data = UnrolledGait(gait, robot, 1).at(time), mujoco.MjData(robot.model)
    bodies, soles = [], {leg.name: np.zeros((len(time), 2, 3)) for leg in robot.legs}
    for k, position in enumerate(samples.position):
        data.qpos[:] = position
        mujoco.mj_kinematics(robot.model, data)
        bodies.append(data.xpos.copy())
        for leg in robot.legs:
            site = data.site(leg.sole_site)
            for end, x in enumerate((-leg.sole.heel, leg.sole.toe)):
                soles[leg.name][k, end] = site.xpos + x * site.xmat.reshape(3, 3)[:, 0]
    return _Trace(time, samples, np.array(bodies), soles)


def _phases(axes: Axes, gait: Gait) -> None:
    """Double support shaded."""
    borders = gait.motion.borders
    for index, phase in enumerate(gait.motion.phases):
        if phase.double:
            axes.axvspan(borders[index], borders[index + 1], color=BAND, zorder=0)
    axes.set_xlim(float(borders[0]), float(borders[-1]))


def _sticks(gait: Gait, robot: Robot, trace: _Trace, path: Path) -> Path:
    # Figures that would stand on the same spot are spread along time.
    stays = np.ptp(trace.bodies[:, robot.torso_body, 0]) < _WALKS
    spacing = (_APART[0] if stays else 0.0, _APART[1])
    with figure(f"{robot.card.name}: {gait.motion.name}", 3.6 if stays else 7.0) as made:
        side, front = made.subplots(2, 1)
        chosen = np.linspace(0, trace.bodies.shape[0] - 1, _STICKS).astype(int)
        chains = [[robot.torso_body, *robot.model.jnt_bodyid[leg.joint_indices + 1]] for leg in robot.legs]
        for axes, axis, sign, title in ((side, 0, 1.0, "from the side"), (front, 1, -1.0, "from the front")):
            for order, k in enumerate(chosen):
                trunk = trace.bodies[k, robot.torso_body]
                lines = [(np.array([trunk, trunk + np.array([0.0, 0.0, 0.3])]), COMMAND, 1.0)]
                for leg, chain, colour in zip(robot.legs, chains, (LEFT, RIGHT), strict=True):
                    lines += [(trace.bodies[k, chain], colour, 1.0), (trace.soles[leg.name][k], colour, 1.6)]
                for points, colour, width in lines:
                    along, shade = sign * points[:, axis] + spacing[axis] * order, 0.25 + 0.75 * order / _STICKS
                    axes.plot(along, points[:, 2], color=colour, alpha=shade, lw=width)
            axes.set_aspect("equal")
            axes.set_title(title)
            axes.set_ylabel("z, m")
        side.set_xlabel("x, m" + (", figures spread along time" if stays else ""))
        front.set_xlabel("y, m, figures spread along time")
        return save(made, path)


def _joints(gait: Gait, robot: Robot, trace: _Trace, path: Path) -> Path:
    left, right = robot.legs
    rows = len(left.joint_indices)
    with figure(f"{robot.card.name}: {gait.motion.name}, joints", 2.0 * rows) as made:
        grid = made.subplots(rows, 3, sharex=True)
        for row, (one, two) in enumerate(zip(left.joint_indices, right.joint_indices, strict=True)):
            curves = (
                (trace.samples.position[:, 7:], (robot.position_low[one], robot.position_high[one]), "rad"),
                (trace.samples.velocity[:, 6:], (-robot.velocity_limit[one], robot.velocity_limit[one]), "rad/s"),
                (trace.samples.torque, (-robot.torque_limit[one], robot.torque_limit[one]), "N·m"),
            )
            for axes, (values, limits, unit) in zip(grid[row], curves, strict=True):
                _phases(axes, gait)
                axes.plot(trace.time, values[:, one], color=LEFT, label="left")
                axes.plot(trace.time, values[:, two], color=RIGHT, label="right")
                low, high = axes.get_ylim()
                for limit in limits:
                    if low - 0.5 * (high - low) <= limit <= high + 0.5 * (high - low):
                        axes.axhline(float(limit), color=LIMIT, ls="--")
                axes.set_ylabel(unit)
                name = robot.joint_names[one].replace("left_", "")
                axes.set_title(f"{name}, limits {limits[0]:g} to {limits[1]:g}", fontsize=9.0)
        grid[0][0].legend(loc="best")
        for axes in grid[-1]:
            axes.set_xlabel("time, s")
        return save(made, path)


def _ground(gait: Gait, robot: Robot, trace: _Trace, path: Path) -> Path:
    sole = robot.legs[0].sole
    with figure(f"{robot.card.name}: {gait.motion.name}, ZMP and CoG over the footprints", 5.0) as made:
        axes = made.subplots()
        places = {
            stood: None
            for phase in gait.motion.phases
            for stood in ((phase.support, phase.foothold), (phase.other_foot, phase.other))
        }
        for side, place in places:
            if place is not None:
                corner = (place[0] - sole.heel, place[1] - sole.half_width)
                colour = LEFT if side == "left" else RIGHT
                box = Rectangle(corner, sole.heel + sole.toe, 2 * sole.half_width, fill=False, edgecolor=colour)
                axes.add_patch(box)
        axes.plot(*trace.samples.com.T[:2], color=THIRD, label="CoG")
        axes.plot(*trace.samples.zmp.T, color=COMMAND, lw=1.0, label="ZMP")
        axes.set_aspect("equal", adjustable="datalim")
        axes.set(xlabel="x, m", ylabel="y, m")
        axes.legend(loc="upper right")
        return save(made, path)


def _reactions(gait: Gait, robot: Robot, trace: _Trace, path: Path) -> Path:
    with figure(f"{robot.card.name}: {gait.motion.name}, ground reactions", 6.0) as made:
        grid = made.subplots(2, 3, sharex=True)
        for row, (kind, unit) in enumerate((("force", "N"), ("moment", "N·m"))):
            for axis, name in enumerate("xyz"):
                axes = grid[row][axis]
                _phases(axes, gait)
                axes.plot(trace.time, trace.samples.wrench[:, 3 * row + axis], color=LEFT, label="left")
                axes.plot(trace.time, trace.samples.wrench[:, 6 + 3 * row + axis], color=RIGHT, label="right")
                axes.set_title(f"{kind} {name}, {unit}")
        grid[0][0].legend(loc="best")
        for axes in grid[1]:
            axes.set_xlabel("time, s")
        return save(made, path)


def write_gait_figures(gait: Gait, robot: Robot, folder: Path) -> list[Path]:
    """Write all figures of a gait into a folder; returns their paths.

    Raises:
        BadInput: the folder cannot be written.
    """
    trace = _sample(gait, robot)
    folder.mkdir(parents=True, exist_ok=True)
    figures = {"sticks": _sticks, "joints": _joints, "ground": _ground, "reactions": _reactions}
    return [draw(gait, robot, trace, folder / f"{name}.png") for name, draw in figures.items()]
