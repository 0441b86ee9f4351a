"""What a model says of its joints: ranges, and what its actuators can give."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import mujoco

from gaitsmith.errors import BadInput
from gaitsmith.robots.model_text import Drive


@dataclass(frozen=True)
class ModelLimits:
    """What a model allows one joint; None where it is silent.

    Attributes:
        position: rad or m.
        velocity: rad/s or m/s.
        torque: N·m or N.
    """

    position: tuple[float, float] | None
    velocity: float | None
    torque: float | None


def model_limits(
    spec: mujoco.MjSpec, joints: Mapping[str, Any], drives: Mapping[str, Drive], entry: str, notes: list[str]
) -> dict[str, ModelLimits]:
    """What the model allows each joint; its actuators are deleted.

    Args:
        spec: the model; loses its actuators.
        joints: of the robot, by name, in the model's order.
        drives: what a URDF says of them.
        entry: what errors begin with.
        notes: receives what becomes of the actuators.

    Raises:
        BadInput: an actuator acts on something else than a joint or a tendon.
    """
    torques: dict[str, float | None] = {}
    plain, order = True, []
    everywhere = {joint.name for joint in spec.joints}
    for actuator in list(spec.actuators):
        name, transmission = actuator.target, actuator.trntype
        if transmission in (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT) and name in joints:
            order.append(name)
            plain &= _plain(actuator)
            torque = _torque(spec, actuator)
            torques[name] = torque if name not in torques else _sum(torques[name], torque)
        elif transmission != mujoco.mjtTrn.mjTRN_TENDON and name not in everywhere:
            raise BadInput(f"{entry}: actuator {actuator.name}", name, "an actuator of a hinge or slide")
        spec.delete(actuator)
    if not plain:
        notes.append("replaced actuators by torque motors without gear, with the same limits at the joint")
    if order != list(joints):
        notes.append("torque motors, one a joint, in the order of the joints")
    found = {}
    for name, joint in joints.items():
        unit = math.pi / 180.0 if spec.compiler.degree and joint.type == mujoco.mjtJoint.mjJNT_HINGE else 1.0
        low, high = (float(bound) * unit for bound in joint.range)
        position = (low, high) if _limited(spec, joint.limited, low, high) else None
        drive = drives.get(name, Drive(None, None))
        force = [float(bound) for bound in joint.actfrcrange]
        bounds = [torques.get(name), drive.torque]
        if _limited(spec, joint.actfrclimited, *force):
            bounds.append(min(-force[0], force[1]))
        given = [bound for bound in bounds if bound is not None and bound > 0.0]
        found[name] = ModelLimits(position, drive.velocity, min(given, default=None))
    return found


def _limited(spec: mujoco.MjSpec, flag: int, low: float, high: float) -> bool:
    automatic = flag == mujoco.mjtLimited.mjLIMITED_AUTO and bool(spec.compiler.autolimits)
    return low < high and (automatic or flag == mujoco.mjtLimited.mjLIMITED_TRUE)


def _plain(actuator: mujoco.MjsActuator) -> bool:
    """Whether an actuator is a motor without gear."""
    linear = actuator.gaintype == mujoco.mjtGain.mjGAIN_FIXED and actuator.biastype == mujoco.mjtBias.mjBIAS_NONE
    static = actuator.dyntype == mujoco.mjtDyn.mjDYN_NONE
    return bool(linear and static and actuator.gear[0] == 1.0 and actuator.gainprm[0] == 1.0)


def _torque(spec: mujoco.MjSpec, actuator: mujoco.MjsActuator) -> float | None:
    """The torque that an actuator can give in both directions, N·m; None if nothing bounds it."""
    gear, bounds = abs(float(actuator.gear[0])), []
    low, high = map(float, actuator.forcerange)
    if _limited(spec, actuator.forcelimited, low, high):
        bounds.append(gear * min(-low, high))
    low, high = map(float, actuator.ctrlrange)
    fixed = actuator.gaintype == mujoco.mjtGain.mjGAIN_FIXED and actuator.biastype == mujoco.mjtBias.mjBIAS_NONE
    if fixed and _limited(spec, actuator.ctrllimited, low, high):
        bounds.append(gear * abs(float(actuator.gainprm[0])) * min(-low, high))
    return min(bounds, default=None)


def _sum(first: float | None, second: float | None) -> float | None:
    """Two actuators of one joint; one that nothing bounds leaves the sum unbounded."""
    return None if first is None or second is None else first + second
