"""A loaded robot as it stands, for :mod:`gaitsmith.view.portrait`."""

from __future__ import annotations

import contextlib

import mujoco
import numpy as np

from gaitsmith.adoption.anatomy import ROLES
from gaitsmith.errors import BadInput
from gaitsmith.kinematics.posture import standing_posture
from gaitsmith.robots import Robot
from gaitsmith.view.portrait import DrawnJoint, Portrait


def portrait_of(robot: Robot) -> Portrait:
    """The robot in its standing posture; at zero joint angles if it cannot stand."""
    model, data = robot.model, mujoco.MjData(robot.model)
    data.qpos[:7] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
    mujoco.mj_kinematics(model, data)
    legs = {name for leg in robot.legs for name in leg.joints}
    roles = {name: ROLES[int(np.argmax(np.abs(data.xaxis[model.joint(name).id])))] for name in legs}
    with contextlib.suppress(BadInput):
        data.qpos[:] = standing_posture(robot, robot.card.gait.height, robot.card.gait.width)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    anchors = [int(model.body_jntadr[body]) for body in range(model.nbody)]
    place = [data.xanchor[j] if j > 0 else data.xpos[body] for body, j in enumerate(anchors)]
    bones = [(place[model.body_parentid[body]], place[body]) for body in range(2, model.nbody)]
    soles = []
    for leg in robot.legs:
        site = model.site(leg.sole_site).id
        points = np.column_stack([leg.sole.corners, np.zeros(len(leg.sole.corners))])
        soles.append(data.site_xpos[site] + points @ data.site_xmat[site].reshape(3, 3).T)
        bones.append((place[leg.sole_body], data.site_xpos[site].copy()))
    joints = [
        DrawnJoint(name, roles.get(name, ""), data.xanchor[j].copy(), data.xaxis[j].copy())
        for name in robot.joint_names
        for j in (model.joint(name).id,)
    ]
    title = f"{robot.card.name}: {robot.mass:.1f} kg, {len(robot.joint_names)} joints"
    return Portrait(title, np.array(bones), joints, soles, data.subtree_com[1].copy(), robot.legs[0].joints)
