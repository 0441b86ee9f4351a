"""The tree rooted at the torso, and the torso's frame with x forward and z up, whatever the model's author chose.

A tree of rigid bodies has no preferred root: the same joints, angles and inertias describe it from any of its bodies.
A joint between parent and child, seen from the child, turns the parent about the reversed axis by the same angle, so
joint names, ranges, springs and torques keep their meaning.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from gaitsmith.robots.engine import engine_errors

_MARK = "~rooted"
_JOINT_KEPT = (
    *("name", "type", "range", "limited", "margin", "ref", "stiffness", "springref", "springdamper", "damping"),
    *("armature", "frictionloss", "actfrcrange", "actfrclimited", "actgravcomp", "group", "userdata"),
    *("solref_limit", "solimp_limit", "solref_friction", "solimp_friction"),
)
_PAIR_KEPT = (
    *("geomname1", "geomname2", "name", "condim", "friction", "gap", "margin", "solimp", "solref"),
    *("solreffriction", "adhesion"),
)
_EXCLUDE_KEPT = ("bodyname1", "bodyname2", "name")


def root_at(spec: mujoco.MjSpec, torso: str, entry: str, notes: list[str]) -> None:
    """Make ``torso`` the body on the world, and hang the bodies that carried it from it.

    Joint angles, velocities and torques keep their names, signs and ranges; only their order changes.

    Args:
        spec: one tree on the world, every body named, a free joint or none at its root; changed in place.
        torso: name of the body that becomes the root.
        entry: what errors begin with.
        notes: appended to.

    Raises:
        BadInput: MuJoCo cannot compile the model.
    """
    path = [torso]
    while (parent := spec.body(path[-1]).parent.name) != "world":
        path.append(parent)
    if len(path) == 1:
        return
    with engine_errors(entry, []):
        before = spec.copy().compile()
    pairs = _taken(spec, list(spec.pairs), _PAIR_KEPT)
    excludes = _taken(spec, list(spec.excludes), _EXCLUDE_KEPT)
    for joint in list(spec.body(path[-1]).joints):
        spec.delete(joint)
    spec.copy_during_attach = True
    holder = spec.worldbody
    for below, name in zip((None, *path), path, strict=False):
        moved = holder.add_frame().attach_body(spec.body(name), "", _MARK)
        spec.delete(spec.body(name))
        moved.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
        if below is None:
            moved.pos, moved.quat = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])
        else:
            _reverse_joint(spec, before, holder, moved, before.body(below).id)
        holder = moved
    for kind in ("bodies", "joints", "geoms", "sites", "actuators"):
        for element in getattr(spec, kind):
            element.name = element.name.removesuffix(_MARK)
    for actuator in spec.actuators:
        actuator.target = actuator.target.removesuffix(_MARK)
    for add, kept in ((spec.add_pair, pairs), (spec.add_exclude, excludes)):
        for values in kept:
            add(**values)
    hang = f"{', '.join(path[1:])} now hang{'s' if len(path) == 2 else ''} from it, by the same joints"
    notes.append(f"rooted the tree at {torso}: {hang}")


def _reverse_joint(
    spec: mujoco.MjSpec, before: mujoco.MjModel, child: mujoco.MjsBody, parent: mujoco.MjsBody, body: int
) -> None:
    """Hang the former parent from its former child, which was ``body`` of the model before."""
    position, turn = before.body_pos[body], np.empty(9)
    mujoco.mju_quat2Mat(turn, before.body_quat[body])
    rotation = turn.reshape(3, 3)
    parent.pos, parent.quat = -rotation.T @ position, before.body_quat[body] * [1.0, -1.0, -1.0, -1.0]
    first, count = int(before.body_jntadr[body]), int(before.body_jntnum[body])
    own = list(zip(child.joints, range(first, first + count), strict=False))  # those hung here just now come after
    for joint, known in reversed(own):
        values = {name: _copied(getattr(joint, name)) for name in _JOINT_KEPT}
        spec.delete(joint)
        values["pos"] = rotation @ before.jnt_pos[known] + position
        values["axis"] = -rotation @ before.jnt_axis[known]
        parent.add_joint(**values)


def _taken(spec: mujoco.MjSpec, elements: list[Any], kept: tuple[str, ...]) -> list[dict[str, Any]]:
    """Values of some elements, which are taken out."""
    values = [{name: _copied(getattr(element, name)) for name in kept} for element in elements]
    for element in elements:
        spec.delete(element)
    return values


def _copied(value: Any) -> Any:
    return value.copy() if isinstance(value, np.ndarray) else value


def turn_frame(spec: mujoco.MjSpec, body: mujoco.MjsBody, quaternion: list[float], entry: str) -> None:
    """Turn a root body's frame and leave everything on it where it is.

    Args:
        spec: the model; changed in place.
        body: on the world, with a free joint or none.
        quaternion: w x y z, from the new frame to the body's present one.
        entry: what errors begin with.

    Raises:
        BadInput: MuJoCo cannot compile the model.
    """
    with engine_errors(entry, []):
        before = spec.copy().compile()
    known = before.body(body.name).id
    back = np.array(quaternion) * [1.0, -1.0, -1.0, -1.0]
    frame = body.add_frame(quat=back)
    for kind in ("geoms", "sites", "bodies", "frames"):
        for element in getattr(body, kind):
            if element.frame is None and element is not frame:
                element.set_frame(frame)
    if body.explicitinertial:
        position, turn = np.empty(3), np.empty(4)
        mujoco.mju_rotVecQuat(position, before.body_ipos[known], back)
        mujoco.mju_mulQuat(turn, back, before.body_iquat[known])
        body.ipos, body.iquat, body.inertia = position, turn, before.body_inertia[known]
        body.ialt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
        body.fullinertia = np.full(6, np.nan)
