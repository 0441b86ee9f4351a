"""Shapes of a robot and of the ground as entities of Foxglove's scenes."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np
import numpy.typing as npt

from gaitsmith.log import protobuf as pb
from gaitsmith.log.protobuf import Form
from gaitsmith.robots import Robot
from gaitsmith.simulation.terrain import Block

Array = npt.NDArray[np.float64]
Colour = tuple[float, float, float, float]
_GREY: Colour = (0.7, 0.72, 0.75, 1.0)
_EARTH: Colour = (0.8, 0.82, 0.86, 1.0)
_FINEST = 3000  # corners of a mesh; a finer one is drawn by its convex hull, or by the box around it
_ROD = 0.03  # hip heights: thickness of a body that has no shape
_SHAPES = mujoco.mjtGeom


def entity(name: str, frame: str, *primitives: Form) -> Form:
    """What is drawn together, fixed to a frame."""
    return pb.joined(pb.stamp(1), pb.text(2, frame), pb.text(3, name), pb.flag(5), *primitives)


def cube(place: Form, turn: Form, size: Form, colour: Colour) -> Form:
    """A box by its centre, quaternion x y z w, and edges."""
    return pb.message(8, _pose(place, turn), pb.message(2, size), pb.message(3, pb.numbers(*colour)))


def ground_entity(blocks: Sequence[Block], frame: str) -> Form | None:
    """The ground beside the plane; None without any."""
    if not blocks:
        return None
    shown = []
    for block in blocks:
        pitch, roll = 0.5 * block.pitch, 0.5 * block.roll
        turn = (np.sin(roll), np.sin(pitch), 0.0, np.cos(pitch) * np.cos(roll))  # one of both turns is none
        size = (2.0 * half for half in block.half_size)
        shown.append(cube(pb.numbers(*block.centre), pb.numbers(*turn), pb.numbers(*size), _EARTH))
    return entity("ground", frame, *shown)


def body_entity(robot: Robot, body: int, frame: str) -> Form | None:
    """A body's shapes, fixed to its frame; None without any.

    Those made to be seen, else those that collide, else rods to what hangs on it.
    """
    model = robot.model
    own = np.flatnonzero(model.geom_bodyid == body)
    collides = (model.geom_contype[own] | model.geom_conaffinity[own]) != 0
    seen = own[~collides & (model.geom_group[own] < 3)]
    shown = [shape for g in (seen if len(seen) else own) for shape in _shapes(model, int(g))]
    shown = shown or _rods(robot, body)
    return entity(frame, frame, *shown) if shown else None


def _rods(robot: Robot, body: int) -> list[Form]:
    """From a body's origin to those of the bodies that hang on it."""
    model, shown = robot.model, []
    thick = _ROD * robot.card.gait.height
    for child in np.flatnonzero(model.body_parentid == body):
        end = model.body_pos[child]
        length = float(np.linalg.norm(end))
        if child != body and length > thick:
            turn = np.zeros(4)
            mujoco.mju_quatZ2Vec(turn, end)
            w, x, y, z = turn.tolist()
            pose, size = _pose(pb.numbers(*0.5 * end), pb.numbers(x, y, z, w)), pb.numbers(thick, thick, length)
            colour = pb.message(5, pb.numbers(*_GREY))
            shown.append(pb.message(10, pose, pb.message(2, size), pb.number(3, 1.0), pb.number(4, 1.0), colour))
    return shown


def _shapes(model: mujoco.MjModel, g: int) -> list[Form]:
    """Primitives that look like a geometry."""
    size, kind, at = model.geom_size[g], _SHAPES(model.geom_type[g]), model.geom_pos[g]
    w, x, y, z = model.geom_quat[g].tolist()
    place, turn, colour = pb.numbers(*at), pb.numbers(x, y, z, w), pb.message(5, pb.numbers(*_GREY))
    if kind == _SHAPES.mjGEOM_BOX:
        return [cube(place, turn, pb.numbers(*2.0 * size), _GREY)]
    if kind == _SHAPES.mjGEOM_SPHERE:
        return [_ball(place, np.full(3, size[0]), turn)]
    if kind == _SHAPES.mjGEOM_ELLIPSOID:
        return [_ball(place, size, turn)]
    if kind in (_SHAPES.mjGEOM_CYLINDER, _SHAPES.mjGEOM_CAPSULE):
        edges = pb.message(2, pb.numbers(2.0 * size[0], 2.0 * size[0], 2.0 * size[1]))
        shown = [pb.message(10, _pose(place, turn), edges, pb.number(3, 1.0), pb.number(4, 1.0), colour)]
        if kind == _SHAPES.mjGEOM_CAPSULE:
            axis = np.zeros(3)
            mujoco.mju_rotVecQuat(axis, np.array([0.0, 0.0, 1.0]), model.geom_quat[g])
            for side in (-1.0, 1.0):
                shown.append(_ball(pb.numbers(*(at + side * size[1] * axis)), np.full(3, size[0]), turn))
        return shown
    if kind == _SHAPES.mjGEOM_MESH:
        return [_mesh(model, g, _pose(place, turn))]
    return []


def _ball(place: Form, radii: Array, turn: Form) -> Form:
    colour = pb.message(3, pb.numbers(*_GREY))
    return pb.message(9, _pose(place, turn), pb.message(2, pb.numbers(*2.0 * radii)), colour)


def _mesh(model: mujoco.MjModel, g: int, pose: Form) -> Form:
    """A mesh; a fine one as its convex hull where the engine has made one, else as the box around it."""
    mesh = int(model.geom_dataid[g])
    corners = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]].astype(float)
    faces = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]]
    if len(corners) > _FINEST and model.mesh_graphadr[mesh] >= 0:
        graph = model.mesh_graph[model.mesh_graphadr[mesh] :]
        count, sides = int(graph[0]), int(graph[1])
        at = 2 + 3 * count + 3 * sides  # behind: addresses, corners' numbers, neighbours
        faces = graph[at : at + 3 * sides].reshape(-1, 3)
        used, faces = np.unique(faces, return_inverse=True)
        corners, faces = corners[used], faces.reshape(-1, 3)
    elif len(corners) > _FINEST:
        low, high = corners.min(axis=0), corners.max(axis=0)
        w, x, y, z = model.geom_quat[g].tolist()
        middle = np.zeros(3)
        mujoco.mju_rotVecQuat(middle, 0.5 * (low + high), model.geom_quat[g])
        place = pb.numbers(*(model.geom_pos[g] + middle))
        return cube(place, pb.numbers(x, y, z, w), pb.numbers(*(high - low)), _GREY)
    points = [pb.message(2, pb.numbers(*corner)) for corner in corners.tolist()]
    packed = pb.raw(5, np.ascontiguousarray(faces, "<u4").tobytes())
    return pb.message(12, pb.joined(pose), *points, pb.message(3, pb.numbers(*_GREY)), packed)


def _pose(place: Form, turn: Form) -> Form:
    return pb.message(1, pb.message(1, place), pb.message(2, turn))
