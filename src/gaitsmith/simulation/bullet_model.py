"""The robot as Bullet loads it: a URDF written from the compiled model, with its masses, joints and shapes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import quoteattr

import mujoco
import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput

Array = npt.NDArray[np.float64]
_HINGE = int(mujoco.mjtJoint.mjJNT_HINGE)
_LIGHT = 1e-6  # of the robot's mass: of links between two joints of one body, and least of any
_SMALL = 1e-9  # of mass times square of the robot's size, least moment of inertia
_ROUND = {
    int(mujoco.mjtGeom.mjGEOM_SPHERE): '<sphere radius="{0:.9g}"/>',
    int(mujoco.mjtGeom.mjGEOM_CAPSULE): '<capsule radius="{0:.9g}" length="{2:.9g}"/>',
    int(mujoco.mjtGeom.mjGEOM_CYLINDER): '<cylinder radius="{0:.9g}" length="{2:.9g}"/>',
}
_BOXES = (int(mujoco.mjtGeom.mjGEOM_BOX), int(mujoco.mjtGeom.mjGEOM_ELLIPSOID))


@dataclass(frozen=True)
class BulletModel:
    """A URDF file and how its links belong to the model.

    Attributes:
        link_names: (bodies,) name of the link with each body's mass and shapes; empty for the world.
        joint_names: of every actuated joint, in joint order.
    """

    path: Path
    link_names: tuple[str, ...]
    joint_names: tuple[str, ...]


def write_model(model: mujoco.MjModel, bodies: int, folder: Path) -> BulletModel:
    """Write the first bodies of a model as a URDF, with what meshes it needs beside it.

    Args:
        model: robot first, ground and props behind it.
        bodies: of the robot, the world included.

    Raises:
        BadInput: a joint or a shape that Bullet does not have.
    """
    least = _LIGHT * float(model.body_mass[1:bodies].sum())
    small = _SMALL * float(model.body_mass[1:bodies].sum()) * float(model.stat.extent) ** 2
    lines, links, joints = ['<robot name="robot">'], [""], list[str]()
    anchor = np.zeros((bodies, 3))
    for body in range(1, bodies):
        found = [int(model.body_jntadr[body]) + k for k in range(int(model.body_jntnum[body]))]
        hinges = [joint for joint in found if model.jnt_type[joint] == _HINGE]
        if body > 1 and len(hinges) != len(found):
            raise BadInput("engine", "bullet", "mujoco", f"joint {model.joint(found[0]).name} is no hinge")
        if hinges:
            anchor[body] = model.jnt_pos[hinges[-1]]
        names = [f"link_{body}_{k}" for k in range(max(len(hinges), 1))]
        links.append(names[-1])
        if body > 1:
            lines += _joints(model, body, hinges, names, links, anchor)
            joints += [f"joint_{joint}" for joint in hinges]
        between = _inertial(np.zeros(3), np.eye(3), least, np.full(3, small))
        lines += [f"<link name={quoteattr(name)}>{between}</link>" for name in names[:-1]]
        mass, centre = max(float(model.body_mass[body]), least), model.body_ipos[body] - anchor[body]
        moments, axes = np.maximum(model.body_inertia[body], small), _matrix(model.body_iquat[body])
        lines.append(f"<link name={quoteattr(names[-1])}>{_inertial(centre, axes, mass, moments)}")
        for geom in np.flatnonzero(model.geom_bodyid == body):
            if model.geom_contype[geom] or model.geom_conaffinity[geom]:
                lines.append(_collision(model, int(geom), anchor[body], folder))
        lines.append("</link>")
    path = folder / "robot.urdf"
    path.write_text("\n".join([*lines, "</robot>"]))
    return BulletModel(path, tuple(links), tuple(joints))


def _joints(
    model: mujoco.MjModel, body: int, hinges: list[int], names: list[str], links: list[str], anchor: Array
) -> list[str]:
    """From the parent's link through one link a hinge to the body's own."""
    parent = int(model.body_parentid[body])
    before, turn = links[parent], _matrix(model.body_quat[body])
    place = model.body_pos[body] - anchor[parent] + (turn @ model.jnt_pos[hinges[0]] if hinges else 0.0)
    if not hinges:
        return [_joint(f"fixed_{body}", "fixed", before, names[0], place, turn, "")]
    lines = []
    for k, (joint, name) in enumerate(zip(hinges, names, strict=True)):
        more = f'<axis xyz="{_words(model.jnt_axis[joint])}"/>'
        kind = "revolute" if model.jnt_limited[joint] else "continuous"
        if model.jnt_limited[joint]:
            low, high = model.jnt_range[joint] - model.qpos0[model.jnt_qposadr[joint]]
            more += f'<limit lower="{low:.9g}" upper="{high:.9g}" effort="1e9" velocity="1e9"/>'
        lines.append(_joint(f"joint_{joint}", kind, before, name, place, turn, more))
        before, turn = name, np.eye(3)
        place = model.jnt_pos[hinges[k + 1]] - model.jnt_pos[joint] if k + 1 < len(hinges) else np.zeros(3)
    return lines


def _joint(name: str, kind: str, parent: str, child: str, place: Array, turn: Array, more: str) -> str:
    ends = f"<parent link={quoteattr(parent)}/><child link={quoteattr(child)}/>"
    return f'<joint name="{name}" type="{kind}">{ends}{_origin(place, turn)}{more}</joint>'


def _inertial(centre: Array, axes: Array, mass: float, moments: Array) -> str:
    """Mass, centre, principal axes and moments."""
    values = " ".join(f'{key}="{value:.9g}"' for key, value in zip(("ixx", "iyy", "izz"), moments, strict=True))
    place = _origin(centre, axes)
    return f'<inertial>{place}<mass value="{mass:.9g}"/><inertia {values} ixy="0" ixz="0" iyz="0"/></inertial>'


def _collision(model: mujoco.MjModel, geom: int, anchor: Array, folder: Path) -> str:
    """One shape."""
    kind, size = int(model.geom_type[geom]), model.geom_size[geom]
    if kind in _ROUND:
        shape = _ROUND[kind].format(size[0], 0.0, 2.0 * size[1])
    elif kind in _BOXES:
        shape = f'<box size="{_words(2.0 * size)}"/>'
    elif kind == int(mujoco.mjtGeom.mjGEOM_MESH):
        shape = f'<mesh filename="{_mesh(model, int(model.geom_dataid[geom]), folder)}"/>'
    else:
        raise BadInput(
            "engine", "bullet", "mujoco", f"a shape of {model.body(model.geom_bodyid[geom]).name} is no solid"
        )
    place = _origin(model.geom_pos[geom] - anchor, _matrix(model.geom_quat[geom]))
    return f"<collision>{place}<geometry>{shape}</geometry></collision>"


def _mesh(model: mujoco.MjModel, mesh: int, folder: Path) -> str:
    """Name of a mesh's file, written once; Bullet takes its convex hull, as MuJoCo does."""
    path = folder / f"mesh_{mesh}.obj"
    if not path.exists():
        first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        lines = [f"v {_words(vertex)}" for vertex in model.mesh_vert[first : first + count]]
        first, count = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
        lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in model.mesh_face[first : first + count]]
        path.write_text("\n".join(lines) + "\n")
    return path.name


def _origin(place: Array, turn: Array) -> str:
    roll, yaw = np.arctan2(turn[2, 1], turn[2, 2]), np.arctan2(turn[1, 0], turn[0, 0])
    pitch = np.arctan2(-turn[2, 0], np.hypot(turn[2, 1], turn[2, 2]))
    return f'<origin xyz="{_words(place)}" rpy="{_words(np.array([roll, pitch, yaw]))}"/>'


def _words(values: Array) -> str:
    return " ".join(f"{value:.9g}" for value in values)


def _matrix(quaternion: Array) -> Array:
    found = np.zeros(9)
    mujoco.mju_quat2Mat(found, quaternion)
    return found.reshape(3, 3)
