"""Shapes of a robot and of the ground as entities of Foxglove's scenes, and as points for programs that draw none."""

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
_POINTS = 300  # on the surface of a shape
_FLOAT32 = 7  # Foxglove's number of a packed field's type


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
    shown = [shape for g in _seen(robot.model, body) for shape in _shapes(robot.model, g)]
    if not shown:
        thick, colour = _ROD * robot.card.gait.height, pb.message(5, pb.numbers(*_GREY))
        for end in _rods(robot, body):
            turn = np.zeros(4)
            mujoco.mju_quatZ2Vec(turn, end)
            w, x, y, z = turn.tolist()
            pose = _pose(pb.numbers(*0.5 * end), pb.numbers(x, y, z, w))
            size = pb.message(2, pb.numbers(thick, thick, float(np.linalg.norm(end))))
            shown.append(pb.message(10, pose, size, pb.number(3, 1.0), pb.number(4, 1.0), colour))
    return entity(frame, frame, *shown) if shown else None


def body_points(robot: Robot, body: int) -> Array:
    """(n, 3) points on the shapes that :func:`body_entity` draws, in the body's frame."""
    found = [_surface(robot.model, g) for g in _seen(robot.model, body)]
    if not any(map(len, found)):
        found = [np.linspace(0.0, 1.0, _POINTS // 10)[:, None] * end for end in _rods(robot, body)]
    return np.concatenate([np.zeros((0, 3)), *found])


def cloud(frame: str, points: Array) -> Form:
    """Points that are fixed to a frame, as a message of their own."""
    fields = (
        pb.message(5, pb.text(1, axis), pb.fixed(2, 4 * k), pb.count(3, _FLOAT32)) for k, axis in enumerate("xyz")
    )
    pose = pb.message(3, pb.message(1, pb.numbers(0.0, 0.0, 0.0)), pb.message(2, pb.numbers(0.0, 0.0, 0.0, 1.0)))
    packed = np.ascontiguousarray(points, "<f4").tobytes()
    return pb.joined(pb.stamp(1), pb.text(2, frame), pose, pb.fixed(4, 12), *fields, pb.raw(6, packed))


def _seen(model: mujoco.MjModel, body: int) -> list[int]:
    """The geometries of a body that are drawn."""
    own = np.flatnonzero(model.geom_bodyid == body)
    collides = (model.geom_contype[own] | model.geom_conaffinity[own]) != 0
    seen = own[~collides & (model.geom_group[own] < 3)]
    return (seen if len(seen) else own).tolist()


def _rods(robot: Robot, body: int) -> list[Array]:
    """From a body's origin to those of the bodies that hang on it."""
    model = robot.model
    ends = [model.body_pos[child] for child in np.flatnonzero(model.body_parentid == body) if child != body]
    return [end for end in ends if np.linalg.norm(end) > _ROD * robot.card.gait.height]


def _surface(model: mujoco.MjModel, g: int) -> Array:
    """(n, 3) points on a geometry, in its body's frame; the corners of a mesh, or some of them."""
    size, kind = model.geom_size[g], _SHAPES(model.geom_type[g])
    z = np.linspace(-1.0, 1.0, _POINTS)
    angle, ring = np.arange(_POINTS) * np.pi * (3.0 - np.sqrt(5.0)), np.sqrt(1.0 - z**2)
    ball = np.stack([ring * np.cos(angle), ring * np.sin(angle), z], 1)  # evenly over the sphere
    if kind == _SHAPES.mjGEOM_BOX:
        points = size * ball / np.abs(ball).max(axis=1, keepdims=True)
    elif kind in (_SHAPES.mjGEOM_SPHERE, _SHAPES.mjGEOM_ELLIPSOID):
        points = (size[:1] if kind == _SHAPES.mjGEOM_SPHERE else size) * ball
    elif kind == _SHAPES.mjGEOM_CYLINDER:
        points = size[[0, 0, 1]] * ball / np.maximum(ring, np.abs(z))[:, None]
    elif kind == _SHAPES.mjGEOM_CAPSULE:
        caps = size[0] * ball + size[1] * np.sign(z)[:, None] * (0.0, 0.0, 1.0)
        points = np.concatenate([caps, np.stack([size[0] * np.cos(angle), size[0] * np.sin(angle), size[1] * z], 1)])
    elif kind == _SHAPES.mjGEOM_MESH:
        mesh = int(model.geom_dataid[g])
        corners = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]].astype(float)
        points = corners[:: -(-len(corners) // _POINTS)]
    else:
        return np.zeros((0, 3))
    turned = np.zeros(9)
    mujoco.mju_quat2Mat(turned, model.geom_quat[g])
    return model.geom_pos[g] + points @ turned.reshape(3, 3).T  # type: ignore[no-any-return]


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
