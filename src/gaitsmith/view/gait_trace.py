"""A planned gait sampled for its figures: bodies and soles in the world, its title, axes over its phases."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

from gaitsmith.robots import Robot
from gaitsmith.synthesis.gaits.gait import Gait, unrolled
from gaitsmith.synthesis.gaits.unrolled import UnrolledGait
from gaitsmith.synthesis.motions.biped import biped_from
from gaitsmith.view.canvas import BAND, LEFT, RIGHT

Array = npt.NDArray[np.float64]
_SAMPLES = 60  # a phase


class GaitTrace:
    """A gait sampled at N instants.

    Args:
        steps: of a cyclic gait.

    Attributes:
        title: robot, motion, and in a second line what it was planned for and its objective.
        time: (N,) s.
        bodies: (N, bodies, 3) places, m.
        soles, edges: (legs, N, 2, 3) heel and toe, and the sole's left and right, m.
        head: (N, 3) the torso's centre of mass, m.
    """

    def __init__(self, gait: Gait, robot: Robot, steps: int = 1) -> None:
        biped = biped_from(robot)
        self.robot, self.cyclic = robot, gait.motion.cyclic
        whole = unrolled(gait, biped.partner, biped.sign, steps)
        self.gait = whole
        self.title, self.conditions = f"{robot.card.name}: {gait.motion.name}", _conditions(gait)
        self.time = np.linspace(0.0, whole.duration, _SAMPLES * len(whole.motion.phases))
        self.samples, data = UnrolledGait(whole, robot, 1).at(self.time), mujoco.MjData(robot.model)
        self.bodies, self.head = np.zeros((len(self.time), robot.model.nbody, 3)), np.zeros((len(self.time), 3))
        self.soles, self.edges = np.zeros((2, len(robot.legs), len(self.time), 2, 3))
        for k, position in enumerate(self.samples.position):
            data.qpos[:] = position
            mujoco.mj_kinematics(robot.model, data)
            self.bodies[k], self.head[k] = data.xpos, data.xipos[robot.torso_body]
            for leg, soles, edges in zip(robot.legs, self.soles, self.edges, strict=True):
                site, breadth = data.site(leg.sole_site), leg.sole.corners[:, 1]
                forward, across, _ = site.xmat.reshape(3, 3).T
                for end, x in enumerate((-leg.sole.heel, leg.sole.toe)):
                    soles[k, end] = site.xpos + x * forward
                for end, y in enumerate((breadth.min(), breadth.max())):
                    edges[k, end] = site.xpos + y * across

    def chains(self) -> list[list[int]]:
        """Bodies of each leg, from the torso down to the foot."""
        return [[self.robot.torso_body, *self.robot.model.jnt_bodyid[leg.joint_indices + 1]] for leg in self.robot.legs]

    def shade(self, axes: Axes) -> None:
        """Shade double support, and show the whole motion."""
        borders = self.gait.motion.borders
        for index, phase in enumerate(self.gait.motion.phases):
            if phase.double:
                axes.axvspan(borders[index], borders[index + 1], color=BAND, zorder=0, linewidth=0.0)
        axes.set_xlim(float(borders[0]), float(borders[-1]))

    def sides(self, axes: Axes, left: Array, right: Array, title: str) -> None:
        """A curve of either side over time, double support shaded."""
        self.shade(axes)
        axes.plot(self.time, left, color=LEFT, label="left")
        axes.plot(self.time, right, color=RIGHT, label="right")
        axes.set_title(title, fontsize=9.0)


def _conditions(gait: Gait) -> str:
    """What the gait was planned for, and its objective."""
    given, words = gait.motion.parameters, []
    length, period = given.get("length"), given.get("period")
    if length and period:
        words = [f"{length / period:.3g} m/s", f"step {length:g} m", f"period {period:g} s"]
        words += [f"step height {given['height']:g} m"] if "height" in given else []
    elif "speed" in given:
        words = [f"ankle {given['speed']:g} m/s at the ball"]
    words += [f"on ground that rises by {math.degrees(gait.motion.slope):g}°, x along it"] if gait.motion.slope else []
    words += [f"{given['cycles']:.0f} cycles"] if "cycles" in given else []
    objective = gait.certificate.get("objective")
    words += [f"J = {objective:.1f}"] if isinstance(objective, float) else []
    return ", ".join(words)
