"""A stranger's model file without a card: stripped to one robot on a free joint, and what it says of its joints."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from gaitsmith.errors import BadInput
from gaitsmith.files import read_bounded
from gaitsmith.robots.engine import engine_errors
from gaitsmith.robots.model_limits import ModelLimits, model_limits
from gaitsmith.robots.model_text import EQUAL_LIMITS, Coupling, ModelText, read_model
from gaitsmith.robots.repair import repair_inertias
from gaitsmith.robots.safety import FILE_LIMIT, CardFolder
from gaitsmith.robots.shapes import collide_only, compiled, drop_dangling, read_meshes, tree, usable_meshes
from gaitsmith.robots.welding import turn

FREE = mujoco.mjtJoint.mjJNT_FREE
MOVING = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
WIDTH = {mujoco.mjtJoint.mjJNT_FREE: 7, mujoco.mjtJoint.mjJNT_BALL: 4}
STOP = 0.02  # share of a joint's range nearer than which it rests on its stop
URDF_TOLERANCE = 1e-9  # relative; the same numbers summed in another order
SHOWN = 8  # names of a list
LEVELS_ABOVE = 2  # of a bare model's folder, where its meshes may be


@dataclass(frozen=True)
class ModelFile:
    """A model stripped to what plant and control share: bodies, joints, shapes that collide, sites.

    Attributes:
        spec: the robot on a free joint, without actuators.
        root: the body with the free joint.
        scene: the other bodies of a scene; None without any.
        entry: what errors begin with, the model's file name.
        notes: what was changed with respect to the file, in words.
        limits: of every joint that moves, in the model's order.
        home: angle of every joint, welded ones included: given, else the first keyframe's, else 0 if that is off the
            stops, else mid-range.
        coupled: joints that do not move independently and are not welded, and why.
        mass: of a URDF's links, kg; None for MJCF.
        files: everything that was read, by path relative to the folder that they share; of :func:`open_model` only.
    """

    spec: mujoco.MjSpec
    root: str
    scene: mujoco.MjSpec | None
    entry: str
    notes: tuple[str, ...]
    limits: dict[str, ModelLimits]
    home: dict[str, float]
    coupled: dict[str, str]
    mass: float | None
    files: dict[str, bytes]

    @cached_property
    def model(self) -> mujoco.MjModel:
        """The robot alone, compiled.

        Raises:
            BadInput: MuJoCo refuses it.
        """
        return compiled(self.spec.copy(), self.entry)[0]


def open_model(
    path: str | Path,
    *,
    torso: str | None = None,
    weld: Sequence[str] = (),
    ignore: Sequence[str] = (),
    home: Mapping[str, float] | None = None,
    legs: Sequence[str] = (),
) -> ModelFile:
    """A model file without a card.

    Args:
        path: MJCF or URDF; meshes are read from at most two folders above it, or from its package.
        torso: a body of the robot; absent: the tree with the most joints is the robot.
        weld: joints to be fixed at home.
        ignore: bodies left out, with all that hangs on them.
        home: angles of some joints.
        legs: the legs' joints; given, coupled joints outside are welded and coupled ones inside refused.

    Raises:
        BadInput: the file cannot be used; names the entry, its value and what is valid.
    """
    path = Path(path)
    try:
        path = path.resolve(strict=True)
    except (OSError, RuntimeError, ValueError) as error:
        raise BadInput("model", str(path), "a model file, MJCF or URDF", str(error)) from None
    text = read_bounded(path, FILE_LIMIT) if path.is_file() else b""
    levels = [level for level in range(len(path.parts) - 1) if _is_package(path.parents[level].name, text)]
    top = path.parents[min(max([LEVELS_ABOVE, *levels]), len(path.parents) - 1)]
    folder = CardFolder(top, "")
    source = read_model(folder, path.relative_to(top).as_posix())
    found = strip(source, "", torso, weld, ignore, home or {}, legs or None)
    keys = [Path(key).parts for key in folder.contents]
    shared = 0
    while all(len(parts) > shared + 1 and parts[shared] == keys[0][shared] for parts in keys):
        shared += 1
    files = {"/".join(Path(key).parts[shared:]): content for key, content in folder.contents.items()}
    return replace(found, files=files)


def _is_package(name: str, text: bytes) -> bool:
    return bool(name) and f"://{name}/".encode() in text


def strip(
    source: ModelText,
    label: str,
    torso: str | None,
    weld: Sequence[str],
    ignore: Sequence[str],
    home: Mapping[str, float],
    legs: Collection[str] | None,
) -> ModelFile:
    """The model of a text as :func:`open_model` gives it; ``label`` is what errors about the arguments begin with."""
    prefix, entry = f"{label}: " if label else "", source.entry
    notes = [f"left out: {', '.join(source.left_out)}"] if source.left_out else []
    spec = _parsed(source, notes)
    keyframe = _keyframe(spec, source.keyframe)
    root = _root(spec, torso, prefix)
    mass = None if source.urdf_mass is None else float(sum(body.mass for body in spec.bodies))
    if (
        mass is not None
        and source.urdf_mass is not None
        and abs(mass - source.urdf_mass) > URDF_TOLERANCE * source.urdf_mass
    ):
        raise BadInput(f"{entry}: mass after import", mass, f"{source.urdf_mass:.9g} kg, the sum of its links")
    lost = _ignore(spec, root, ignore, prefix, notes)
    collide_only(spec, notes)
    if mass is not None:
        mass = mass - lost + repair_inertias(spec, notes)
    joints = {joint.name: joint for body in tree(root) for joint in body.joints if joint.type != FREE}
    if unnamed := [body.name for body in tree(root) for joint in body.joints if not joint.name and joint.type != FREE]:
        raise BadInput(f"{entry}: joint on {unnamed[0]}", "", "a name for every joint")
    limits = model_limits(spec, joints, source.drives, entry, notes)
    angles = _home(joints, limits, home, keyframe, prefix)
    if away := [name for name in angles if legs is not None and name not in (*legs, *home) and angles[name] != 0.0]:
        notes.append(f"held at the first keyframe, or off the stops: {_angles(away, angles)}")
    for name in weld:
        if name not in joints:
            raise BadInput(f"{prefix}weld", name, f"joints of the model: {listed(joints)}")
        if name in (legs or ()):
            raise BadInput(f"{prefix}weld", name, "joints outside the legs")
    coupled = _coupled(source.couplings, joints, weld)
    if legs is not None:
        coupled = {name: why for name, why in coupled.items() if name not in legs or why != EQUAL_LIMITS}
        for name in (name for name in coupled if name in legs):
            valid = "legs whose joints move independently"
            raise BadInput(f"{entry}: joint {name}", coupled[name], valid, "the control cannot represent couplings")
        if coupled:
            reasons = ", ".join(dict.fromkeys(coupled.values()))
            notes.append(f"welded at home, since coupled by {reasons}: {_angles(coupled, angles)}")
    if weld:
        notes.append(f"welded at home, as the card says: {_angles(weld, angles)}")
    for name, joint in joints.items():
        if name in weld or (legs is not None and name in coupled):
            turn(spec, joint, angles[name] - float(joint.ref) if joint.type in MOVING else 0.0)
            spec.delete(joint)
            del limits[name]
        elif joint.type not in MOVING:
            raise BadInput(f"{entry}: joint {name}", "ball", "hinge or slide", "cannot be represented; weld it")
        elif joint.ref != 0.0:
            turn(spec, joint, -float(joint.ref))
            joint.ref = 0.0
    if free := [joint for joint in root.joints if joint.type == FREE]:
        free[0].name = free[0].name or unused(spec.joints, "root")
    elif root.joints:
        raise BadInput(f"{entry}: body {root.name}", [j.name for j in root.joints], "a free joint or none")
    elif torso is None:
        root.add_freejoint(name=unused(spec.joints, "root"))
        notes.append(f"added a free joint to {root.name}")
    read_meshes(spec, source, notes)
    scene = _part(spec, root.name, entry, notes)
    usable_meshes(spec, entry, notes)
    return ModelFile(spec, root.name, scene, entry, tuple(notes), limits, angles, coupled, mass, {})


def _part(spec: mujoco.MjSpec, root: str, entry: str, notes: list[str]) -> mujoco.MjSpec | None:
    """Take the other bodies of the scene out; a specification with nothing but those, None without any."""
    others = [body for body in spec.worldbody.bodies if body.name != root]
    shown = [body.name for body in others if any(part.geoms for part in tree(body))]
    scene = spec.copy() if shown else None
    for body in others:
        spec.delete(body)
    drop_dangling(spec)
    if scene is not None:
        for name in {body.name for body in scene.worldbody.bodies} - set(shown):
            scene.delete(scene.body(name))
        drop_dangling(scene)
        try:
            compiled(scene.copy(), entry)
        except BadInput as error:  # what the robot does not need costs the robot nothing
            notes.append(f"left out, bodies of the scene that MuJoCo refuses, {listed(shown)}: {error.remedy}")
            return None
        notes.append(f"bodies of the scene are in the plant, unknown to the control: {listed(shown)}")
    return scene


def unused(elements: Sequence[Any], wanted: str) -> str:
    """The wanted name, with a number if an element has it."""
    names = {element.name for element in elements}
    return next(name for name in (wanted, *(f"{wanted}_{i}" for i in range(len(names) + 1))) if name not in names)


def listed(names: Iterable[str]) -> str:
    """The first names, in words, and how many follow."""
    shown = [name for name in names if name]
    more = len(shown) - SHOWN
    return ", ".join(shown if more <= 1 else [*shown[:SHOWN], f"{more} more"])


def _parsed(source: ModelText, notes: list[str]) -> mujoco.MjSpec:
    with engine_errors(source.entry, notes):
        spec = mujoco.MjSpec.from_string(source.text)
    spec.compiler.fusestatic = False
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    for body in spec.bodies:
        body.name = body.name or unused(spec.bodies, "body")
    return spec


def _keyframe(spec: mujoco.MjSpec, values: Sequence[float]) -> dict[str, float]:
    """A keyframe's angles by joint; nothing if it has another length than the model."""
    joints = [joint for body in tree(spec.worldbody) for joint in body.joints]
    widths = [WIDTH.get(joint.type, 1) for joint in joints]
    if sum(widths) != len(values) or not np.isfinite(values).all():
        return {}
    starts = np.cumsum([0, *widths])
    return {joint.name: float(values[at]) for joint, at in zip(joints, starts, strict=False) if joint.type in MOVING}


def _root(spec: mujoco.MjSpec, torso: str | None, prefix: str) -> mujoco.MjsBody:
    """The body on the world that carries the torso; without a torso the one with the most joints."""
    tops = list(spec.worldbody.bodies)
    if torso is None and tops:
        return max(tops, key=lambda top: sum(len(body.joints) for body in tree(top)))
    found = [top for top in tops if any(body.name == torso for body in tree(top))]
    if not found:
        names = (body.name for body in spec.bodies if body.name != "world")
        raise BadInput(f"{prefix}torso", torso, f"a body of the model: {listed(names)}")
    return found[0]


def _ignore(spec: mujoco.MjSpec, root: mujoco.MjsBody, ignore: Sequence[str], prefix: str, notes: list[str]) -> float:
    """Delete bodies; returns their mass as far as it is given, kg."""
    lost = 0.0
    for name in ignore:
        body = spec.body(name)
        if body is None or name in ("world", root.name):
            names = (body.name for body in tree(root) if body.name != root.name)
            raise BadInput(f"{prefix}ignore", name, f"bodies below the root: {listed(names)}")
        gone = list(tree(body))
        mass = float(sum(body.mass for body in gone if body.explicitinertial))
        more = "" if all(body.explicitinertial for body in gone) else ", and what its shapes weigh"
        notes.append(f"ignored, as the card says: {listed(b.name for b in gone)}; {mass:.4g} kg{more}")
        hung = {joint.name for part in gone for joint in part.joints}
        for actuator in list(spec.actuators):
            if actuator.target in hung:
                spec.delete(actuator)
        spec.delete(body)
        lost += mass
    return lost


def _home(
    joints: Mapping[str, Any],
    limits: Mapping[str, ModelLimits],
    given: Mapping[str, float],
    keyframe: Mapping[str, float],
    prefix: str,
) -> dict[str, float]:
    angles = {}
    for name in given:
        if name not in joints:
            raise BadInput(f"{prefix}home.{name}", given[name], f"joints of the model: {listed(joints)}")
    for name in joints:
        low, high = limits[name].position or (-math.inf, math.inf)
        if name in given:
            if not low <= given[name] <= high:
                raise BadInput(f"{prefix}home.{name}", given[name], f"{low:g} to {high:g}, the model's range")
            angles[name] = float(given[name])
        elif name in keyframe and low <= keyframe[name] <= high:
            angles[name] = keyframe[name]
        else:
            margin = STOP * (high - low) if math.isfinite(high - low) else 0.0
            angles[name] = 0.0 if low + margin <= 0.0 <= high - margin else 0.5 * (low + high)
    return angles


def _coupled(couplings: Sequence[Coupling], joints: Mapping[str, Any], weld: Sequence[str]) -> dict[str, str]:
    """Joints in a coupling of which nothing is welded or ignored already, and why."""
    found: dict[str, str] = {}
    for coupling in couplings:
        if all(name in joints and name not in weld for name in coupling.joints):
            found.update(dict.fromkeys(coupling.joints, coupling.reason))
    return {name: found[name] for name in joints if name in found}


def _angles(names: Iterable[str], angles: Mapping[str, float]) -> str:
    return listed(f"{name} {angles[name]:.3g}" for name in names)
