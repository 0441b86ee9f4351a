"""The shapes of a model that matter: those that collide, or that give a body its mass."""

from __future__ import annotations

import math
from collections.abc import Iterator

import mujoco

from gaitsmith.errors import BadInput
from gaitsmith.robots.engine import engine_errors
from gaitsmith.robots.foreign_meshes import points_of
from gaitsmith.robots.model_text import ModelText
from gaitsmith.robots.safety import MESH_FORMATS

PAIRED = 1 << 20  # a bit that only the ground has, for shapes that collide with nothing else
ALWAYS, NEVER = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE, mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE


def compiled(spec: mujoco.MjSpec, entry: str) -> tuple[mujoco.MjModel, tuple[str, ...]]:
    """The compiled model, and MuJoCo's warnings.

    Raises:
        BadInput: MuJoCo refuses it; its message in one line.
    """
    heard: list[str] = []
    with engine_errors(entry, heard):
        model = spec.compile()
    return model, tuple(heard)


def tree(body: mujoco.MjsBody) -> Iterator[mujoco.MjsBody]:
    """A body and all that hang on it, depth first."""
    yield body
    for child in body.bodies:
        yield from tree(child)


def collide_only(spec: mujoco.MjSpec, notes: list[str]) -> None:
    """Only shapes that collide, or that give a body its mass; the ground is the plant's."""
    shapes = {geom.name: geom for geom in spec.geoms if geom.name}
    ground = {name for name, geom in shapes.items() if geom.parent.name == "world"}
    paired = set()
    for pair in list(spec.pairs):
        names = {pair.geomname1, pair.geomname2}
        if names & ground:
            for name in names - ground:
                if name in shapes and not shapes[name].conaffinity and not shapes[name].contype:
                    shapes[name].conaffinity = PAIRED
            spec.delete(pair)
        elif names <= set(shapes):
            paired |= names
    terrain = False
    for geom in list(spec.geoms):
        if geom.parent.name == "world":
            terrain = True
            spec.delete(geom)
        elif not geom.contype and not geom.conaffinity and geom.name not in paired:
            light = geom.mass == 0.0 or (math.isnan(geom.mass) and geom.density == 0.0)
            counts = spec.compiler.inertiafromgeom
            inferred = counts == ALWAYS or (counts != NEVER and not geom.parent.explicitinertial)
            if light or not inferred:
                spec.delete(geom)
    if terrain:
        notes.append("removed shapes fixed to the world: terrain belongs to the plant")
    drop_dangling(spec)


def drop_dangling(spec: mujoco.MjSpec) -> None:
    """Delete contact filters that name what is not there."""
    bodies, shapes = {body.name for body in spec.bodies}, {geom.name for geom in spec.geoms}
    for exclude in list(spec.excludes):
        if not {exclude.bodyname1, exclude.bodyname2} <= bodies:
            spec.delete(exclude)
    for pair in list(spec.pairs):
        if not {pair.geomname1, pair.geomname2} <= shapes:
            spec.delete(pair)


def read_meshes(spec: mujoco.MjSpec, source: ModelText, notes: list[str]) -> None:
    """Read the meshes that a shape still uses, and delete the others; one that cannot be read costs its shapes.

    Raises:
        BadInput: a mesh that a shape needs is not there, or lies outside.
    """
    used = {geom.meshname for geom in spec.geoms if geom.meshname}
    assets = {}
    for mesh in list(spec.meshes):
        if mesh.name not in used:
            spec.delete(mesh)
        elif mesh.file in source.meshes:
            file = source.meshes[mesh.file]
            kind, content = file.read()
            try:
                points = points_of(content, kind, file.entry)
                if points is None and kind not in MESH_FORMATS:
                    raise BadInput(file.entry, file.name, f"a mesh of kind {', '.join(MESH_FORMATS)}, .dae")
            except BadInput as error:
                _without(spec, mesh, f"{file.name}: {error.value}", notes)
                continue
            if source.urdf_mass is not None:
                mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL  # links say theirs; a shape may be flat
            if points is None:
                mesh.file = mesh.file.removesuffix(".obj") + kind
                assets[mesh.file] = content
            else:
                mesh.file, mesh.uservert = "", points.ravel()
    spec.assets = assets


def usable_meshes(spec: mujoco.MjSpec, entry: str, notes: list[str]) -> None:
    """Leave out the meshes that MuJoCo refuses, such as flat ones, and their shapes; a note names them."""
    if not spec.meshes:
        return
    try:
        compiled(spec.copy(), entry)
    except BadInput:
        for mesh in list(spec.meshes):
            alone = mujoco.MjSpec()
            alone.assets = {name: content for name, content in spec.assets.items() if name == mesh.file}
            kept = ("name", "file", "scale", "inertia", "maxhullvert", "uservert", "userface")
            alone.add_mesh(**{name: getattr(mesh, name) for name in kept})
            alone.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh.name)
            try:
                compiled(alone, entry)
            except BadInput as error:
                _without(spec, mesh, error.remedy, notes)


def _without(spec: mujoco.MjSpec, mesh: mujoco.MjsMesh, reason: str, notes: list[str]) -> None:
    shapes = [geom for geom in spec.geoms if geom.meshname == mesh.name]
    notes.append(f"left out the shape of {', '.join(sorted({geom.parent.name for geom in shapes}))}: {reason}")
    for element in (*shapes, mesh):
        spec.delete(element)
    drop_dangling(spec)
