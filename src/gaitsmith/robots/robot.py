"""A loaded robot: what plant, dynamics and control read, and nothing that changes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from gaitsmith.robots.assembly import with_scene
from gaitsmith.robots.card import RobotCard
from gaitsmith.robots.sole import Sole

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Leg:
    """One leg; indices count joints in the order of `v[6:]`.

    Attributes:
        name: `left` or `right`.
        side: +1 for left, -1 for right.
        joints: names, hip to ankle.
        joint_indices: (n,), the same as indices.
        knee: index of the knee.
        ankle_pitch: index of the ankle's pitch joint.
        ankle_roll: index of the ankle's roll joint, -1 without one.
        sole_site: name of the sole frame in the model.
        sole_body: body that carries the sole frame.
        sole_position: (3,), sole frame's origin in that body's frame, m.
        sole_rotation: (3, 3), sole frame to that body's frame.
        sole: shape of the sole; a line if the ankle has no roll.
        hip_anchor: (3,), first joint's anchor in the torso frame at zero joint angles, m.
    """

    name: str
    side: int
    joints: tuple[str, ...]
    joint_indices: Indices
    knee: int
    ankle_pitch: int
    ankle_roll: int
    sole_site: str
    sole_body: int
    sole_position: Array
    sole_rotation: Array
    sole: Sole
    hip_anchor: Array


@dataclass(frozen=True, eq=False)
class Robot:
    """A robot as loaded from its card and model; arrays are read-only, per joint in the order of `v[6:]`.

    Attributes:
        card: the card, completed by what the model says and by what is assumed for a robot of its size.
        model_path: absolute path of the model file.
        content_hash: SHA-256 of card, model, included files and meshes, as hexadecimal digits.
        mass: total mass, kg.
        model: the robot alone, its torso on a free joint.
        notes: what the loader changed with respect to the model file, in words.
        joint_names: actuated joints.
        joint_dofs: (n,), their indices in `v`.
        actuators: (n,), the model's actuator of each joint.
        position_low: (n,), rad or m.
        position_high: (n,), rad or m.
        velocity_limit: (n,), largest speed, rad/s or m/s.
        torque_limit: (n,), largest torque or force, N·m or N.
        torso_body: body with the free joint.
        hip_midpoint: (3,), mean of the legs' hip anchors in the torso frame, m.
        imu_position: (3,), in the torso frame, m.
        imu_rotation: (3, 3), IMU frame to torso frame.
        legs: left, right.
        home: (n,), angles that the joints outside the legs hold; the leg's are 0 or the limit next to it.
        spec: what `model` was compiled from; :meth:`make_spec` copies it.
        scene: other bodies of the model file; None without any.
    """

    card: RobotCard
    model_path: Path
    content_hash: str
    mass: float
    model: mujoco.MjModel
    notes: tuple[str, ...]
    joint_names: tuple[str, ...]
    joint_dofs: Indices
    actuators: Indices
    position_low: Array
    position_high: Array
    velocity_limit: Array
    torque_limit: Array
    torso_body: int
    hip_midpoint: Array
    imu_position: Array
    imu_rotation: Array
    legs: tuple[Leg, Leg]
    home: Array
    spec: mujoco.MjSpec
    scene: mujoco.MjSpec | None

    def make_spec(self) -> mujoco.MjSpec:
        """A fresh specification of the robot, to which a plant adds terrain; compiled, it has `model`'s indices.

        What else lies in the model's scene comes after the robot.
        """
        return with_scene(self.spec, self.scene)


def describe(robot: Robot) -> dict[str, Any]:
    """The robot as plain data for JSON: `joints` in the order of `q[7:]`, sole distances from the sole frame in m."""
    return {
        "name": robot.card.name,
        "description": robot.card.description,
        "model_path": str(robot.model_path),
        "content_hash": robot.content_hash,
        "mass": robot.mass,
        "joints": list(robot.joint_names),
        "torso": robot.card.torso,
        "hip_midpoint": robot.hip_midpoint.tolist(),
        "legs": [
            {
                "name": leg.name,
                "joints": list(leg.joints),
                "sole_frame": leg.sole_site,
                "sole": leg.sole.model_dump(exclude=None if leg.sole.points else {"points"}),
            }
            for leg in robot.legs
        ],
        "limits": {name: robot.card.limits[name].model_dump(mode="json") for name in robot.joint_names},
        "home": dict(zip(robot.joint_names, robot.home.tolist(), strict=True)),
        "gait": robot.card.gait.model_dump(mode="json"),
        "gait_limits": robot.card.gait_limits.model_dump(mode="json"),
        "presets": list(robot.card.presets),
        "assumptions": [assumption.model_dump() for assumption in robot.card.assumptions],
        "notes": list(robot.notes),
    }
