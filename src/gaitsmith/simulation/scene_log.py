"""What Foxglove and Rerun draw of a run, in Foxglove's own schemas: the robot moves there without any set-up.

Topics: ``/tf`` (every body in the world), ``/joint_states``, ``/robot`` (its shapes, fixed to the bodies' frames, and
the blocks of the ground), ``/steps`` (forces under the soles as arrows, and where the swing sole is told to land),
``/tick_times``, and ``/points/BODY`` (points on the body's shapes, fixed to its frame: Rerun draws no scenes, but
points and frames). The robot's model is attached. Commands, counters and everything else are columns of the rows.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from importlib.resources import files

import mujoco
import numpy as np
import numpy.typing as npt
from mcap.records import Attachment

from gaitsmith.errors import BadInput
from gaitsmith.files import read_bounded
from gaitsmith.log import Log
from gaitsmith.log import protobuf as pb
from gaitsmith.log.mcap_writer import Messages, Topic
from gaitsmith.log.protobuf import Form
from gaitsmith.robots import Robot
from gaitsmith.simulation.shapes_log import body_entity, body_points, cloud, cube, entity, ground_entity
from gaitsmith.simulation.summary import TickTimes
from gaitsmith.simulation.terrain import Block

WORLD = "world"
_RATE = 30.0  # pictures a simulated second, at most
_LARGEST_MODEL = 20_000_000  # bytes
_WEIGHT = 0.6  # hip heights that an arrow of the robot's weight is long
_FORCE, _AIM = (0.3, 0.6, 0.8, 0.9), (0.95, 0.6, 0.1, 0.6)
_THIN = 0.004  # m: height of a foothold's mark
_TF, _JOINTS, _ROBOT, _STEPS, _TICKS = range(5)
_WHAT = ("joint_position", "joint_velocity", "torque")
Array = npt.NDArray[np.float64]


def positions(log: Log, robot: Robot) -> Array:
    """(n, nq) the robot's position at every row of a log, as it truly was or as it was believed to be."""
    true = "true." if "true.torso_z" in log.columns else "believed."
    found = np.zeros((len(log.rows), robot.model.nq))
    for column, axis in enumerate("xyz"):
        found[:, column] = log.column(f"{true}torso_{axis}")
    roll, pitch, yaw = (0.5 * log.column(f"{true}torso_{angle}") for angle in ("roll", "pitch", "yaw"))
    (cr, cp, cy), (sr, sp, sy) = ((f(roll), f(pitch), f(yaw)) for f in (np.cos, np.sin))
    found[:, 3] = cr * cp * cy + sr * sp * sy
    found[:, 4] = sr * cp * cy - cr * sp * sy
    found[:, 5] = cr * sp * cy + sr * cp * sy
    found[:, 6] = cr * cp * sy - sr * sp * cy
    for joint, name in enumerate(robot.joint_names):
        found[:, 7 + joint] = log.column(f"joint_position.{name}")
    return found


class SceneLog:
    """Makes the messages of the topics from rows.

    Args:
        step: from row to row, s.
        ground: blocks of it beside the plane.
        lap: wall times of the control ticks since it was called last; None where nobody measures them.

    Attributes:
        topics, attachment: as :class:`gaitsmith.log.record.Scene` has them.
    """

    def __init__(
        self,
        robot: Robot,
        columns: tuple[str, ...],
        step: float,
        ground: Sequence[Block] = (),
        lap: Callable[[], tuple[int, TickTimes]] | None = None,
    ) -> None:
        self._robot, self._columns, self._lap = robot, columns, lap
        self._every, self._seen = max(1, round(1.0 / (_RATE * step))), 0
        self._data = mujoco.MjData(robot.model)
        self._bodies = [(body, robot.model.body(body).name) for body in range(1, robot.model.nbody)]
        self._ground = ground
        schemas = ("FrameTransforms", "JointStates", "SceneUpdate", "SceneUpdate")
        names = ("/tf", "/joint_states", "/robot", "/steps")
        self.topics = [_topic(name, schema) for name, schema in zip(names, schemas, strict=True)]
        self.topics.append(Topic("/tick_times"))
        clouds = ((name, body_points(robot, body)) for body, name in self._bodies)
        self._clouds = [(name, points) for name, points in clouds if len(points)]
        self.topics += [_topic(f"/points/{name}", "PointCloud") for name, _ in self._clouds]
        self.attachment = _attachment(robot)
        self._transforms, self._states, self._steps = self._forms()

    def begin(self) -> list[Messages]:
        """The robot's shapes and the ground."""
        found = (body_entity(self._robot, body, name) for body, name in self._bodies)
        shown = [pb.message(2, made) for made in (*found, ground_entity(self._ground, WORLD)) if made is not None]
        forms = [(_ROBOT, pb.joined(*shown))]
        forms += [(_TICKS + 1 + k, cloud(*one)) for k, one in enumerate(self._clouds)]
        start = np.zeros(1, np.uint64)
        return [Messages(topic, start, pb.filled(form, np.zeros((1, 0)), start)) for topic, form in forms]

    def show(self, rows: Array) -> list[Messages]:
        """What is seen in every so many rows, and how long the ticks took."""
        log = Log(self._columns, rows[-self._seen % self._every :: self._every])
        self._seen += len(rows)
        found = []
        if len(log.rows):
            stamps = np.round(log.time * 1e9).clip(min=0).astype(np.uint64)
            torso = positions(log, self._robot)
            joints = np.stack([log.column(f"{what}.{name}") for name in self._robot.joint_names for what in _WHAT], 1)
            filled = (
                (_TF, self._transforms, self._places(torso)),
                (_JOINTS, self._states, joints),
                (_STEPS, self._steps, self._seen_steps(log, torso)),
            )
            found += [Messages(topic, stamps, pb.filled(form, values, stamps)) for topic, form, values in filled]
        if self._lap is not None:
            count, times = self._lap()
            told = {"time": float(rows[-1, 0]), "ticks": count, **times.model_dump()}
            content = np.frombuffer(json.dumps(told).encode(), np.uint8)[None]
            found.append(Messages(_TICKS, *_one(max(round(told["time"] * 1e9), 0), content)))
        return found

    def _forms(self) -> tuple[Form, Form, Form]:
        """Of transforms, joint states, and what is drawn at the soles."""
        transforms = [
            pb.message(
                1,
                pb.stamp(1),
                pb.text(2, WORLD),
                pb.text(3, name),
                pb.message(4, pb.columns(*range(7 * k, 7 * k + 3))),
                pb.message(5, pb.columns(7 * k + 4, 7 * k + 5, 7 * k + 6, 7 * k + 3)),  # from w x y z
            )
            for k, (_, name) in enumerate(self._bodies)
        ]
        states = [
            pb.message(2, pb.text(1, name), pb.column(2, 3 * k), pb.column(3, 3 * k + 1), pb.column(5, 3 * k + 2))
            for k, name in enumerate(self._robot.joint_names)
        ]
        up = pb.numbers(0.0, -math.sqrt(0.5), 0.0, math.sqrt(0.5))  # x turned to z
        thick = 0.02 * self._robot.card.gait.height
        arrows = [
            pb.message(
                7,
                pb.message(1, pb.message(1, pb.columns(*range(4 * k, 4 * k + 3))), pb.message(2, up)),
                pb.column(2, 4 * k + 3),
                pb.number(3, thick),
                pb.number(4, 2.0 * thick),
                pb.number(5, 2.0 * thick),
                pb.message(6, pb.numbers(*_FORCE)),
            )
            for k in range(len(self._robot.legs))
        ]
        at = 4 * len(arrows)
        mark = cube(
            pb.columns(*range(at, at + 3)),
            pb.columns(*range(at + 3, at + 7)),
            pb.columns(*range(at + 7, at + 10)),
            _AIM,
        )
        steps = [entity("forces", WORLD, *arrows), entity("foothold", WORLD, mark)]
        return (
            pb.joined(*transforms),
            pb.joined(pb.stamp(1), *states),
            pb.joined(*(pb.message(2, one) for one in steps)),
        )

    def _places(self, torso: Array) -> Array:
        """(n, 7 k) position and quaternion of every body."""
        found = np.empty((len(torso), len(self._bodies), 7))
        for k, q in enumerate(torso):
            self._data.qpos[:] = q
            mujoco.mj_kinematics(self._robot.model, self._data)
            found[k, :, :3], found[k, :, 3:] = self._data.xpos[1:], self._data.xquat[1:]
        return found.reshape(len(torso), -1)

    def _seen_steps(self, log: Log, torso: Array) -> Array:
        """(n, 4 legs + 10) place and length of every force; place, turn and size of the foothold's mark.

        The foothold counts from the hip midpoint, in the heading frame; a plan's is where the sole is told to be now.
        """
        robot, legs = self._robot, self._robot.legs
        true = "true." if "true.torso_z" in log.columns else "believed."
        soles = np.stack([[log.column(f"{true}{leg.name}_sole_{axis}") for axis in "xyz"] for leg in legs])
        force = np.stack([log.column(f"{true}{leg.name}_force") for leg in legs])
        weight = robot.mass * float(np.linalg.norm(robot.model.opt.gravity))
        drawn = force * _WEIGHT * robot.card.gait.height / weight
        found = [np.concatenate([place, length[None]]) for place, length in zip(soles, drawn, strict=True)]
        stance = log.column("stance").astype(int)
        aims = (log.column("mode") == 1.0) & (stance < len(legs))
        swing = np.where(aims, 1 - stance, 0)
        told = np.stack([[log.column(f"foot_desired.{leg.name}.{axis}") for axis in "xyz"] for leg in legs])
        planned = log.column("plan_phase") >= 0.0
        rows = np.arange(len(log.rows))
        free = np.stack([log.column("foothold.x"), log.column("foothold.y"), np.zeros(len(rows))])
        relative = np.where(planned, told[swing, :, rows].T, free)
        hip, yaw = np.empty((3, len(rows))), log.column(f"{true}torso_yaw")
        for k, q in enumerate(torso):
            mujoco.mju_rotVecQuat(turned := np.empty(3), robot.hip_midpoint, q[3:7])
            hip[:, k] = q[:3] + turned
        cos, sin = np.cos(yaw), np.sin(yaw)
        place = hip + np.stack(
            [cos * relative[0] - sin * relative[1], sin * relative[0] + cos * relative[1], relative[2]]
        )
        place[2] = np.where(planned, place[2], soles[np.where(aims, stance, 0), 2, rows])
        shape = np.array([(leg.sole.heel + leg.sole.toe, max(2.0 * leg.sole.half_width, _THIN), _THIN) for leg in legs])
        middle = np.array([0.5 * (leg.sole.toe - leg.sole.heel) for leg in legs])[swing]
        place[:2] += middle * np.stack([cos, sin])
        turn = np.stack([np.zeros(len(yaw)), np.zeros(len(yaw)), np.sin(0.5 * yaw), np.cos(0.5 * yaw)])
        return np.concatenate([*found, place, turn, np.where(aims, shape[swing].T, 0.0)]).T


def _one(stamp: int, content: npt.NDArray[np.uint8]) -> tuple[npt.NDArray[np.uint64], npt.NDArray[np.uint8]]:
    return np.array([stamp], np.uint64), content


def _topic(name: str, schema: str) -> Topic:
    """A topic with one of Foxglove's schemas, as Foxglove publishes them."""
    full = f"foxglove.{schema}"
    return Topic(name, full, (files("gaitsmith.log") / "schemas" / f"{full}.bin").read_bytes())


def _attachment(robot: Robot) -> Attachment | None:
    """The robot's model; None if it is no file that can be read now."""
    path = robot.model_path
    try:
        model = read_bounded(path, _LARGEST_MODEL)
    except BadInput:
        return None
    return Attachment(create_time=0, log_time=0, name=path.name, media_type="application/xml", data=model)
