"""Where a model's legs are: chains, torso, roles of the joints, which way is forward; from geometry, not from names.

Everything is measured at the model's zero pose, z up (y, in models that are much longer that way). A *link* is a body
with everything rigidly attached below it, and is named by the index of its topmost body.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from gaitsmith.adoption.shapes import Shape, colliding, lowest
from gaitsmith.errors import BadInput

Array = NDArray[np.float64]

ROLES = ("roll", "pitch", "yaw")
WALKABLE = "two legs, each one open chain of 3 to 12 joints with pitch at hip, knee and ankle, and a flat or line sole"
_LOW = 0.08  # of the robot's height: what is nearer to the ground may be part of a foot
_ANKLE = 0.4  # of hip height: an ankle is below
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


class Unfit(BadInput):
    """A model that no card makes a biped; the sentence says what can walk."""

    def __init__(self, entry: str, found: str, remedy: str = "") -> None:
        super().__init__(entry, found, f"a robot this package can walk: {WALKABLE}", remedy)


def find_anatomy(
    model: mujoco.MjModel, entry: str, coupled: Mapping[str, str] | None = None, flags: Flags | None = None
) -> Anatomy:
    """Legs, roles, torso and forward direction.

    Args:
        model: compiled, its first joint free.
        entry: what errors begin with.
        coupled: joints that do not move independently, and why.
        flags: what the user says himself.

    Raises:
        BadInput: no two legs, or a flag that names no body.
    """
    data = _upright(model)
    tree = _Tree(model, data, entry)
    flags = flags or Flags()
    torso, branches = tree.legs(flags)
    paths = [tree.path(torso, foot) for foot in branches]
    _require_open(model, paths, coupled or {}, entry)
    up = np.array([0.0, 0.0, 1.0])
    hips = [np.mean([data.xanchor[j] for j in joints[:3]], axis=0) for joints in paths]
    across = hips[0] - hips[1]
    left = across - across @ up * up
    if np.linalg.norm(left) < 1e-6:
        raise Unfit(entry, "both hips at the same place", "name the feet with --feet LEFT RIGHT")
    rotation: Array = data.xmat[torso].reshape(3, 3)
    left = _snapped(left / np.linalg.norm(left), rotation)
    ahead = np.cross(left, up)
    legs = [tree.leg(joints, np.column_stack([ahead, left, up])) for joints in paths]
    if len(legs[0].joints) != len(legs[1].joints):
        counts = f"legs of {len(legs[0].joints)} and {len(legs[1].joints)} joints"
        raise Unfit(entry, counts, "name the feet with --feet LEFT RIGHT")
    if legs[0].roles != legs[1].roles:
        raise Unfit(entry, f"legs with joints {', '.join(legs[0].roles)} and {', '.join(legs[1].roles)}")
    sign, source = _forward(model, data, legs, ahead, rotation)
    axes = np.column_stack([sign * ahead, sign * left, up])
    ordered = legs if sign > 0.0 else legs[::-1]
    height = float(np.mean([h[2] for h in hips])) - min(lowest(leg.shapes, leg.ankle)[2] for leg in legs)
    named = tuple(_named(leg, name) for leg, name in zip(ordered, ("left", "right"), strict=True))
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


def _named(leg: LegFound, name: str) -> LegFound:
    return LegFound(**{**vars(leg), "name": name})


class _Tree:
    """Links and what they carry, at the zero pose."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, entry: str) -> None:
        self.model, self.data, self.entry = model, data, entry
        self.links = sorted({int(link) for link in model.body_weldid} - {0})
        self.parent = {link: int(model.body_weldid[model.body_parentid[link]]) for link in self.links}
        self.joints = {
            link: tuple(j for j in range(model.njnt) if model.jnt_bodyid[j] == link and model.jnt_type[j] in (2, 3))
            for link in self.links
        }
        self.bodies = {link: np.flatnonzero(model.body_weldid == link) for link in self.links}
        self.shapes = {link: colliding(model, data, self.bodies[link]) for link in self.links}

    def ancestors(self, link: int) -> list[int]:
        """From the root to the link itself."""
        found = [link]
        while self.parent[found[-1]] in self.parent:
            found.append(self.parent[found[-1]])
        return found[::-1]

    def path(self, torso: int, foot: int) -> tuple[int, ...]:
        """Joints between two links."""
        lineage = self.ancestors(foot)
        return tuple(j for link in lineage[lineage.index(self.link_of(torso)) + 1 :] for j in self.joints[link])

    def link_of(self, body: int) -> int:
        """The link that a body belongs to."""
        return int(self.model.body_weldid[body])

    def legs(self, flags: Flags) -> tuple[int, list[int]]:
        """The torso's body, and each leg's lowest link."""
        feet = [self.link_of(self._body("--feet", name)) for name in flags.feet] if flags.feet else self._low()
        lineages = [self.ancestors(foot) for foot in feet]
        common = 0
        while all(len(line) > common and line[common] == lineages[0][common] for line in lineages):
            common += 1
        branches: dict[int, list[list[int]]] = {}
        for line in lineages:
            branches.setdefault(line[min(common, len(line) - 1)], []).append(line)
        split = lineages[0][max(common - 1, 0)]
        if split in feet or len(branches) < 2:
            self._refuse_single(feet, lineages)
        chains = [self._chain(lines, common) for lines in branches.values()]
        short = [chain for chain in chains if len(self.path(split, chain)) < 3]
        if len(chains) != 2 or short:
            names = ", ".join(self._name(chain) for chain in chains[:6])
            raise Unfit(self.entry, f"{len(chains)} limbs on the ground ({names})")
        torso = self._body("--torso", flags.torso) if flags.torso else split
        if self.link_of(torso) != split:
            names = ", ".join(self._name(int(body)) for body in self.bodies[split])
            raise BadInput("--torso", flags.torso, f"a body of the link where the legs meet: {names}")
        return torso, chains

    def _low(self) -> list[int]:
        """Links that nearly touch the ground; by their origins if no shape does."""
        heights = {link: lowest(shapes)[2] for link, shapes in self.shapes.items() if shapes}
        places = self.data.xpos[self.links, 2]
        top = max(float(places.max()), max(heights.values(), default=-np.inf))
        origins = dict(zip(self.links, places.tolist(), strict=True))
        below = min(heights.values(), default=np.inf)
        if below > min(origins.values()) + 0.02 * (top - min(origins.values())):
            heights = origins  # the feet have no shape
            below = min(origins.values())
        if len(self.links) < 3 or top - below < 1e-6:
            raise Unfit(self.entry, f"{len(self.links)} moving bodies", "")
        return [link for link, height in heights.items() if height < below + _LOW * (top - below)]

    def _chain(self, lines: list[list[int]], common: int) -> int:
        """The last link of one limb: the deepest one, or where a foot divides into toes."""
        deepest = max(lines, key=len)
        for depth in range(common, len(deepest)):
            through = [line for line in lines if line[: depth + 1] == deepest[: min(depth + 1, len(line))]]
            if len(through) < len(lines):
                if len(self.path(deepest[common - 1], deepest[depth - 1])) < 3:
                    names = ", ".join(self._name(line[-1]) for line in lines[:4])
                    raise Unfit(self.entry, f"limbs that divide before the foot ({names})")
                return deepest[depth - 1]
        return deepest[-1]

    def _refuse_single(self, feet: list[int], lineages: list[list[int]]) -> None:
        low = min(feet, key=lambda link: lowest(self.shapes[link], self.data.xpos[link])[2])
        above = len(self.path(lineages[0][0], low)) if low in self.parent else 0
        found = "one leg" if above >= 3 else "no legs"
        raise Unfit(self.entry, f"{found}: {self._name(low)} is lowest, {above} joints below the root", "try --feet")

    def leg(self, path: tuple[int, ...], axes: Array) -> LegFound:
        """Roles of a path's joints; what comes after the ankle are toes."""
        model, data = self.model, self.data
        roles = [ROLES[int(np.argmax(np.abs(axes.T @ data.xaxis[j])))] for j in path]
        pitches = [place for place, role in enumerate(roles) if role == "pitch"]
        if len(pitches) < 3:
            path, roles = self._longer(path, axes)
            pitches = [place for place, role in enumerate(roles) if role == "pitch"]
        last = model.jnt_bodyid[path[-1]] if path else 0
        if len(pitches) < 3:
            raise Unfit(self.entry, f"a limb to {self._name(int(last))} without an ankle pitch joint")
        rolls = [place for place, role in enumerate(roles) if role == "roll" and place > pitches[1]]
        end = max(pitches[2], rolls[0] if rolls else 0) + 1
        joints, toes = path[:end], path[end:]
        foot = int(model.jnt_bodyid[joints[-1]])
        below = [link for link in self.links if foot in self.ancestors(link)]
        shapes = tuple(shape for link in below for shape in self.shapes[link])
        toes = tuple(j for link in below if link != foot for j in self.joints[link])
        ankle: Array = data.xanchor[joints[pitches[2]]].copy()
        ground = lowest(shapes, ankle)[2]
        hip = float(data.xanchor[joints[0]][2])
        if ankle[2] - ground > _ANKLE * (hip - ground):
            words = f"a third pitch joint half-way up the leg ({model.joint(joints[pitches[2]]).name})"
            raise Unfit(self.entry, words, "closed or bird-like legs cannot be walked")
        bodies = tuple(int(body) for link in below for body in self.bodies[link])
        return LegFound("", joints, tuple(roles[:end]), toes, foot, bodies, ankle, shapes)

    def _longer(self, path: tuple[int, ...], axes: Array) -> tuple[tuple[int, ...], list[str]]:
        """The path down to the lowest link below it: the shapes may end above the ankle."""
        link = int(self.model.jnt_bodyid[path[-1]]) if path else 0
        below = [other for other in self.links if link in self.ancestors(other)[:-1]]
        if below:
            lowest_link = min(below, key=lambda other: self.data.xpos[other][2])
            path = path + self.path(link, lowest_link)
        return path, [ROLES[int(np.argmax(np.abs(axes.T @ self.data.xaxis[j])))] for j in path]

    def _body(self, flag: str, name: str) -> int:
        body = mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_BODY, name)
        if body <= 0:
            raise BadInput(flag, name, f"a body: {', '.join(self._name(link) for link in self.links[:12])}")
        return int(body)

    def _name(self, body: int) -> str:
        return str(self.model.body(body).name)


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
