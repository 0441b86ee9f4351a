"""A recorded run as frames: what its log holds, row by row, and what its folder says besides."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.live.frame import Frame
from gaitsmith.log import Log
from gaitsmith.reports.run import open_run
from gaitsmith.simulation.run_folder import LOG
from gaitsmith.simulation.scene_log import positions
from gaitsmith.view.recording import pushes_of

Array = npt.NDArray[np.float64]


class Run:
    """A run that was recorded.

    Args:
        path: its folder.

    Attributes:
        path: of the log.
        log: as far as it is whole.
        fall: None without one.
        notes: what a viewer should know, in words.
        frame: the present row.

    Raises:
        BadInput: no such run, no log of a run, one from a newer version, or its robot cannot be loaded.
    """

    def __init__(self, path: str) -> None:
        run = open_run(path)
        self.path, self.log, self.robot, self.scenario = run.folder / LOG, run.log, run.robot, run.scenario
        self.fall, self.notes = run.summary.fall, run.notes
        believes = "true.torso_yaw" not in self.log.columns
        names = ["true." + n.removeprefix("believed.") if believes else n for n in self.log.columns]
        self.frame = Frame(names, self.robot.model.nq, 0)
        self._data = mujoco.MjData(self.robot.model)
        self._check_columns()
        self.pushes = pushes_of(self.log)

    def _check_columns(self) -> None:
        """Refuse a log that lacks what is shown."""
        joints = [f"joint_position.{name}" for name in self.robot.joint_names]
        for name in (*joints, "true.torso_x", "true.torso_roll", "stance", "step_count", "torque." + joints[0][15:]):
            if name not in self.frame:
                raise BadInput(str(self.path), f"a log without {name}", "the log of a run of gaitsmith walk")

    def row(self, time: float) -> int:
        """Number of the row at a time, s."""
        return int(np.clip(np.searchsorted(self.log.time, time, side="right") - 1, 0, len(self.log.rows) - 1))

    def rows(self, first: int, last: int) -> Array:
        """(n, m) frames of some rows, without position, forces and pushes: what charts need."""
        found = np.zeros((max(last - first, 0), len(self.frame.row)))
        vitals = len(self.frame.vitals)
        found[:, vitals : vitals + len(self.log.columns)] = self.log.rows[first:last]
        found[:, self.frame.index("live.time")] = self.log.time[first:last]
        return found

    def show(self, number: int) -> Frame:
        """The frame of a row."""
        frame, robot, data = self.frame, self.robot, self._data
        frame.row[:] = self.rows(number, number + 1)[0]
        frame.q[:] = positions(Log(self.log.columns, self.log.rows[number : number + 1]), robot)[0]
        data.qpos[:] = frame.q
        mujoco.mj_kinematics(robot.model, data)
        mujoco.mj_comPos(robot.model, data)
        frame.com[:] = data.subtree_com[robot.torso_body]
        yaw = frame["true.torso_yaw"]
        for row, leg in enumerate(robot.legs):
            x, y = frame[f"zmp.{leg.name}.x"], frame[f"zmp.{leg.name}.y"]
            place = [frame[f"true.{leg.name}_sole_{axis}"] for axis in "xyz"]
            place[0] += math.cos(yaw) * x - math.sin(yaw) * y
            place[1] += math.sin(yaw) * x + math.cos(yaw) * y
            frame.contacts[row] = (*place, 0.0, 0.0, frame[f"true.{leg.name}_force"])
        now = frame["live.time"]
        forces = [np.divide(p.impulse, max(p.end - p.begin, 1e-3)) for p in self.pushes if p.begin <= now <= p.end]
        frame.push[:] = np.sum(forces, axis=0) if forces else 0.0
        return frame
