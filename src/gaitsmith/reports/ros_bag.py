"""A run as a ROS 2 bag: joint states, the torso's transform, and every column as one array; no ROS needed."""

from __future__ import annotations

import math
import shutil
from pathlib import Path
from typing import Any

import numpy as np

from gaitsmith.errors import BadInput, GaitsmithError
from gaitsmith.log import Log
from gaitsmith.reports.log_tables import LogSource
from gaitsmith.robots import Robot
from gaitsmith.simulation.scene_log import positions

COLUMNS, JOINTS, TRANSFORMS = "/gaitsmith", "/joint_states", "/tf"
_SECOND = 1_000_000_000  # ns


def write_bag(source: LogSource, robot: Robot, path: Path) -> None:
    """Write a bag, which is a folder; it appears whole or not at all.

    Raises:
        BadInput: something is there already, or the folder cannot be written.
        GaitsmithError: rosbags is not installed.
    """
    try:
        from rosbags.rosbag2 import StoragePlugin, Writer
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise GaitsmithError("a ROS 2 bag needs rosbags: pip install 'gaitsmith[logs]'") from None
    if path.exists():
        raise BadInput("--out", str(path), "a name that is free; a bag is a folder")
    store = get_typestore(Stores.ROS2_HUMBLE)
    part = path.with_name(f".{path.name}.part")
    inner = part / path.name  # files of a bag are named after its folder
    shutil.rmtree(part, ignore_errors=True)
    try:
        part.mkdir()
        with Writer(inner, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
            kinds = {
                JOINTS: "sensor_msgs/msg/JointState",
                TRANSFORMS: "tf2_msgs/msg/TFMessage",
                COLUMNS: "std_msgs/msg/Float64MultiArray",
            }
            topics = {topic: writer.add_connection(topic, kind, typestore=store) for topic, kind in kinds.items()}
            for block in source:
                for topic, stamp, message in _messages(Log(source.head.columns, block), robot, store.types):
                    writer.write(topics[topic], stamp, store.serialize_cdr(message, kinds[topic]))
        inner.rename(path)
    except OSError as error:
        raise BadInput("--out", str(path), "a folder that can be written", str(error.strerror)) from None
    finally:
        shutil.rmtree(part, ignore_errors=True)


def _messages(log: Log, robot: Robot, types: Any) -> Any:
    """Topic, time in ns and message of every row."""
    names = list(robot.joint_names)
    blocks = [
        np.stack([log.column(f"{what}.{name}") for name in names], axis=1)
        for what in ("joint_position", "joint_velocity", "torque")
    ]
    where, root = positions(log, robot), robot.model.body(robot.torso_body).name
    dimension = types["std_msgs/msg/MultiArrayDimension"](label=",".join(log.columns), size=len(log.columns), stride=1)
    layout = types["std_msgs/msg/MultiArrayLayout"](dim=[dimension], data_offset=0)
    vector, quaternion = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"]
    for row, time in enumerate(log.time):
        stamp = round(float(time) * _SECOND)
        whole = math.floor(stamp / _SECOND)
        header = types["std_msgs/msg/Header"](
            stamp=types["builtin_interfaces/msg/Time"](sec=whole, nanosec=stamp - whole * _SECOND), frame_id="world"
        )
        position, velocity, effort = (block[row] for block in blocks)
        yield (
            JOINTS,
            stamp,
            types["sensor_msgs/msg/JointState"](
                header=header, name=names, position=position, velocity=velocity, effort=effort
            ),
        )
        x, y, z, w, qx, qy, qz = where[row, :7].tolist()
        transform = types["geometry_msgs/msg/Transform"](
            translation=vector(x=x, y=y, z=z), rotation=quaternion(x=qx, y=qy, z=qz, w=w)
        )
        stamped = types["geometry_msgs/msg/TransformStamped"](header=header, child_frame_id=root, transform=transform)
        yield TRANSFORMS, stamp, types["tf2_msgs/msg/TFMessage"](transforms=[stamped])
        yield COLUMNS, stamp, types["std_msgs/msg/Float64MultiArray"](layout=layout, data=log.rows[row])
