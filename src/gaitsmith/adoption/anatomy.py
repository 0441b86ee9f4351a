"""Where a model's legs are: chains, torso, roles of the joints, which way is forward; from geometry, not from names.

Everything is measured at the model's zero pose, z up (y, in models that are much longer that way). A *link* is a body
with everything rigidly attached below it, and is named by the index of its topmost body.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import combinations

import mujoco
import numpy as np
from numpy.typing import NDArray

from gaitsmith.adoption.links import Links
from gaitsmith.adoption.refusals import Unfit, unsure_of_feet
from gaitsmith.adoption.shapes import Shape, lowest
from gaitsmith.errors import BadInput

Array = NDArray[np.float64]

ROLES = ("roll", "pitch", "yaw")
_SIZES = (0.01, 20.0)  # m, of hip height
_ANKLE = 0.28  # of hip height: an ankle is below
_LONG = 2.0  # y extent over z extent of a model whose y is up
_SNAP = np.radians(5.0)  # a body's axis this near to forward or up is meant to be it
_CLEAR = 0.06  # of a sole's length: the ankle is that far behind the middle of a foot


@dataclass(frozen=True, eq=False)
class LegFound:
    """One leg as found: joints hip to ankle with their roles, toes that hang on it, the foot.

    Attributes:
        name: `left` or `right`.
        joints: ids.
        roles: of each joint: roll, pitch or yaw.
        toes: ids of joints below the ankle.
        foot: body that the last joint moves, and with the toes everything below.
        links: bodies of the foot.
        ankle: (3,) last joint's anchor in the world at the zero pose, m.
        shapes: colliding shapes of the foot, in the world.
    """

    name: str
    joints: tuple[int, ...]
    roles: tuple[str, ...]
    toes: tuple[int, ...]
    foot: int
    links: tuple[int, ...]
    ankle: Array
    shapes: tuple[Shape, ...]

    def joint(self, role: str, place: int) -> int:
        """The joint of a role, counted from the hip; -1 without one."""
        found = [joint for joint, own in zip(self.joints, self.roles, strict=True) if own == role]
        return found[place] if place < len(found) else -1

    @property
    def knee(self) -> int:
        """Id of the knee, the second pitch joint."""
        return self.joint("pitch", 1)

    @property
    def ankle_pitch(self) -> int:
        """Id of the ankle's pitch joint, the third."""
        return self.joint("pitch", 2)

    @property
    def ankle_roll(self) -> int:
        """Id of a roll joint below the knee; -1 without one."""
        pairs = zip(self.joints, self.roles, strict=True)
        return next((j for j, role in pairs if role == "roll" and j > self.knee), -1)


@dataclass(frozen=True, eq=False)
class Anatomy:
    """What was found.

    Attributes:
        data: the model at its zero pose, upright.
        torso: body where the legs meet.
        axes: (3, 3) forward, left and up as columns, in the world at the zero pose.
        torso_axes: (3, 3) the same in the torso body's frame.
        forward_from: what told forward from backward, in words.
        legs: left, right.
        hip_height: of the hips above the lowest point at the zero pose, m.
    """

    data: mujoco.MjData
    torso: int
    axes: Array
    torso_axes: Array
    forward_from: str
    legs: tuple[LegFound, LegFound]
    hip_height: float


@dataclass(frozen=True)
class Flags:
    """What the user says instead: bodies of the left and right foot in any order, and of the torso."""

    feet: tuple[str, ...] = ()
    torso: str = ""


def find_anatomy(
    model: mujoco.MjModel, entry: str, coupled: Mapping[str, str] | None = None, flags: Flags | None = None
) -> Anatomy:
    """Legs, roles, torso and forward direction.

    Args:
        model: compiled, its first joint free.
        entry: what errors begin with.
        coupled: joints that do not move independently, and why.

    Raises:
        Asked: several limbs could be the legs, or a flag names no body.
        BadInput: no two legs.
    """
    flags, data = flags or Flags(), _upright(model)
    tree = Links(model, data, entry)
    try:
        return _anatomy(tree, coupled or {}, flags)
    except Unfit as error:
        if flags.feet:
            raise
        pairs: dict[frozenset[int], tuple[str, str]] = {}
        for feet in combinations(tree.nearly_low(), 2):
            with contextlib.suppress(BadInput):
                found = _anatomy(tree, coupled or {}, Flags(feet, flags.torso))
                pairs.setdefault(frozenset(j for leg in found.legs for j in leg.joints), feet)
        pairs = {joints: feet for joints, feet in pairs.items() if not any(joints < longer for longer in pairs)}
        if not pairs:
            raise
        if len(pairs) == 1:
            return _anatomy(tree, coupled or {}, Flags(next(iter(pairs.values())), flags.torso))
        raise unsure_of_feet(entry, str(error.value), [name for pair in pairs.values() for name in pair]) from None


def _anatomy(tree: Links, coupled: Mapping[str, str], flags: Flags) -> Anatomy:
    """As :func:`find_anatomy`, of the feet that flags name, or of the lowest limbs."""
    model, data, entry = tree.model, tree.data, tree.entry
    torso, branches = tree.legs(flags.feet, flags.torso)
    paths = [tree.path(torso, foot) for foot in branches]
    _require_open(model, paths, coupled, entry)
    up = np.array([0.0, 0.0, 1.0])
    hips = [np.mean([data.xanchor[j] for j in joints[:3]], axis=0) for joints in paths]
    across = hips[0] - hips[1]
    left = across - across @ up * up
    if np.linalg.norm(left) < 1e-6:
        raise Unfit(entry, "both hips at the same place")
    rotation: Array = data.xmat[torso].reshape(3, 3)
    left = _snapped(left / np.linalg.norm(left), rotation)
    ahead = np.cross(left, up)
    legs = [_leg(tree, joints, np.column_stack([ahead, left, up])) for joints in paths]
    if len(legs[0].joints) != len(legs[1].joints):
        raise Unfit(entry, f"legs of {len(legs[0].joints)} and {len(legs[1].joints)} joints")
    if legs[0].roles != legs[1].roles:
        raise Unfit(entry, f"legs with joints {', '.join(legs[0].roles)} and {', '.join(legs[1].roles)}")
    sign, source = _forward(model, data, legs, ahead, rotation)
    axes = np.column_stack([sign * ahead, sign * left, up])
    ordered = legs if sign > 0.0 else legs[::-1]
    height = float(np.mean([h[2] for h in hips])) - min(lowest(leg.shapes, leg.ankle)[2] for leg in legs)
    if not _SIZES[0] <= height <= _SIZES[1]:
        valid = f"hips {_SIZES[0]:g} to {_SIZES[1]:g} m above the soles"
        raise BadInput(entry, f"{height:.3g} m", valid, "a model in other units than metres has to be scaled")
    named = tuple(replace(leg, name=name) for leg, name in zip(ordered, ("left", "right"), strict=True))
    return Anatomy(data, torso, axes, rotation.T @ axes, source, (named[0], named[1]), height)


def _upright(model: mujoco.MjModel) -> mujoco.MjData:
    """The model at its zero pose; z is up, or y if the model is much longer that way."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    _, y, z = np.ptp(data.xpos[1:], axis=0)
    if y > _LONG * z:
        turned = np.empty(4)
        mujoco.mju_mulQuat(turned, np.sqrt([0.5, 0.5, 0.0, 0.0]), data.qpos[3:7].copy())
        data.qpos[3:7] = turned
        mujoco.mj_kinematics(model, data)
    return data


def _leg(tree: Links, path: tuple[int, ...], axes: Array) -> LegFound:
    """Roles of a path's joints; what comes after the ankle are toes."""
    model, data = tree.model, tree.data
    path, roles = _longer(tree, path, axes)
    pitches = [place for place, role in enumerate(roles) if role == "pitch"]
    last = model.jnt_bodyid[path[-1]] if path else 0
    if len(pitches) < 3:
        raise Unfit(tree.entry, f"a limb to {tree.name(int(last))} without an ankle pitch joint")
    rolls = [place for place, role in enumerate(roles) if role == "roll" and place > pitches[1]]
    end = max(pitches[2], rolls[0] if rolls else 0) + 1
    joints, toes = path[:end], path[end:]
    foot = int(model.jnt_bodyid[joints[-1]])
    below = [link for link in tree.links if foot in tree.ancestors(link)]
    shapes = tuple(shape for link in below for shape in tree.shapes[link])
    toes = tuple(j for link in below if link != foot for j in tree.joints[link])
    ankle: Array = data.xanchor[joints[pitches[2]]].copy()
    ground = min(lowest(shapes, ankle)[2], *(data.xanchor[j][2] for j in toes), ankle[2])
    hip = float(data.xanchor[joints[0]][2])
    if ankle[2] - ground > _ANKLE * (hip - ground):
        words = f"a third pitch joint half-way up the leg ({model.joint(joints[pitches[2]]).name})"
        raise Unfit(tree.entry, words, "closed or bird-like legs cannot be walked")
    bodies = tuple(int(body) for link in below for body in tree.bodies[link])
    return LegFound("", joints, tuple(roles[:end]), toes, foot, bodies, ankle, shapes)


def _longer(tree: Links, path: tuple[int, ...], axes: Array) -> tuple[tuple[int, ...], list[str]]:
    """The path down to the lowest link below it: the shapes may end above the ankle."""
    link = int(tree.model.jnt_bodyid[path[-1]]) if path else 0
    below = [other for other in tree.links if link in tree.ancestors(other)[:-1]]
    if below:
        lowest_link = min(below, key=lambda other: tree.data.xpos[other][2])
        path = path + tree.path(link, lowest_link)
    return path, [ROLES[int(np.argmax(np.abs(axes.T @ tree.data.xaxis[j])))] for j in path]


def _require_open(model: mujoco.MjModel, paths: list[tuple[int, ...]], coupled: Mapping[str, str], entry: str) -> None:
    """No joint of a leg is coupled to another one, or closes a loop."""
    for name in (model.joint(j).name for path in paths for j in path):
        if name in coupled:
            raise Unfit(entry, f"a leg whose joint {name} is coupled ({coupled[name]}): closed loops and gears")


def _snapped(direction: Array, rotation: Array) -> Array:
    """The body's axis next to a horizontal direction, if one is very near; else the direction."""
    for axis in (*rotation.T, *(-rotation.T)):
        if axis @ direction > np.cos(_SNAP) and abs(axis[2]) < 1e-3:
            direction = np.array([axis[0], axis[1], 0.0]) / np.hypot(axis[0], axis[1])
            break
    return direction


def _forward(
    model: mujoco.MjModel, data: mujoco.MjData, legs: list[LegFound], ahead: Array, rotation: Array
) -> tuple[float, str]:
    """+1 if `ahead` is forward, -1 if it is backward, and what says so."""
    offsets, knees = [], []
    for leg in legs:
        if leg.shapes:
            along = np.array([shape.extent(ahead) for shape in leg.shapes])
            low, high = float(along[:, 0].min()), float(along[:, 1].max())
            offsets.append(((low + high) / 2.0 - leg.ankle @ ahead) / max(high - low, 1e-9))
        knee = leg.knee
        bend = model.jnt_range[knee].sum() if model.jnt_limited[knee] else 0.0
        shank = leg.ankle - data.xanchor[knee]
        knees.append(-np.sign(bend) * float(np.cross(data.xaxis[knee], shank) @ ahead))
    foot = float(np.mean(offsets)) if offsets else 0.0
    knee_cue = float(np.sign(np.sum(np.sign(knees)))) if np.all(np.abs(knees) > 0.0) else 0.0
    if abs(foot) > _CLEAR:
        return float(np.sign(foot)), "the feet, longer ahead of the ankle than behind"
    if knee_cue:
        return knee_cue, "the knees, which bend the shanks backward"
    return (1.0 if rotation[:, 0] @ ahead >= 0.0 else -1.0), "the x axis of the torso's body"
