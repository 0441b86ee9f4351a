"""From a stripped model and its card to the specification that plant and control share."""

from __future__ import annotations

import math

import mujoco

from gaitsmith.errors import BadInput
from gaitsmith.robots.card import Described, LegCard, RobotCard
from gaitsmith.robots.engine import engine_errors
from gaitsmith.robots.model_file import FREE, ModelFile, listed, unused
from gaitsmith.robots.rooting import root_at, turn_frame
from gaitsmith.robots.shapes import tree

TERRAIN, LEFT, RIGHT = 1, 2, 4
ATTACHED = "scene~"  # before the names of a scene's bodies while they are attached


def assemble(found: ModelFile, card: Described, label: str, notes: list[str]) -> mujoco.MjSpec:
    """Free joint at the torso, sole sites, one motor per joint in joint order; :func:`set_limits` does the rest.

    Args:
        found: the stripped model; its specification is changed in place.
        card: its card.
        label: what errors about the card begin with.
        notes: receives what was changed, in words.

    Raises:
        BadInput: card and model contradict each other.
    """
    spec = found.spec
    _root(spec, card, found, notes)
    names = [joint.name for body in tree(spec.worldbody) for joint in body.joints if joint.type != FREE]
    for index, leg in enumerate(card.legs):
        for place, name in enumerate(leg.joints):
            if name not in names:
                raise BadInput(f"{label}: legs[{index}].joints[{place}]", name, f"a joint: {listed(names)}")
    for leg in card.legs:
        _sole_site(spec, leg, card, label)
    if card.imu_site is not None:
        site = spec.site(card.imu_site)
        if site is None or site.parent.name != card.torso:
            raise BadInput(f"{label}: imu_site", card.imu_site, f"a site on the body {card.torso}")
    if found.mass is not None:
        _collision_bits(spec, card)
        notes.append("added a free joint and contact filters: left leg, right leg and terrain touch each other")
    for name in names:
        motor = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.set_to_motor()
        motor.gear = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
        motor.forcelimited = motor.actlimited = mujoco.mjtLimited.mjLIMITED_FALSE
        motor.ctrllimited = spec.joint(name).limited = mujoco.mjtLimited.mjLIMITED_TRUE
        spec.joint(name).actfrclimited = mujoco.mjtLimited.mjLIMITED_FALSE
        motor.ctrlrange = [-1.0, 1.0]
        if not spec.joint(name).range[0] < spec.joint(name).range[1]:
            spec.joint(name).range = [-1.0, 1.0]
    return spec


def set_limits(spec: mujoco.MjSpec, model: mujoco.MjModel, card: RobotCard) -> None:
    """The limits of a complete card, in a specification and in the model compiled from it."""
    for name, limit in card.limits.items():
        joint = spec.joint(name)
        unit = math.pi / 180.0 if spec.compiler.degree and joint.type == mujoco.mjtJoint.mjJNT_HINGE else 1.0
        joint.range = [bound / unit for bound in limit.position]
        spec.actuator(name).ctrlrange = [-limit.torque, limit.torque]
        model.jnt_range[model.joint(name).id] = limit.position
        model.actuator_ctrlrange[model.actuator(name).id] = [-limit.torque, limit.torque]


def with_scene(spec: mujoco.MjSpec, scene: mujoco.MjSpec | None) -> mujoco.MjSpec:
    """A copy of a robot's specification, the other bodies of its scene after it."""
    spec = spec.copy()
    if scene is not None:
        other = scene.copy()
        with engine_errors("scene", []):
            for body in list(other.worldbody.bodies):
                spec.worldbody.add_frame().attach_body(body, ATTACHED, "")
        for kind in ("bodies", "joints", "geoms", "sites"):
            for element in getattr(spec, kind):
                element.name = element.name.removeprefix(ATTACHED)
    return spec


def _root(spec: mujoco.MjSpec, card: Described, found: ModelFile, notes: list[str]) -> None:
    """One tree, rooted at the torso, which moves freely."""
    root_at(spec, card.torso, found.entry, notes)
    torso = spec.body(card.torso)
    if card.torso_frame is not None:
        turn_frame(spec, torso, _quaternion(*card.torso_frame.rpy), found.entry)
        notes.append(f"turned the frame of {card.torso} as torso_frame says")
    if not [joint for joint in torso.joints if joint.type == FREE]:
        torso.add_freejoint(name=unused(spec.joints, "root"))
        notes.append("added a free joint to the torso")


def _sole_site(spec: mujoco.MjSpec, leg: LegCard, card: Described, label: str) -> None:
    field = f"{label}: legs[{card.legs.index(leg)}]"
    if leg.sole_site is not None:
        site = spec.site(leg.sole_site)
        if site is None:
            raise BadInput(f"{field}.sole_site", leg.sole_site, f"a site: {listed(s.name for s in spec.sites)}")
        return
    body = spec.body(leg.sole_body)
    if body is None:
        raise BadInput(f"{field}.sole_body", leg.sole_body, f"a body: {listed(b.name for b in spec.bodies)}")
    name = sole_frame(leg)
    if spec.site(name) is not None:
        raise BadInput(
            f"{field}.sole_body", leg.sole_body, f"no site named {name} in the model", "name it as sole_site"
        )
    body.add_site(name=name, pos=leg.sole_position, quat=_quaternion(*leg.sole_rpy), size=[0.005] * 3)


def sole_frame(leg: LegCard) -> str:
    """Name of the site that is a leg's sole frame in the loaded model."""
    return leg.sole_site or f"{leg.name}_sole"


def _collision_bits(spec: mujoco.MjSpec, card: Described) -> None:
    """Contact filters, which URDF lacks: the legs touch each other and the terrain, the rest only the terrain."""
    for geom in spec.geoms:
        geom.contype, geom.conaffinity = 0, TERRAIN
    for leg in card.legs:
        own, other = (LEFT, RIGHT) if leg.name == "left" else (RIGHT, LEFT)
        first = next(body for body in spec.bodies if any(j.name == leg.joints[0] for j in body.joints))
        for body in tree(first):
            for geom in body.geoms:
                geom.contype, geom.conaffinity = own, TERRAIN | other


def _quaternion(roll: float, pitch: float, yaw: float) -> list[float]:
    """Quaternion w x y z of Rz(yaw) Ry(pitch) Rx(roll)."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a / 2.0), math.sin(a / 2.0)) for a in (roll, pitch, yaw))
    return [
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ]
