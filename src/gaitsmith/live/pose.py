"""Where everything is in a frame: bodies, soles, support polygon, ZMP, footholds; nothing here draws."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import numpy.typing as npt

from gaitsmith.live.frame import Frame
from gaitsmith.robots import Robot
from gaitsmith.synthesis.gaits.support import hull

Array = npt.NDArray[np.float64]
_TOUCHES = 0.01  # share of the weight on a sole that bears


class Pose:
    """A robot in a frame; SI units, world axes.

    Attributes:
        body_position: (nbody, 3) views that :meth:`take` changes.
        body_quaternion: (nbody, 4) w x y z.
        torso_centre: (3,) centre of mass of the torso; a view.
        soles: of both legs, (k, 3) corners.
        sole_position: (2, 3) sole frames.
        bears: of both legs, whether the sole does.
        support: (m, 2) corners of the support polygon, counterclockwise; two of a line, none in the air.
        ground: height of the bearing soles, m.
        zmp: (2,) centre of the vertical forces; NaN in the air.
        foothold: (k, 3) corners of the sole where the swing sole is told to land; None without one.
        swing: row of the leg that it is for.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot, self._data = robot, mujoco.MjData(robot.model)
        self.body_position, self.body_quaternion = self._data.xpos, self._data.xquat
        self._outlines = [np.column_stack([leg.sole.corners, np.zeros(len(leg.sole.corners))]) for leg in robot.legs]
        self.torso_centre = self._data.xipos[robot.torso_body]
        self.soles = [outline.copy() for outline in self._outlines]
        self.sole_position = np.zeros((len(robot.legs), 3))
        self.bears = [False] * len(robot.legs)
        self.support, self.ground, self.zmp = np.zeros((0, 2)), 0.0, np.full(2, math.nan)
        self.foothold: Array | None = None
        self.swing = 0

    def take(self, frame: Frame) -> None:
        """All of it, from a frame."""
        robot, data = self._robot, self._data
        data.qpos[:] = frame.q
        mujoco.mj_kinematics(robot.model, data)
        least = _TOUCHES * robot.mass * float(np.linalg.norm(robot.model.opt.gravity))
        for row, leg in enumerate(robot.legs):
            rotation = data.xmat[leg.sole_body].reshape(3, 3)
            self.sole_position[row] = data.xpos[leg.sole_body] + rotation @ leg.sole_position
            self.soles[row] = self.sole_position[row] + self._outlines[row] @ (rotation @ leg.sole_rotation).T
            self.bears[row] = frame[f"true.{leg.name}_force"] > least
        bearing = [sole for sole, bears in zip(self.soles, self.bears, strict=True) if bears]
        corners = np.concatenate([np.zeros((0, 3)), *bearing])
        self.support = hull(corners[:, :2]) if len(corners) > 1 else corners[:, :2]
        self.ground = float(corners[:, 2].mean()) if len(corners) else float(self.sole_position[:, 2].min())
        force = frame.contacts[:, 5]
        total = float(force.sum())
        self.zmp = force @ frame.contacts[:, :2] / total if total > least else np.full(2, math.nan)
        self._find_foothold(frame)

    def _find_foothold(self, frame: Frame) -> None:
        """The next foothold of the template, from the hip midpoint in the heading frame; of a plan, the sole's goal."""
        stance, self.foothold = int(frame["stance"]), None
        if frame["mode"] != 1.0 or stance > 1:
            return
        self.swing = 1 - stance
        torso = self._robot.torso_body
        rotation = self._data.xmat[torso].reshape(3, 3)
        hip = self._data.xpos[torso] + rotation @ self._robot.hip_midpoint
        yaw = math.atan2(rotation[1, 0], rotation[0, 0])
        turn = np.array([[math.cos(yaw), -math.sin(yaw), 0.0], [math.sin(yaw), math.cos(yaw), 0.0], [0.0, 0.0, 1.0]])
        if frame["plan_phase"] >= 0.0:
            first = frame.index(f"foot_desired.{self._robot.legs[self.swing].name}.x")
            place = hip + turn @ frame.row[first : first + 3]
        else:
            place = hip + turn @ (frame["foothold.x"], frame["foothold.y"], 0.0)
            place[2] = self.sole_position[stance, 2]
        self.foothold = place + self._outlines[self.swing] @ turn.T
