"""Joints fixed at an angle: the body's frame takes the joint's motion, whatever else the body has."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Pose = tuple[Array, Array]
"""Position and quaternion w x y z."""


def turn(spec: mujoco.MjSpec, joint: mujoco.MjsJoint, angle: float) -> None:
    """Move a joint's body as the joint does from its zero, so that the joint's present zero is there.

    Args:
        spec: the joint's specification; lengths and angles of its elements as in the file.
        joint: a hinge or slide.
        angle: rad or m.
    """
    body = joint.parent
    if angle == 0.0:
        return
    place, turned = _outer(spec, joint.frame)
    axis = np.asarray(joint.axis) / np.linalg.norm(joint.axis)
    axis, anchor = _rotated(turned, axis), place + _rotated(turned, np.asarray(joint.pos))
    if joint.type == mujoco.mjtJoint.mjJNT_SLIDE:
        motion = (angle * axis, np.array([1.0, 0.0, 0.0, 0.0]))
    else:
        spin = np.array([np.cos(angle / 2.0), *(np.sin(angle / 2.0) * axis)])
        motion = (anchor - _rotated(spin, anchor), spin)
    body.pos, body.quat = _product((np.asarray(body.pos), _own(spec, body)), motion)
    body.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
    back = motion[1] * [1.0, -1.0, -1.0, -1.0]
    for other in body.joints:  # those before it now turn a frame that this one has moved
        if other == joint:
            break
        place, turned = _outer(spec, other.frame)
        where = place + _rotated(turned, np.asarray(other.pos))
        other.pos = _rotated(back, where - motion[0])
        other.axis = _rotated(back, _rotated(turned, np.asarray(other.axis)))
        if other.frame is not None:
            other.set_frame(body.add_frame())


def _outer(spec: mujoco.MjSpec, frame: mujoco.MjsFrame | None) -> Pose:
    """Pose in the body of what lies in nested frames."""
    pose: Pose = (np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))
    while frame is not None:
        pose = _product((np.asarray(frame.pos), _own(spec, frame)), pose)
        frame = frame.frame
    return pose


def _own(spec: mujoco.MjSpec, element: Any) -> Array:
    """An element's quaternion, however the file gives its orientation."""
    if element.alt.type == mujoco.mjtOrientation.mjORIENTATION_QUAT:
        quaternion = np.asarray(element.quat, dtype=np.float64)
        return quaternion / np.linalg.norm(quaternion)
    compiler = spec.compiler
    return np.array(
        spec.resolve_orientation(degree=bool(compiler.degree), sequence=compiler.eulerseq, orientation=element.alt)
    )


def _product(first: Pose, second: Pose) -> Pose:
    quaternion = np.empty(4)
    mujoco.mju_mulQuat(quaternion, first[1], second[1])
    return first[0] + _rotated(first[1], second[0]), quaternion


def _rotated(quaternion: Array, vector: Array) -> Array:
    result = np.empty(3)
    mujoco.mju_rotVecQuat(result, np.asarray(vector, dtype=np.float64), quaternion)
    return result
