"""Every body is seen: as it looks, as it collides, or as rods and its inertia."""

from __future__ import annotations

import dataclasses

import mujoco
import numpy as np
import pytest

from gaitsmith.live.geometry import LEFT, RIGHT, meshes_of
from gaitsmith.robots import load_robot


def with_model(robot, text):
    return dataclasses.replace(robot, model=mujoco.MjModel.from_xml_string(text))


@pytest.fixture(scope="module")
def robot():
    return load_robot("bhr_b2")


def test_shapes_that_collide_are_drawn_with_their_sizes_and_legs_by_colour(robot):
    meshes = {mesh.body: mesh for mesh in meshes_of(robot)}
    box = robot.model.geom_size[robot.model.body_geomadr[robot.torso_body]]
    np.testing.assert_allclose(np.ptp(meshes[robot.torso_body].vertices, axis=0), 2.0 * box)
    left, right = (meshes[leg.sole_body].colour for leg in robot.legs)
    assert np.abs(np.subtract(left, LEFT)).max() < np.abs(np.subtract(left, RIGHT)).max()
    assert np.abs(np.subtract(right, RIGHT)).max() < np.abs(np.subtract(right, LEFT)).max()


def without_shapes(robot):
    spec = robot.spec.copy()
    for geom in list(spec.geoms):
        spec.delete(geom)
    for body in spec.bodies[1:]:
        body.explicitinertial = True
    return dataclasses.replace(robot, model=spec.compile())


def test_a_model_without_shapes_is_drawn_as_rods_and_inertia(robot):
    bare = without_shapes(robot)
    meshes = {mesh.body: mesh for mesh in meshes_of(bare)}
    thigh = bare.model.body_parentid[bare.model.body_parentid[bare.legs[0].sole_body]]
    shank = bare.model.body_parentid[bare.legs[0].sole_body]
    reach = np.linalg.norm(bare.model.body_pos[shank])
    assert np.ptp(meshes[thigh].vertices, axis=0).max() == pytest.approx(reach, rel=0.3)
    assert {bare.torso_body, bare.legs[0].sole_body, bare.legs[1].sole_body} <= set(meshes)


def test_what_is_dressed_is_shown_dressed_and_corners_of_a_sole_as_a_slab(robot):
    spec = robot.spec.copy()
    body = spec.body(robot.model.body(robot.legs[0].sole_body).name)
    for geom in list(body.geoms):
        spec.delete(geom)
    for x in (-0.1, 0.1):
        for y in (-0.05, 0.05):
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.01, 0, 0], pos=[x, y, 0.0], mass=0.0)
    skin = spec.body(robot.model.body(robot.torso_body).name)
    skin.add_geom(type=mujoco.mjtGeom.mjGEOM_ELLIPSOID, size=[0.3, 0.2, 0.1], contype=0, conaffinity=0, mass=0.0)
    meshes = {m.body: m for m in meshes_of(dataclasses.replace(robot, model=spec.compile()))}
    np.testing.assert_allclose(np.ptp(meshes[robot.torso_body].vertices, axis=0), (0.6, 0.4, 0.2), rtol=0.02)
    slab = meshes[robot.legs[0].sole_body]
    np.testing.assert_allclose(np.ptp(slab.vertices, axis=0), (0.22, 0.12, 0.02), rtol=0.02)
    assert len(slab.vertices) < 4 * 642
