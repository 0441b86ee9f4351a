"""Whether the soles that a card describes meet the ground: the feet's shapes on a plane, without a controller."""

from __future__ import annotations

import mujoco
import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.robots.engine import engine_errors
from gaitsmith.robots.robot import Leg, Robot

Array = npt.NDArray[np.float64]
DEEP = 0.02  # of the sole's length: a shape whose lowest point is farther from the sole does not carry it
REACH = 0.1  # of the sole's length: how far from the sole's edge it may end
INSET = 0.98  # of a corner's distance, where a ray looks for a shape above
GROUND = 0x7FFFFFFF  # collides with whatever collides with anything


def check_soles(robot: Robot, label: str = "card.toml") -> None:
    """Refuse soles that no shape of the foot carries from heel to toe and from side to side.

    The sole frame is laid on a plane; shapes count within 2 % of the sole's length above or below it.

    Raises:
        BadInput: naming the leg and what is missing.
    """
    model = _on_plane(robot, label)
    data = mujoco.MjData(model)
    for leg in robot.legs:
        field = f"{label}: legs[{next(k for k in (0, 1) if robot.card.legs[k].name == leg.name)}].sole"
        foot = np.flatnonzero(model.body_weldid[model.geom_bodyid] == model.body_weldid[leg.sole_body])
        where = f"the {leg.name} foot, {model.body(int(model.body_weldid[leg.sole_body])).name}"
        if not ((model.geom_contype[foot] != 0) | (model.geom_conaffinity[foot] != 0)).any():
            raise BadInput(field, "no shape that collides", f"shapes on {where}", "add collision shapes to the model")
        depth = DEEP * (leg.sole.heel + leg.sole.toe)
        if len(_touching(robot, model, data, leg, foot, depth)):
            valid = f"shapes of {where} that end within {1e3 * depth:.2g} mm of the sole"
            raise BadInput(field, "shapes below the sole frame", valid, "move the sole frame down")
        points = _touching(robot, model, data, leg, foot, -depth)
        if not len(points):
            valid = f"shapes of {where} that end within {1e3 * depth:.2g} mm of the sole"
            raise BadInput(field, "no shape reaches the sole", valid, "move the sole frame up, or add a shape")
        normals = leg.sole.edges[:, :2]
        short = leg.sole.edges[:, 2] - (points @ normals.T).max(axis=0)
        if short.max() > REACH * (leg.sole.heel + leg.sole.toe):
            side = _side(normals[int(short.argmax())])
            valid = f"a sole whose edges lie over shapes of {where}"
            raise BadInput(field, f"{1e3 * short.max():.0f} mm without a shape at the {side}", valid)


def below_soles(robot: Robot, q: Array, label: str = "card.toml") -> dict[str, float]:
    """Bodies that are no feet and reach into the ground in a posture, and how deep, m; the deepest first.

    Args:
        q: (nq,) posture whose soles are at height 0.
    """
    model = _on_plane(robot, label)
    data = mujoco.MjData(model)
    data.qpos[:] = q
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_collision(model, data)
    feet = [model.body_weldid[leg.sole_body] for leg in robot.legs]
    found: dict[str, float] = {}
    for contact in data.contact:
        bodies = model.geom_bodyid[contact.geom]
        body = int(bodies.max())
        if not bodies.min() and model.body_weldid[body] not in feet:
            name = model.body(body).name
            found[name] = max(found.get(name, 0.0), -contact.dist)
    deep = {name: depth for name, depth in found.items() if depth > 0.0}
    return dict(sorted(deep.items(), key=lambda entry: -entry[1]))


def _on_plane(robot: Robot, label: str) -> mujoco.MjModel:
    """The robot above a plane that collides with all of it."""
    spec = robot.spec.copy()
    plane = spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=(0.0, 0.0, 1.0))
    plane.contype, plane.conaffinity = GROUND, GROUND
    with engine_errors(label, []):
        return spec.compile()


def _side(normal: Array) -> str:
    if abs(normal[0]) >= abs(normal[1]):
        return "toe" if normal[0] > 0.0 else "heel"
    return "left edge" if normal[1] > 0.0 else "right edge"


def _touching(
    robot: Robot, model: mujoco.MjModel, data: mujoco.MjData, leg: Leg, foot: npt.NDArray[np.integer], height: float
) -> Array:
    """(k, 2) places in the sole frame where the foot's shapes are at the ground, the sole ``height`` above it."""
    mujoco.mj_resetData(model, data)
    data.qpos[7:] = robot.home
    mujoco.mj_kinematics(model, data)
    site, body = model.site(leg.sole_site).id, robot.torso_body
    frame = data.site_xmat[site].reshape(3, 3)
    turned = frame.T @ data.xmat[body].reshape(3, 3)
    data.qpos[:3] = [0.0, 0.0, height] + frame.T @ (data.xpos[body] - data.site_xpos[site])
    mujoco.mju_mat2Quat(data.qpos[3:7], turned.ravel())
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_collision(model, data)
    ground = model.ngeom - 1 if model.geom_bodyid[-1] == 0 else 0
    points = [
        contact.pos[:2]
        for contact in data.contact
        if ground in contact.geom and contact.geom.sum() - ground in foot and contact.dist <= 0.0
    ]
    if points and height < 0.0:
        corners = leg.sole.corners
        hit = np.zeros(1, dtype=np.int32)
        for corner in np.vstack([corners, (corners + np.roll(corners, -1, axis=0)) / 2.0]) * INSET:
            start = np.array([*corner, 4.0 * height])
            reached = mujoco.mj_ray(model, data, start, np.array([0.0, 0.0, 1.0]), None, 0, -1, hit, None)
            if reached >= 0.0 and hit[0] in foot and start[2] + reached <= 0.0:
                points.append(corner)
    return np.array(points).reshape(-1, 2)
