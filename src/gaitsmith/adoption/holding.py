"""Why a robot cannot stand: motors that do not hold its weight, limits of left and right that do not match."""

from __future__ import annotations

from collections.abc import Iterable

import mujoco
import numpy as np

from gaitsmith.adoption.anatomy import Anatomy
from gaitsmith.kinematics.posture import standing_posture
from gaitsmith.robots import Robot

_SPARE = 0.9  # of a motor's torque, at most to be spent on standing
_SHOWN = 4  # joints that are named
_MIRRORED = np.array([-1.0, 1.0, -1.0])  # an axis of turning, seen in a mirror between left and right
_UNLIKE = 0.1  # rad: what is left and right limits' own affair


def held_loads(robot: Robot) -> dict[str, float]:
    """Torque that standing still takes of every joint, both soles carrying half of the weight, N·m.

    Raises:
        BadInput: it cannot stand in its card's posture.
    """
    gait, model = robot.card.gait, robot.model
    data = mujoco.MjData(model)
    data.qpos[:] = standing_posture(robot, gait.height, gait.width)
    mujoco.mj_forward(model, data)
    needed = data.qfrc_bias - data.qfrc_passive
    jacobian = np.zeros((3, model.nv))
    for leg in robot.legs:
        mujoco.mj_jacSite(model, data, jacobian, None, model.site(leg.sole_site).id)
        needed -= jacobian.T @ (-0.5 * robot.mass * model.opt.gravity)
    return dict(zip(robot.joint_names, np.abs(needed[robot.joint_dofs]).tolist(), strict=True))


def too_weak(robot: Robot) -> dict[str, str]:
    """Joints whose motors cannot hold their load, and why, in words.

    Raises:
        BadInput: it cannot stand in its card's posture.
    """
    limits = dict(zip(robot.joint_names, robot.torque_limit.tolist(), strict=True))
    return {
        name: f"motors too weak for their load: {name} gives {limits[name]:.3g} of {load:.3g} N·m"
        for name, load in held_loads(robot).items()
        if load > _SPARE * limits[name]
    }


def outside(robot: Robot, names: Iterable[str]) -> list[str]:
    """Those joints that are not in the legs."""
    inside = {name for leg in robot.legs for name in leg.joints}
    return [name for name in names if name not in inside]


def why_weak(robot: Robot) -> str:
    """Leg motors that cannot hold the robot while it stands, in words; empty if all can."""
    weak = too_weak(robot)
    legs = [weak[name].partition(": ")[2] for name in weak if name not in outside(robot, weak)]
    return f"leg motors too weak for its weight: {', '.join(legs[:_SHOWN])}" if legs else ""


def unlike_limits(model: mujoco.MjModel, anatomy: Anatomy) -> str:
    """Leg joints whose ranges are not each other's mirror image, in words; empty if all are."""
    found: dict[str, float] = {}
    for left, right in zip(*(leg.joints for leg in anatomy.legs), strict=True):
        own, other = (anatomy.axes.T @ anatomy.data.xaxis[joint] for joint in (left, right))
        alike = (own * _MIRRORED) @ other > 0.0
        mirrored = model.jnt_range[right] if alike else -model.jnt_range[right][::-1]
        off = float(np.abs(model.jnt_range[left] - mirrored).max())
        if off > _UNLIKE and model.jnt_limited[[left, right]].all():
            ranges = (f"{model.joint(j).name} {_range(model.jnt_range[j])}" for j in (left, right))
            found[" but ".join(ranges)] = off
    more = f", and {len(found) - 1} more" if len(found) > 1 else ""
    return f"left and right limits differ: {max(found, key=lambda words: found[words])}{more}" if found else ""


def _range(bounds: np.typing.ArrayLike) -> str:
    low, high = np.asarray(bounds)
    return f"{low:.3g} to {high:.3g}"
