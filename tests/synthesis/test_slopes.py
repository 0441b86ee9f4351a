"""Motions on inclined ground: MuJoCo's forces, upright postures; planned, stored, proved, and laid in the world."""

import math
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from gaitsmith.errors import BadInput
from gaitsmith.simulation.planned_run import completed
from gaitsmith.simulation.terrain import Region, parse_terrain
from gaitsmith.synthesis import write_gait
from gaitsmith.synthesis.files.gait_file import claims_hash, gait_document, gait_of
from gaitsmith.synthesis.files.motion_file import read_motion
from gaitsmith.synthesis.gaits.full_state import StateFinder
from gaitsmith.synthesis.gaits.walkable import walkable
from gaitsmith.synthesis.motions.biped import standing
from gaitsmith.synthesis.proof.rigorous import proof_of
from gaitsmith.synthesis.proof.verify import verify

EXAMPLE = Path(__file__).parents[2] / "examples" / "motions" / "ramp_bow.toml"
SLOPE = 0.1  # rad, the example's
SPARSE = 40  # instants a phase


@pytest.fixture(scope="module")
def sloped(suited_planner):
    return suited_planner(EXAMPLE)


@pytest.fixture(scope="module")
def gait(sloped):
    found = sloped.plan(*read_motion(EXAMPLE, sloped.biped))
    assert found.gait is not None, found.reason
    return found.gait


@pytest.mark.parametrize(("support", "side"), [("right", 1.0), ("left", -1.0)])
def test_torques_on_a_slope_are_those_of_mujoco_with_gravity_inclined(sloped, robot, support, side):
    layout, rng, finder = sloped.functions.layout, np.random.default_rng(2), StateFinder(robot, SLOPE)
    q, v, a = rng.uniform(-0.3, 0.3, (3, layout.joints))
    z, fall = np.zeros((layout.inputs, 1)), float(np.linalg.norm(robot.model.opt.gravity))
    z[: 3 * layout.joints, 0] = np.concatenate([q, v, a])
    pivot = np.array([0.0, 0.0, 0.0, -fall * math.sin(SLOPE), 0.0, -fall * math.cos(SLOPE)])
    o = sloped.functions.evaluate(z, pivot[:, None], side)[:, 0]
    if side < 0.0:
        q, v, a = (sloped.biped.mirrored(values) for values in (q, v, a))
    finder.find(support, (0.0, 0.0), q, v, a)
    torque = o[: layout.joints] if side > 0.0 else sloped.biped.mirrored(o[: layout.joints])
    wrench = np.zeros(12)
    own = slice(6, 12) if support == "right" else slice(0, 6)
    wrench[own] = o[layout.force : layout.force + 6] * ((1, side, 1, side, 1, side))
    assert np.abs(finder.residual(torque, wrench)).max() < 1e-9 * sloped.biped.weight


@pytest.mark.parametrize("slope", [0.15, -0.1])
def test_who_stands_on_a_slope_is_upright_above_the_middle_of_the_soles(planner, robot, slope):
    finder = StateFinder(robot, slope, level=True)
    q = standing(planner.biped, slope=slope)
    finder.find("right", (0.0, 0.0), q, 0.0 * q, 0.0 * q)
    np.testing.assert_allclose(finder.data.xmat[robot.torso_body].reshape(3, 3), np.eye(3), atol=1e-9)
    soles = [finder.foot(name, np.zeros(3)) for name in ("right", "left")]
    for _, _, _, rotation, _, _ in soles:
        assert math.atan2(-rotation[2, 0], rotation[0, 0]) == pytest.approx(-slope, abs=1e-9)
    sole = robot.legs[0].sole
    middle = 0.5 * (soles[0][0] + soles[1][0]) + rotation @ ((sole.toe - sole.heel) / 2.0, 0.0, 0.0)
    np.testing.assert_allclose(finder.centre_of_mass()[:2], middle[:2], atol=1e-9)


def test_the_level_world_is_the_grounds_turned(gait, robot):
    phase, time = gait.motion.phases[0], np.array([0.4])
    q, v, a = (values[:, 0] for values in gait.joints(0, time))
    finders = [StateFinder(robot, SLOPE), StateFinder(robot, SLOPE, level=True)]
    for finder in finders:
        finder.find(phase.support, phase.stand, q, v, a)
    own, world = finders
    np.testing.assert_allclose(world.ground @ own.centre_of_mass(), world.centre_of_mass(), atol=1e-12)
    assert (world.ground @ (1.0, 0.0, 0.0))[2] == pytest.approx(math.sin(SLOPE))
    np.testing.assert_allclose(world.ground @ own.model.opt.gravity, robot.model.opt.gravity, atol=1e-12)


def test_a_motion_on_a_slope_is_stored_verified_and_proved(gait, robot):
    read = gait_of(gait_document(gait))
    assert read.motion.slope == SLOPE
    assert verify(read, robot, SPARSE).ok
    assert not proof_of(read, robot)[1]


def test_another_slope_is_no_proof(gait, robot):
    forged = replace(gait, motion=replace(gait.motion, slope=0.9 * SLOPE))
    forged.certificate["claims"] = claims_hash(forged)
    assert any("residual" in problem for problem in verify(forged, robot, SPARSE).problems)
    assert any("dynamics residual" in problem for problem in proof_of(forged, robot)[1])


def test_soles_that_are_turned_are_refused_on_a_slope(gait):
    document = gait_document(gait)
    for phase in document["phases"]:
        phase["heading"] = phase["other_heading"] = 0.2
    with pytest.raises(BadInput, match="slope"):
        gait_of(document)


def test_a_plan_on_a_slope_is_laid_in_a_world_whose_z_is_up(gait, robot, tmp_path):
    plan = walkable([gait], robot)
    position = plan.start[0]
    np.testing.assert_allclose(position[3:7], (1.0, 0.0, 0.0, 0.0), atol=1e-9)  # the torso is upright
    data = mujoco.MjData(robot.model)
    data.qpos[:] = position
    mujoco.mj_kinematics(robot.model, data)
    ground = parse_terrain(f"ramp:{math.degrees(SLOPE)}")
    for leg in robot.legs:
        x, y, z = data.site(leg.sole_site).xpos
        assert z == pytest.approx(ground.height(x, y), abs=1e-9)
    write_gait(tmp_path / "gait.json", gait)
    kind, _, amount = completed({"gait": [tmp_path / "gait.json"]})["terrain"].partition(":")
    assert kind == "ramp"
    assert math.radians(float(amount)) == pytest.approx(SLOPE)
    with pytest.raises(BadInput, match="one slope"):
        walkable([gait, replace(gait, motion=replace(gait.motion, slope=0.0))], robot)


@pytest.mark.parametrize("degrees", [7.0, -4.0])
def test_a_ramp_contains_the_origin(degrees):
    terrain = parse_terrain(f"ramp:{degrees}")
    (block,) = terrain.blocks(Region())
    along = np.array([math.cos(block.pitch), 0.0, -math.sin(block.pitch)])
    normal = np.array([math.sin(block.pitch), 0.0, math.cos(block.pitch)])
    top = np.array(block.centre) + block.half_size[2] * normal
    for x in (-1.0, 0.0, 3.0):
        point = np.array([x, 0.3, terrain.height(x, 0.3)])
        assert (point - top) @ normal == pytest.approx(0.0, abs=1e-12)
        assert abs((point - top) @ along) < block.half_size[0]
