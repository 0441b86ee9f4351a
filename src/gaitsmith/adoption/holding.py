"""Whether the motors hold the robot's own weight while it stands: those that do not explain why it falls."""

from __future__ import annotations

from collections.abc import Iterable

import mujoco
import numpy as np

from gaitsmith.kinematics.posture import standing_posture
from gaitsmith.robots import Robot

_SPARE = 0.9  # of a motor's torque, at most to be spent on standing
_SHOWN = 4  # joints that are named


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
