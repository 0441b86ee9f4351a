"""The standing posture by Newton's method, so that planning need not load the controller's compiled kinematics."""

from __future__ import annotations

import mujoco
import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.robots import Robot

Array = npt.NDArray[np.float64]
_ROUNDS, _CLOSED = 30, 1e-12  # steps; m or rad
_BENT, _LONGEST = 0.5, 0.5  # rad, of the knees at first; of a joint in a step


def standing_joints(robot: Robot, height: float, width: float, com_ahead: float, slope: float = 0.0) -> Array:
    """(N,) joint angles in which the robot stands: torso upright, soles flat, the centre of mass above them.

    Args:
        robot: the robot, with legs of six joints.
        height: hip midpoint above the soles, m.
        width: half the distance between the soles' origins, m.
        com_ahead: of the centre of mass, forward from the soles' origins, along them, m.
        slope: by which the ground rises ahead, rad.

    Raises:
        BadInput: the legs do not reach.
    """
    found = _newton(robot, height, width, com_ahead * float(np.cos(slope)), slope)
    if found is not None:
        return found
    if slope:
        raise BadInput("slope", slope, "a slope on which the robot stands upright with flat soles")
    from gaitsmith.kinematics.posture import standing_posture  # it searches, and says what is in reach

    return standing_posture(robot, height, width, com_ahead)[7:]


def _newton(robot: Robot, height: float, width: float, com_ahead: float, slope: float) -> Array | None:
    """The posture within the joints' limits with bent knees; None where Newton's method does not find it."""
    model, data, hips = robot.model, mujoco.MjData(robot.model), robot.hip_midpoint
    legs = np.concatenate([leg.joint_indices for leg in robot.legs])
    low, high = robot.position_low, robot.position_high
    if len(legs) != 12 or not (np.isfinite(height) and np.isfinite(width)):
        return None
    data.qpos[:7] = (0.0, 0.0, height - hips[2], 1.0, 0.0, 0.0, 0.0)
    data.qpos[7:] = robot.home
    for leg in robot.legs:
        away = high[leg.knee] + low[leg.knee]
        data.qpos[7 + leg.knee] = np.clip(np.copysign(_BENT, away), low[leg.knee], high[leg.knee])
    ahead, gap = 0.0, np.zeros(13)
    cos, sin = float(np.cos(slope)), float(np.sin(slope))
    level = np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])  # turns a sole as it stands to a level one
    matrix, jacobian, com = np.zeros((13, 13)), np.zeros((6, model.nv)), np.zeros((3, model.nv))
    for _ in range(_ROUNDS):
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        for k, leg in enumerate(robot.legs):
            site, rows = data.site(leg.sole_site), slice(6 * k, 6 * k + 6)
            mujoco.mj_jacSite(model, data, jacobian[:3], jacobian[3:], site.id)
            turn = site.xmat.reshape(3, 3) @ level
            wanted = data.qpos[:3] + hips + np.array([ahead, leg.side * width, -height])
            gap[6 * k : 6 * k + 3] = site.xpos - wanted
            gap[6 * k + 3 : 6 * k + 6] = (turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1])
            gap[6 * k + 3 : 6 * k + 6] *= 0.5
            matrix[rows, :12], matrix[rows, 12] = jacobian[:, 6 + legs], (-1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        mujoco.mj_jacSubtreeCom(model, data, com, 1)
        gap[12] = data.subtree_com[1, 0] - com_ahead - hips[0] - ahead
        matrix[12, :12], matrix[12, 12] = com[0, 6 + legs], -1.0
        if np.abs(gap).max() < _CLOSED:
            angles = np.array(data.qpos[7:])
            bent = all(angles[leg.knee] * (high[leg.knee] + low[leg.knee]) > 0.0 for leg in robot.legs)
            return angles if bent and np.all(angles >= low) and np.all(angles <= high) else None
        try:
            step = np.linalg.solve(matrix, -gap)
        except np.linalg.LinAlgError:
            return None
        step *= min(1.0, _LONGEST / max(float(np.abs(step[:12]).max()), 1e-12))
        data.qpos[7 + legs] += step[:12]
        ahead += float(step[12])
    return None
