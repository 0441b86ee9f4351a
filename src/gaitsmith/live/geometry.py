"""What a robot looks like: its geometries as triangles, one mesh a body and colour."""

from __future__ import annotations

from typing import NamedTuple

import mujoco
import numpy as np
import numpy.typing as npt
import trimesh

from gaitsmith.robots import Robot

Array = npt.NDArray[np.float64]
Colour = tuple[int, int, int]

LEFT: Colour = (60, 140, 225)
RIGHT: Colour = (240, 130, 60)
"""Colours of the legs wherever something belongs to one."""
_MIX = 0.8  # of a leg's colour in geometries that no model maker has coloured
_BARE: Colour = (205, 209, 215)
_ROD, _LIGHT = 0.04, 0.005  # radius of a rod in hip heights; share of the mass below which an end is not drawn
_SHAPES = mujoco.mjtGeom


class Mesh(NamedTuple):
    """Triangles of one body.

    Attributes:
        vertices: (n, 3) body frame, m.
        faces: (m, 3) numbers of vertices.
        colour: red, green, blue, 0 to 255.
        opacity: 1 for what cannot be seen through.
    """

    body: int
    vertices: Array
    faces: npt.NDArray[np.int64]
    colour: Colour
    opacity: float


def meshes_of(robot: Robot) -> list[Mesh]:
    """A robot's visual geometries; of a body without any, those that collide, tinted by leg; else bones and inertia."""
    model, parts = robot.model, dict[tuple[int, Colour, float], list[trimesh.Trimesh]]()
    collides = (model.geom_contype | model.geom_conaffinity) != 0
    dressed = set(model.geom_bodyid[~collides & (model.geom_group < 3)].tolist())
    tints = _tints(robot)
    for g in range(model.ngeom):
        body = int(model.geom_bodyid[g])
        if body == 0 or (body in dressed and collides[g]) or (body in dressed and model.geom_group[g] >= 3):
            continue
        shape = _shape(model, g)
        if shape is None:
            continue
        turn = np.eye(4)
        rotation = np.zeros(9)
        mujoco.mju_quat2Mat(rotation, model.geom_quat[g])
        turn[:3, :3], turn[:3, 3] = rotation.reshape(3, 3), model.geom_pos[g]
        shape.apply_transform(turn)
        colour, opacity = _colour(model, g)
        if not dressed and body in tints:
            mixed = (1.0 - _MIX) * np.array(colour) + _MIX * np.array(tints[body])
            colour = (int(mixed[0]), int(mixed[1]), int(mixed[2]))
        parts.setdefault((body, colour, opacity), []).append(shape)
    for body in set(range(1, model.nbody)) - {body for body, _, _ in parts}:
        if bones := _bones(robot, body):
            parts[body, tints.get(body, _BARE), 1.0] = bones
    found = []
    for (body, colour, opacity), shapes in parts.items():
        whole = trimesh.util.concatenate(shapes)
        if len(shapes) > 2 and _only_spheres(model, body):
            whole = whole.convex_hull  # the corners of a sole
        found.append(Mesh(body, np.asarray(whole.vertices), np.asarray(whole.faces), colour, opacity))
    return found


def _only_spheres(model: mujoco.MjModel, body: int) -> bool:
    """Whether a body has geometries, and all are spheres."""
    first, count = model.body_geomadr[body], model.body_geomnum[body]
    return count > 0 and all(model.geom_type[first : first + count] == _SHAPES.mjGEOM_SPHERE)


def _bones(robot: Robot, body: int) -> list[trimesh.Trimesh]:
    """What stands for a body without shapes: rods to the next joints; for torso and ends a box of the same inertia."""
    model, size = robot.model, float(robot.card.gait.height)
    children = [child for child in range(1, model.nbody) if model.body_parentid[child] == body]
    rods, thick = [], _ROD * size
    for child in children:
        end = model.body_pos[child]
        length = float(np.linalg.norm(end))
        if length > thick:
            rod = trimesh.creation.capsule(length, thick, count=(16, 16))
            rod.apply_transform(trimesh.geometry.align_vectors((0.0, 0.0, 1.0), end / length))
            rods.append(rod)
    if body != robot.torso_body and rods:
        return rods
    mass, moments = float(model.body_mass[body]), model.body_inertia[body]
    if mass < _LIGHT * robot.mass:
        return rods
    # A uniform box of half sizes a, b, c has the moments of inertia m (b² + c²) / 3, and so on.
    half = np.sqrt(np.maximum(1.5 * (moments.sum() - 2.0 * moments) / mass, thick**2))
    box, turn, rotation = trimesh.creation.box(2.0 * half), np.eye(4), np.zeros(9)
    mujoco.mju_quat2Mat(rotation, model.body_iquat[body])
    turn[:3, :3], turn[:3, 3] = rotation.reshape(3, 3), model.body_ipos[body]
    box.apply_transform(turn)
    return [*rods, box]


def _tints(robot: Robot) -> dict[int, Colour]:
    """Colour of every body of a leg."""
    model, found = robot.model, dict[int, Colour]()
    for leg, colour in zip(robot.legs, (LEFT, RIGHT), strict=True):
        root = int(model.jnt_bodyid[leg.joint_indices[0] + 1])
        for body in range(model.nbody):
            above = body
            while above > 0 and above != root:
                above = int(model.body_parentid[above])
            if above == root:
                found[body] = colour
    return found


def _colour(model: mujoco.MjModel, g: int) -> tuple[Colour, float]:
    """Colour and opacity of a geometry, its material's if it has one."""
    material = int(model.geom_matid[g])
    r, g_, b, opacity = model.mat_rgba[material] if material >= 0 else model.geom_rgba[g]
    return (int(255 * r), int(255 * g_), int(255 * b)), float(opacity)


def _shape(model: mujoco.MjModel, g: int) -> trimesh.Trimesh | None:
    """Triangles of a geometry in its own frame; None for one that cannot be seen."""
    kind, size = model.geom_type[g], model.geom_size[g]
    if kind == _SHAPES.mjGEOM_MESH:
        mesh = int(model.geom_dataid[g])
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        face, faces = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
        vertices, triangles = model.mesh_vert[first : first + count], model.mesh_face[face : face + faces]
        return trimesh.Trimesh(vertices.copy(), triangles.copy(), process=False)
    if kind == _SHAPES.mjGEOM_BOX:
        return trimesh.creation.box(2.0 * size)
    if kind == _SHAPES.mjGEOM_SPHERE:
        return trimesh.creation.icosphere(3, size[0])
    if kind == _SHAPES.mjGEOM_ELLIPSOID:
        ball = trimesh.creation.icosphere(3)
        ball.apply_scale(size)
        return ball
    if kind == _SHAPES.mjGEOM_CAPSULE:
        return trimesh.creation.capsule(2.0 * size[1], size[0], count=(24, 24))
    if kind == _SHAPES.mjGEOM_CYLINDER:
        return trimesh.creation.cylinder(size[0], 2.0 * size[1], sections=32)
    return None
