"""A run as MCAP with Foxglove's own schemas: a robot that moves in Foxglove and Rerun without any set-up.

Topics: ``/tf`` (every body in the world), ``/joint_states``, ``/robot`` (its shapes, fixed to the bodies' frames),
``/forces`` (arrows at the soles), ``/command``, ``/telemetry`` (all other columns) and ``/events`` as JSON. The robot's
model file and the scenario are attached.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
import numpy.typing as npt

from gaitsmith.errors import GaitsmithError
from gaitsmith.files import read_bounded, replacing
from gaitsmith.log import Log
from gaitsmith.reports.log_tables import LogSource
from gaitsmith.reports.video import positions
from gaitsmith.robots import Robot

if TYPE_CHECKING:
    from foxglove.messages import Quaternion, SceneEntity, Vector3

WORLD = "world"
_LARGEST_MODEL = 20_000_000  # bytes
_FORCE = 1e-3  # m of arrow per N
_SHAFT, _HEAD = 0.02, 0.04  # m
_SECOND = 1_000_000_000  # ns
_GREY = (0.7, 0.72, 0.75, 1.0)
_APART = ("joint_position.", "joint_velocity.", "torque.", "command.", "time")
Array = npt.NDArray[np.float64]


def write_foxglove(source: LogSource, robot: Robot, path: Path, rate: float) -> int:
    """Write a run for Foxglove; the file appears whole or not at all. Returns the number of instants.

    Args:
        source: the log.
        robot: that was run.
        path: of the file.
        rate: instants a second of simulated time, Hz; at most those of the log.

    Raises:
        BadInput: the file cannot be written.
        GaitsmithError: the Foxglove SDK is not installed.
    """
    try:
        import foxglove
    except ImportError:
        raise GaitsmithError("Foxglove needs its SDK: pip install 'gaitsmith[logs]'") from None
    with replacing(path) as file:
        context = foxglove.Context()
        with foxglove.open_mcap(file, context=context) as writer:
            model = read_bounded(robot.model_path, _LARGEST_MODEL)
            writer.attach(
                log_time=0, create_time=0, name=robot.model_path.name, media_type="application/xml", data=model
            )
            stage = _Stage(robot, context)
            count, due = 0, -math.inf
            for block in source:
                log = Log(source.head.columns, block)
                chosen = []
                for row, time in enumerate(log.time):
                    if time >= due - 1e-9:
                        chosen.append(row)
                        due = time + 1.0 / rate
                stage.show(Log(source.head.columns, block[chosen]))
                count += len(chosen)
            stage.tell(source.events)
    return count


class _Stage:
    """The channels, and what goes into them."""

    def __init__(self, robot: Robot, context: Any) -> None:
        from foxglove import Channel
        from foxglove.channels import FrameTransformsChannel, JointStatesChannel, SceneUpdateChannel

        self._robot, self._data = robot, mujoco.MjData(robot.model)
        self._bodies = [(b, robot.model.body(b).name) for b in range(1, robot.model.nbody)]
        self._transforms = FrameTransformsChannel("/tf", context=context)
        self._joints = JointStatesChannel("/joint_states", context=context)
        self._shapes = SceneUpdateChannel("/robot", context=context)
        self._forces = SceneUpdateChannel("/forces", context=context)
        self._command, self._telemetry, self._events = (
            Channel(f"/{name}", schema={"type": "object", "additionalProperties": True}, context=context)
            for name in ("command", "telemetry", "events")
        )
        self._dressed = False

    def show(self, log: Log) -> None:
        """Every row of a log."""
        where = positions(log, self._robot)
        names = [name for name in log.columns if not name.startswith(_APART)]
        commanded = [name for name in log.columns if name.startswith("command.")]
        for row, time in enumerate(log.time):
            stamp = round(float(time) * _SECOND)
            if not self._dressed:
                self._dress(stamp)
            self._data.qpos[:] = where[row]
            mujoco.mj_kinematics(self._robot.model, self._data)
            self._place(stamp)
            self._move(stamp, log, row)
            self._push(stamp, log, row)
            for channel, chosen in ((self._command, commanded), (self._telemetry, names)):
                values = {name.removeprefix("command."): _plain(log.column(name)[row]) for name in chosen}
                channel.log(values, log_time=stamp)

    def tell(self, events: list[dict[str, Any]]) -> None:
        """What happened once."""
        for event in events:
            self._events.log(event, log_time=max(0, round(event["time"] * _SECOND)))

    def _dress(self, stamp: int) -> None:
        from foxglove.messages import SceneUpdate

        self._dressed = True
        entities = [entity for body, name in self._bodies if (entity := _entity(self._robot, body, name)) is not None]
        self._shapes.log(SceneUpdate(entities=entities), log_time=stamp)

    def _place(self, stamp: int) -> None:
        from foxglove.messages import FrameTransform, FrameTransforms

        transforms = [
            FrameTransform(
                timestamp=_stamp(stamp),
                parent_frame_id=WORLD,
                child_frame_id=name,
                translation=_vector(self._data.xpos[body]),
                rotation=_quaternion(self._data.xquat[body]),
            )
            for body, name in self._bodies
        ]
        self._transforms.log(FrameTransforms(transforms=transforms), log_time=stamp)

    def _move(self, stamp: int, log: Log, row: int) -> None:
        from foxglove.messages import JointState, JointStates

        joints = [
            JointState(
                name=name,
                position=float(log.column(f"joint_position.{name}")[row]),
                velocity=float(log.column(f"joint_velocity.{name}")[row]),
                effort=float(log.column(f"torque.{name}")[row]),
            )
            for name in self._robot.joint_names
        ]
        self._joints.log(JointStates(timestamp=_stamp(stamp), joints=joints), log_time=stamp)

    def _push(self, stamp: int, log: Log, row: int) -> None:
        from foxglove.messages import ArrowPrimitive, Color, Pose, SceneEntity, SceneUpdate

        arrows = []
        for leg in self._robot.legs:
            if f"true.{leg.name}_force" in log.columns:
                at = np.array([log.column(f"true.{leg.name}_sole_{axis}")[row] for axis in "xyz"])
                length = _FORCE * float(log.column(f"true.{leg.name}_force")[row])
                up = np.array([math.sqrt(0.5), 0.0, -math.sqrt(0.5), 0.0])  # x turned to z
                arrows.append(
                    ArrowPrimitive(
                        pose=Pose(position=_vector(at), orientation=_quaternion(up)),
                        shaft_length=max(length, 0.0),
                        shaft_diameter=_SHAFT,
                        head_length=_HEAD if length > 0.0 else 0.0,
                        head_diameter=_HEAD,
                        color=Color(r=0.3, g=0.6, b=0.8, a=0.9),
                    )
                )
        entity = SceneEntity(timestamp=_stamp(stamp), frame_id=WORLD, id="forces", arrows=arrows)
        self._forces.log(SceneUpdate(entities=[entity]), log_time=stamp)


def _entity(robot: Robot, body: int, name: str) -> SceneEntity | None:
    """A body's shapes, fixed to its frame; None without any."""
    from foxglove.messages import Color, CubePrimitive, CylinderPrimitive, Pose, SceneEntity, SpherePrimitive

    model, shapes = robot.model, mujoco.mjtGeom
    colour = Color(r=_GREY[0], g=_GREY[1], b=_GREY[2], a=_GREY[3])
    made: dict[str, list[Any]] = {"cubes": [], "spheres": [], "cylinders": [], "triangles": []}
    for g in np.flatnonzero(model.geom_bodyid == body):
        size, kind = model.geom_size[g], model.geom_type[g]
        pose = Pose(position=_vector(model.geom_pos[g]), orientation=_quaternion(model.geom_quat[g]))
        if kind == shapes.mjGEOM_BOX:
            made["cubes"].append(CubePrimitive(pose=pose, size=_vector(2.0 * size), color=colour))
        elif kind in (shapes.mjGEOM_SPHERE, shapes.mjGEOM_ELLIPSOID):
            across = 2.0 * (size if kind == shapes.mjGEOM_ELLIPSOID else np.full(3, size[0]))
            made["spheres"].append(SpherePrimitive(pose=pose, size=_vector(across), color=colour))
        elif kind in (shapes.mjGEOM_CYLINDER, shapes.mjGEOM_CAPSULE):
            across = np.array([2.0 * size[0], 2.0 * size[0], 2.0 * size[1]])
            made["cylinders"].append(
                CylinderPrimitive(pose=pose, size=_vector(across), bottom_scale=1.0, top_scale=1.0, color=colour)
            )
            if kind == shapes.mjGEOM_CAPSULE:
                rotation = np.zeros(9)
                mujoco.mju_quat2Mat(rotation, model.geom_quat[g])
                for side in (-1.0, 1.0):
                    at = model.geom_pos[g] + side * size[1] * rotation.reshape(3, 3)[:, 2]
                    ball = Pose(position=_vector(at), orientation=_quaternion(model.geom_quat[g]))
                    made["spheres"].append(
                        SpherePrimitive(pose=ball, size=_vector(np.full(3, 2.0 * size[0])), color=colour)
                    )
        elif kind == shapes.mjGEOM_MESH:
            made["triangles"].append(_triangles(model, int(model.geom_dataid[g]), pose, colour))
    if not any(made.values()):
        return None
    return SceneEntity(frame_id=name, id=name, frame_locked=True, **made)


def _triangles(model: mujoco.MjModel, mesh: int, pose: Any, colour: Any) -> Any:
    """A mesh of the model."""
    from foxglove.messages import Point3, TriangleListPrimitive

    first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    faces = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]]
    points = [Point3(x=x, y=y, z=z) for x, y, z in model.mesh_vert[first : first + count].astype(float).tolist()]
    return TriangleListPrimitive(pose=pose, points=points, color=colour, indices=faces.ravel().tolist())


def _stamp(nanoseconds: int) -> Any:
    from foxglove.messages import Timestamp

    return Timestamp(nanoseconds // _SECOND, nanoseconds % _SECOND)


def _vector(values: Array) -> Vector3:
    from foxglove.messages import Vector3

    x, y, z = values.tolist()
    return Vector3(x=x, y=y, z=z)


def _quaternion(wxyz: Array) -> Quaternion:
    """From w x y z."""
    from foxglove.messages import Quaternion

    w, x, y, z = wxyz.tolist()
    return Quaternion(x=x, y=y, z=z, w=w)


def _plain(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
