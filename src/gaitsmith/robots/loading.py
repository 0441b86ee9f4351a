"""Loading a robot by name or path: card, model, and the checks that need both."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import mujoco
import numpy as np
import numpy.typing as npt

from gaitsmith.documents import check_name
from gaitsmith.errors import BadInput
from gaitsmith.robots.assembly import assemble, set_limits, sole_frame
from gaitsmith.robots.assumptions import completed
from gaitsmith.robots.card import CardText, Described, LegCard
from gaitsmith.robots.card_file import CARD_NAME, OLD_NOTE, OLD_VERSION, read_card
from gaitsmith.robots.model_file import URDF_TOLERANCE, ModelFile, strip
from gaitsmith.robots.model_text import read_model
from gaitsmith.robots.overlaps import exclude_overlaps
from gaitsmith.robots.robot import Array, Indices, Leg, Robot
from gaitsmith.robots.safety import CardFolder
from gaitsmith.robots.shapes import compiled

SHIPPED = Path(__file__).parent
MASS_TOLERANCE = 1e-3  # relative; a card states its mass to a few digits
NUMBERS = (
    *("body_mass", "body_subtreemass", "body_inertia", "body_pos", "body_quat", "body_ipos", "body_iquat"),
    *("jnt_pos", "jnt_axis", "jnt_range", "dof_armature", "dof_damping", "dof_frictionloss", "dof_invweight0"),
    *("geom_pos", "geom_quat", "geom_size", "site_pos", "site_quat"),
)
UPRIGHT = 0.5  # cosine; a sole frame further than 60 degrees from the torso's axes is a mistake


def robot_names() -> tuple[str, ...]:
    """Names of the robots that come with the package."""
    return tuple(sorted(path.parent.name for path in SHIPPED.glob(f"*/{CARD_NAME}")))


def load_robot(name_or_path: str | Path) -> Robot:
    """A robot of the package by name, or any other by its card.

    Args:
        name_or_path: a name that :func:`robot_names` lists, a card (`.toml`), or a folder with a `card.toml`.

    Raises:
        BadInput: unknown name, a card or model that cannot be used; names the entry, its value and what is valid.
    """
    path = card_path(name_or_path)
    card, content = read_card(path)
    return build_robot(card, content, CardFolder(path.parent.resolve(), path.name))


def build_robot(card: CardText, content: bytes, folder: CardFolder) -> Robot:
    """A robot from a card that was read already.

    Args:
        card: the card.
        content: the card's bytes, for the content hash.
        folder: the card's folder; model, includes and meshes are read from it.

    Raises:
        BadInput: as :func:`load_robot`.
    """
    label, entry = folder.label, Path(card.model).name
    joints = [name for leg in card.legs for name in leg.joints]
    found = strip(read_model(folder, card.model), label, card.torso, card.weld, card.ignore, card.home, joints)
    notes = [OLD_NOTE] * (card.schema_version == OLD_VERSION) + list(found.notes)
    spec = assemble(found, card, label, notes)
    model, heard = compiled(spec, entry)
    _check_names(model, entry)
    _check_numbers(model, entry)
    _check_mass(model, card, found, label)
    feet = {model.body(int(model.site_bodyid[model.site(sole_frame(leg)).id])).name for leg in card.legs}
    arms = {name: angle for name, angle in found.home.items() if name not in joints}
    if exclude_overlaps(spec, model, arms, feet, notes):
        model, heard = compiled(spec, entry)
    names = tuple(model.joint(joint).name for joint in range(1, model.njnt))
    if model.actuator_trnid[:, 0].tolist() != list(range(1, model.njnt)):
        raise BadInput(f"{entry}: joints", list(names), "joints in the order of their bodies")
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    torso = model.body(card.torso).id
    legs = {leg.name: _leg(model, data, card, leg, names, torso, label) for leg in card.legs}
    left, right = legs["left"], legs["right"]
    if any(leg.sole is not legs[leg.name].sole for leg in card.legs):
        notes.append("a sole is walked on as a line along x: the ankle does not roll")
    notes += _passive(model)
    if not left.hip_anchor[1] > right.hip_anchor[1]:
        raise BadInput(f"{label}: legs", "left hip right of the right hip", "the left hip at the larger y")
    complete = completed(card, found, model, (left, right), label, notes)
    set_limits(spec, model, complete)
    limits = [complete.limits[name] for name in names]
    imu_position, imu_rotation = _imu(model, card)
    inside = {name for leg in card.legs for name in leg.joints}
    bounds = [
        (0.0 if name in inside else found.home[name], limit.position) for name, limit in zip(names, limits, strict=True)
    ]
    return Robot(
        card=complete,
        model_path=folder.folder / card.model,
        content_hash=folder.digest(content),
        mass=float(model.body_mass.sum()),
        model=model,
        notes=(*notes, *heard),
        joint_names=names,
        joint_dofs=_indices(model.jnt_dofadr[1:]),
        actuators=_indices(np.arange(len(names))),
        position_low=_fixed([limit.position[0] for limit in limits]),
        position_high=_fixed([limit.position[1] for limit in limits]),
        velocity_limit=_fixed([limit.velocity for limit in limits]),
        torque_limit=_fixed([limit.torque for limit in limits]),
        torso_body=torso,
        hip_midpoint=_fixed((left.hip_anchor + right.hip_anchor) / 2.0),
        imu_position=imu_position,
        imu_rotation=imu_rotation,
        legs=(left, right),
        home=_fixed([min(max(angle, low), high) for angle, (low, high) in bounds]),
        spec=spec,
        scene=found.scene,
    )


def card_path(name_or_path: str | Path) -> Path:
    """The card that a name or a path means, as :func:`load_robot` takes it.

    Raises:
        BadInput: there is none.
    """
    text = str(name_or_path)
    if isinstance(name_or_path, str) and text.replace("-", "_") in robot_names():
        return SHIPPED / text.replace("-", "_") / CARD_NAME
    path = Path(text)
    try:
        if path.suffix == ".toml" and path.is_file():
            return path
        if text and (path / CARD_NAME).is_file():
            return path / CARD_NAME
    except (OSError, ValueError):
        pass
    valid = f"{', '.join(robot_names())}, a card (.toml), or a folder with a {CARD_NAME}"
    raise BadInput("robot", text, valid)


def _check_names(model: mujoco.MjModel, entry: str) -> None:
    for kind, count in (("body", model.nbody), ("joint", model.njnt), ("site", model.nsite)):
        for name in (getattr(model, kind)(index).name for index in range(count)):
            try:
                check_name(name or kind)
            except ValueError as error:
                raise BadInput(f"{entry}: {kind}", name, f"a name of {error}") from None


def _check_numbers(model: mujoco.MjModel, entry: str) -> None:
    for name in NUMBERS:
        if not np.isfinite(getattr(model, name)).all():
            raise BadInput(f"{entry}: {name}", "not a finite number", "finite numbers")
    if model.body_mass.min() < 0.0 or not model.body_subtreemass[1] > 0.0:
        raise BadInput(f"{entry}: masses", model.body_mass.tolist(), "masses of 0 or more kg, the sum above 0")


def _check_mass(model: mujoco.MjModel, card: CardText, found: ModelFile, label: str) -> None:
    mass = float(model.body_mass.sum())
    if found.mass is not None and abs(mass - found.mass) > URDF_TOLERANCE * found.mass:
        valid = f"{found.mass:.9g} kg, the sum of its links"
        raise BadInput(f"{found.entry}: mass after import", mass, valid, "every moving link needs mass and inertia")
    if card.mass is not None and abs(mass - card.mass) > MASS_TOLERANCE * mass:
        raise BadInput(f"{label}: mass", card.mass, f"{mass:.6g} kg, as the model has, within 0.1 %")


def _leg(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    card: Described,
    leg: LegCard,
    names: tuple[str, ...],
    torso: int,
    label: str,
) -> Leg:
    """The leg's indices and frames; `data` holds the pose with zero joint angles."""
    field = f"{label}: legs[{card.legs.index(leg)}]"
    site = model.site(sole_frame(leg))
    body = int(model.site_bodyid[site.id])
    rotation: Array = data.xmat[torso].reshape(3, 3)
    anchors = [rotation.T @ (data.xanchor[model.joint(name).id] - data.xpos[torso]) for name in leg.joints]
    chain = [int(model.jnt_bodyid[model.joint(name).id]) for name in leg.joints] + [body]
    indices = [names.index(name) for name in leg.joints]
    for place, (upper, lower) in enumerate(pairwise(chain)):
        while lower > upper:
            lower = int(model.body_parentid[lower])
        if lower != upper or indices != sorted(indices):
            valid = "a chain from hip to ankle that carries the sole"
            raise BadInput(f"{field}.joints[{place}]", leg.joints[place], valid)
    above = int(model.body_parentid[chain[0]])
    meet = model.body(above).name
    while above not in (0, torso) and not model.body_jntnum[above]:
        above = int(model.body_parentid[above])
    if above != torso:
        valid = f"the body where the legs meet, {meet}"
        raise BadInput(f"{label}: torso", card.torso, valid, "what lies above it then follows its posture")
    sole_axes = rotation.T @ data.site_xmat[site.id].reshape(3, 3)
    if min(sole_axes[0, 0], sole_axes[2, 2]) < UPRIGHT:
        wrong = "sole_site" if leg.sole_site else "sole_rpy"
        valid = "a frame with x forward and z up at zero joint angles"
        raise BadInput(f"{field}.{wrong}", leg.sole_site or list(leg.sole_rpy), valid)
    below = leg.joints[leg.joints.index(leg.knee) + 1 :]
    rolls = any(abs(rotation.T @ data.xaxis[model.joint(name).id])[0] > UPRIGHT for name in below)
    return Leg(
        name=leg.name,
        side=1 if leg.name == "left" else -1,
        joints=leg.joints,
        joint_indices=_indices(indices),
        knee=names.index(leg.knee),
        ankle_pitch=names.index(leg.ankle_pitch),
        ankle_roll=-1 if leg.ankle_roll is None else names.index(leg.ankle_roll),
        sole_site=site.name,
        sole_body=body,
        sole_position=_fixed(model.site_pos[site.id]),
        sole_rotation=_rotation(model.site_quat[site.id]),
        sole=leg.sole if rolls else leg.sole.as_line(),
        hip_anchor=_fixed(anchors[0]),
    )


def _passive(model: mujoco.MjModel) -> list[str]:
    """What the joints do by themselves and the control cancels, in words."""
    table = {
        "springs": model.jnt_stiffness[1:],
        "damping": model.dof_damping[6:],
        "dry friction": model.dof_frictionloss[6:],
    }
    counts = {name: int(np.count_nonzero(values)) for name, values in table.items()}
    found = ", ".join(f"{name} of {count} joints" for name, count in counts.items() if count)
    notes = [f"the control cancels {found}, as the model has them"] if found else []
    if any(values.any() for values in (model.jnt_stiffnesspoly, model.dof_dampingpoly, model.jnt_springyield)):
        notes.append("the control takes springs and damping for linear, the model's are not")
    return notes


def _imu(model: mujoco.MjModel, card: Described) -> tuple[Array, Array]:
    if card.imu_site is None:
        return _fixed(np.zeros(3)), _fixed(np.eye(3))
    site = model.site(card.imu_site).id
    return _fixed(model.site_pos[site]), _rotation(model.site_quat[site])


def _rotation(quaternion: Array) -> Array:
    matrix = np.empty(9)
    mujoco.mju_quat2Mat(matrix, quaternion)
    return _fixed(matrix.reshape(3, 3))


def _fixed(values: npt.ArrayLike) -> Array:
    """A read-only copy."""
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array


def _indices(values: npt.ArrayLike) -> Indices:
    """A read-only copy."""
    array = np.array(values, dtype=np.int64)
    array.flags.writeable = False
    return array
