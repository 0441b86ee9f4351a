"""The default control parameters of any robot, from its size, mass and gravity; a card may override any of them.

One set of dimensionless gains serves every robot. Lengths are in units of z, the height of the centre of mass above the
soles when standing, times in 1/ω = √(z/g), speeds in U = √(g z), torques in m g z, forces in m g. Weights of angular
rows are in units of (z / 0.6 m)², so that linear and angular errors weigh alike on every robot.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from gaitsmith.dynamics.algorithms import update_dynamics
from gaitsmith.dynamics.tree import make_tree_state, read_tree
from gaitsmith.errors import BadInput
from gaitsmith.kinematics.posture import standing_posture
from gaitsmith.robots import Robot
from gaitsmith.robots.presets import ControlParameters, PrintedParameters

_ATTITUDE, _ATTITUDE_RATIO = 12.0, 0.9  # ω², damping ratio
_TRACKING, _SWING = 18.0, 36.0  # ω², critically damped: joints, the swing foot
_STANDING = (2.0, 2.7)  # ω², ω
_OTHER_JOINTS = (9.0, 6.0)  # ω², ω


@dataclass(frozen=True)
class Scale:
    """A robot's own units.

    Attributes:
        mass: kg.
        gravity: m/s².
        height: z of the centre of mass above the soles when standing, m.
        half_width: largest half width of a sole, m.
        edge: half the length of the shortest edge that a sole turns about, m; 0 for a line.
        width: half the lateral distance between the soles by default, m.
    """

    mass: float
    gravity: float
    height: float
    half_width: float
    edge: float
    width: float

    @property
    def rate(self) -> float:
        """ω = √(g/z), 1/s."""
        return math.sqrt(self.gravity / self.height)

    @property
    def speed(self) -> float:
        """U = √(g z), m/s."""
        return math.sqrt(self.gravity * self.height)

    @property
    def weight(self) -> float:
        """M g, N."""
        return self.mass * self.gravity

    @property
    def torque(self) -> float:
        """M g z, N·m."""
        return self.weight * self.height


def robot_scale(robot: Robot) -> Scale:
    """Units of a robot in its default posture.

    Raises:
        BadInput: the card's default height is out of the legs' reach.
    """
    gait = robot.card.gait
    q = standing_posture(robot, gait.height, gait.width)
    tree = read_tree(robot.model)
    state = make_tree_state(tree)
    update_dynamics(tree, state, q, np.zeros(robot.model.nv))
    return Scale(
        mass=robot.mass,
        gravity=float(np.linalg.norm(robot.model.opt.gravity)),
        height=float(state.com[2]),
        half_width=max(leg.sole.half_width for leg in robot.legs),
        edge=min(0.5 * float(end[2] - end[1]) for leg in robot.legs for end in leg.sole.ends),
        width=gait.width,
    )


def default_parameters(scale: Scale) -> dict[str, Any]:
    """The default set in SI units, as plain data; see the module."""
    z, rate, speed, torque, weight = scale.height, scale.rate, scale.speed, scale.torque, scale.weight
    angular = (z / 0.6) ** 2
    stiffness, damping = _ATTITUDE * rate**2, 2.0 * _ATTITUDE_RATIO * math.sqrt(_ATTITUDE) * rate
    tracking, swing = ((gain * rate**2, 2.0 * math.sqrt(gain) * rate) for gain in (_TRACKING, _SWING))
    none: dict[str, Any] = dict.fromkeys(("swing_stiffness", "swing_damping", "stance_stiffness", "stance_damping"), ())
    return {
        "foothold": {
            "velocity_gain": (0.2, 0.2),
            "acceleration_gain": 0.0,
            "deadbeat": 1.0,
            "prediction": 1.0,
            "mean_speed": 1.0,
            "sway": 1.0,
            "reach": 0.66 * z,
            "spread": 0.67 * z,
            "separation": max(2.0 * scale.half_width + 0.02 * z, 1.3 * scale.width),
        },
        "speed": {
            "integral_gain": (0.3, 0.3),
            "integral_limit": 0.1 * speed,
            "largest_error": 0.037 * speed,
            "station_gain": (0.06 * rate, 0.06 * rate),
            "station_limit": 0.02 * speed,
            "settled_speed": 0.008 * speed,
        },
        "step_time": {"shortest": 0.5, "foot_speed": 0.74 * speed},
        "printed": dict.fromkeys(PrintedParameters.model_fields, False),
        "cop": {"gain": (2.0, 2.0), "weight": 2.2 * angular * rate**4 / torque**2},
        "attitude": {
            f"{axis}_{name}": value
            for axis in ("roll", "pitch", "yaw")
            for name, value in (("stiffness", stiffness), ("damping", damping))
        },
        "tracking": {
            "joint_stiffness": tracking[0],
            "joint_damping": tracking[1],
            "foot_stiffness": swing[0],
            "foot_damping": swing[1],
        },
        "standing": {
            "com_stiffness": _STANDING[0] * rate**2,
            "com_damping": _STANDING[1] * rate,
            "weight": 1.0,
            "weight_shift": True,
            "longest_shift": 8.0 / rate,
            "entry_speed": 0.055 * speed,
            "straddle": 0.08 * z,
            "height_rate": 0.055 * speed,
        },
        "weights": {
            "stance_linear": 100.0,
            "stance_angular": 10.0 * angular,
            "swing_foot": 20.0,
            "attitude": 10.0 * angular,
            "yaw": 10.0 * angular,
            "knee": 10.0 * angular,
            "swing_joint": 0.3 * angular,
            "swing_ankle": 1.0 * angular,
            "other_joint": 0.1 * angular,
            "torque_change": 0.6 / torque**2,
            "regularisation": 0.006 / torque**2,
        },
        "contact": {
            "friction": 0.6,
            "normal_force": (0.03 * weight, 4.0 * weight),
            "zmp_margin": 0.02 * z,
            "yaw_friction": min(0.1 * z, 0.75 * scale.edge or math.inf),
        },
        "joints": {"torque_rate": 12.0 * torque * rate, "stop_rate": 8.0 * rate},
        "touchdown": {"force": 0.08 * weight, "earliest": 0.5, "latest": 1.6, "descent_speed": 0.07 * speed},
        "inverse_kinematics": {"gain": 10.0, "step_weight": 1e-6, "change_weight": 1e-6, "pitch_weight": 1.0},
        "joint_gains": none,
        "joint_gains_estimated": none,
        "other_joints": {"stiffness": _OTHER_JOINTS[0] * rate**2, "damping": _OTHER_JOINTS[1] * rate},
        "estimator": {
            "accelerometer": 0.3,
            "accelerometer_drift": 0.02,
            "leg_odometry": 0.037 * speed,
            "foot_height": 0.007 * z,
            "joint_acceleration": 200.0,
            "encoder": 3e-4,
        },
    }


def preset_parameters(robot: Robot, scale: Scale, preset: str) -> ControlParameters:
    """A preset of the robot's card over the default set.

    Raises:
        BadInput: the card has no such preset.
    """
    presets = robot.card.presets
    if preset not in presets:
        raise BadInput("preset", preset, "one of " + ", ".join(sorted(presets)))
    given = presets[preset].model_dump(exclude_none=True)
    default = default_parameters(scale)
    return ControlParameters.model_validate({name: {**group, **given.get(name, {})} for name, group in default.items()})
