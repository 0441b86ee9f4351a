"""From a model's text and its card to the specification that plant and control share."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import mujoco

from gaitsmith.errors import BadInput
from gaitsmith.robots.engine import engine_errors
from gaitsmith.robots.rooting import root_at, turn_frame

if TYPE_CHECKING:
    from gaitsmith.robots.card import LegCard, RobotCard

TERRAIN, LEFT, RIGHT = 1, 2, 4
MOVING = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)


@dataclass(frozen=True)
class ModelText:
    """A model that needs no file.

    Attributes:
        text: MJCF or URDF.
        meshes: contents by the names that the text uses.
        entry: what errors begin with, the model's file name.
        urdf_mass: sum of the URDF's masses, kg; None for MJCF.
        left_out: kinds of element that the file has and the text has not.
    """

    text: str
    meshes: dict[str, bytes]
    entry: str
    urdf_mass: float | None
    left_out: tuple[str, ...] = ()


def assemble(source: ModelText, card: RobotCard, label: str) -> tuple[mujoco.MjSpec, tuple[str, ...]]:
    """A fresh specification: free joint, sole sites, one motor per joint in joint order, limits of the card.

    Args:
        source: the model.
        card: its card.
        label: what errors about the card begin with.

    Returns:
        The specification, and what was changed with respect to the file, in words.

    Raises:
        BadInput: the model holds something the control cannot represent, or card and model contradict each other.
    """
    notes = [f"left out, the plant has its own: {', '.join(source.left_out)}"] if source.left_out else []
    with engine_errors(source.entry, notes):
        spec = mujoco.MjSpec.from_string(source.text, assets=source.meshes)
    spec.compiler.fusestatic = False
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    for body in spec.bodies:
        body.name = body.name or _unused(spec.bodies, "body")
    _root(spec, card, label, source.entry, notes)
    names = _joints(spec, card, label, source.entry)
    for leg in card.legs:
        _sole_site(spec, leg, card, label, notes)
    if card.imu_site is not None:
        site = spec.site(card.imu_site)
        if site is None or site.parent.name != card.torso:
            raise BadInput(f"{label}: imu_site", card.imu_site, f"a site on the body {card.torso}")
    if source.urdf_mass is not None:
        _collision_bits(spec, card)
        notes.append("added a free joint and contact filters: left leg, right leg and terrain touch each other")
    _motors(spec, card, names, source.entry, notes)
    return spec, tuple(notes)


def compiled(spec: mujoco.MjSpec, entry: str) -> tuple[mujoco.MjModel, tuple[str, ...]]:
    """The compiled model, and MuJoCo's warnings.

    Raises:
        BadInput: MuJoCo refuses it; its message in one line.
    """
    heard: list[str] = []
    with engine_errors(entry, heard):
        model = spec.compile()
    return model, tuple(heard)


def _root(spec: mujoco.MjSpec, card: RobotCard, label: str, entry: str, notes: list[str]) -> None:
    """One tree, rooted at the torso, which moves freely."""
    for geom in list(spec.geoms):
        if geom.parent.name == "world":
            spec.delete(geom)
            notes.append("removed shapes fixed to the world: terrain belongs to the plant")
    roots = [body.name for body in spec.bodies if body.parent is not None and body.parent.name == "world"]
    torso = spec.body(card.torso)
    if torso is None:
        raise BadInput(f"{label}: torso", card.torso, f"a body of the model: {_listed(b.name for b in spec.bodies)}")
    if len(roots) != 1 or torso.name == "world":
        raise BadInput(f"{entry}: bodies on the world", roots, "one tree, that of the torso", "check torso in the card")
    root = spec.body(roots[0])
    if any(joint.type != mujoco.mjtJoint.mjJNT_FREE for joint in root.joints):
        raise BadInput(f"{entry}: body {root.name}", [j.name for j in root.joints], "a free joint or none")
    root_at(spec, card.torso, entry, notes)
    torso = spec.body(card.torso)
    if card.torso_frame is not None:
        turn_frame(spec, torso, _quaternion(*card.torso_frame.rpy), entry)
        notes.append(f"turned the frame of {card.torso} as torso_frame says")
    free = [joint.name for joint in torso.joints if joint.type == mujoco.mjtJoint.mjJNT_FREE]
    if not free:
        torso.add_freejoint(name=_unused(spec.joints, "root"))
        notes.append("added a free joint to the torso")


def _joints(spec: mujoco.MjSpec, card: RobotCard, label: str, entry: str) -> list[str]:
    """Names of the joints besides the free one, in the model's order; the card's limits are set."""
    names = []
    for body in _tree(spec.worldbody):
        for joint in body.joints:
            if joint.type == mujoco.mjtJoint.mjJNT_FREE:
                continue
            if joint.type not in MOVING:
                raise BadInput(f"{entry}: joint {joint.name}", "ball", "hinge or slide", "cannot be represented")
            if not joint.name:
                raise BadInput(f"{entry}: joint on {body.name}", "", "a name for every joint")
            if joint.ref != 0.0:
                raise BadInput(f"{entry}: joint {joint.name} ref", joint.ref, "0", "move the body's frame instead")
            if joint.name not in card.limits:
                raise BadInput(f"{label}: limits.{joint.name}", None, "limits for every joint of the model")
            _limit(spec, joint, card, label)
            names.append(joint.name)
    for name in card.limits:
        if name not in names:
            raise BadInput(f"{label}: limits.{name}", name, f"a joint of the model: {_listed(names)}")
    for index, leg in enumerate(card.legs):
        for place, name in enumerate(leg.joints):
            if name not in names:
                raise BadInput(f"{label}: legs[{index}].joints[{place}]", name, f"a joint: {_listed(names)}")
    return names


def _limit(spec: mujoco.MjSpec, joint: mujoco.MjsJoint, card: RobotCard, label: str) -> None:
    hinge = joint.type == mujoco.mjtJoint.mjJNT_HINGE
    unit = math.pi / 180.0 if spec.compiler.degree and hinge else 1.0
    low, high = (float(bound) * unit for bound in joint.range)
    wanted = card.limits[joint.name].position
    slack = 1e-6
    automatic = joint.limited == mujoco.mjtLimited.mjLIMITED_AUTO and spec.compiler.autolimits and low < high
    limited = automatic or joint.limited == mujoco.mjtLimited.mjLIMITED_TRUE
    if limited and (wanted[0] < low - slack or wanted[1] > high + slack):
        field = f"{label}: limits.{joint.name}.position"
        raise BadInput(field, list(wanted), f"a range within the model's, {low:.6g} to {high:.6g}")
    joint.range = [bound / unit for bound in wanted]
    joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE
    joint.actfrclimited = mujoco.mjtLimited.mjLIMITED_FALSE


def _sole_site(spec: mujoco.MjSpec, leg: LegCard, card: RobotCard, label: str, notes: list[str]) -> None:
    field = f"{label}: legs[{card.legs.index(leg)}]"
    if leg.sole_site is not None:
        site = spec.site(leg.sole_site)
        if site is None:
            raise BadInput(f"{field}.sole_site", leg.sole_site, f"a site: {_listed(s.name for s in spec.sites)}")
        return
    body = spec.body(leg.sole_body)
    if body is None:
        raise BadInput(f"{field}.sole_body", leg.sole_body, f"a body: {_listed(b.name for b in spec.bodies)}")
    name = sole_frame(leg)
    if spec.site(name) is not None:
        raise BadInput(
            f"{field}.sole_body", leg.sole_body, f"no site named {name} in the model", "name it as sole_site"
        )
    body.add_site(name=name, pos=leg.sole_position, quat=_quaternion(*leg.sole_rpy), size=[0.005] * 3)
    notes.append(f"added the site {name}")


def sole_frame(leg: LegCard) -> str:
    """Name of the site that is a leg's sole frame in the loaded model."""
    return leg.sole_site or f"{leg.name}_sole"


def _motors(spec: mujoco.MjSpec, card: RobotCard, names: list[str], entry: str, notes: list[str]) -> None:
    """Replace the actuators by one torque motor per joint, in joint order, limited as the card says."""
    plain, order = True, []
    for actuator in list(spec.actuators):
        if actuator.trntype != mujoco.mjtTrn.mjTRN_JOINT or actuator.target not in names:
            raise BadInput(f"{entry}: actuator {actuator.name}", actuator.target, "an actuator of a hinge or slide")
        if actuator.target in order:
            raise BadInput(f"{entry}: actuator {actuator.name}", actuator.target, "one actuator per joint")
        order.append(actuator.target)
        linear = actuator.gaintype == mujoco.mjtGain.mjGAIN_FIXED and actuator.biastype == mujoco.mjtBias.mjBIAS_NONE
        static = actuator.dyntype == mujoco.mjtDyn.mjDYN_NONE
        plain &= linear and static and actuator.gear[0] == 1.0 and actuator.gainprm[0] == 1.0
        spec.delete(actuator)
    if not plain:
        notes.append("replaced actuators by torque motors without gear, limited as the card says")
    if order != names:
        notes.append("added torque motors where they were missing, in the order of the joints")
    for name in names:
        motor = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.set_to_motor()
        motor.gear = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
        motor.forcelimited = motor.actlimited = mujoco.mjtLimited.mjLIMITED_FALSE
        motor.ctrllimited = mujoco.mjtLimited.mjLIMITED_TRUE
        motor.ctrlrange = [-card.limits[name].torque, card.limits[name].torque]


def _collision_bits(spec: mujoco.MjSpec, card: RobotCard) -> None:
    """Contact filters, which URDF lacks: the legs touch each other and the terrain, the rest only the terrain."""
    for geom in spec.geoms:
        geom.contype, geom.conaffinity = 0, TERRAIN
    for leg in card.legs:
        own, other = (LEFT, RIGHT) if leg.name == "left" else (RIGHT, LEFT)
        first = next(body for body in spec.bodies if any(j.name == leg.joints[0] for j in body.joints))
        for body in _tree(first):
            for geom in body.geoms:
                geom.contype, geom.conaffinity = own, TERRAIN | other


def _tree(body: mujoco.MjsBody) -> Iterator[mujoco.MjsBody]:
    yield body
    for child in body.bodies:
        yield from _tree(child)


def _unused(elements: list[Any], wanted: str) -> str:
    names = {element.name for element in elements}
    return next(name for name in (wanted, *(f"{wanted}_{i}" for i in range(len(names) + 1))) if name not in names)


def _quaternion(roll: float, pitch: float, yaw: float) -> list[float]:
    """Quaternion w x y z of Rz(yaw) Ry(pitch) Rx(roll)."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a / 2.0), math.sin(a / 2.0)) for a in (roll, pitch, yaw))
    return [
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ]


def _listed(names: Iterator[str] | list[str]) -> str:
    shown = [name for name in names if name]
    return ", ".join(shown[:12]) + (", ..." if len(shown) > 12 else "")
