"""The plant keeps the laws of mechanics, measures what is true, and never fails silently."""

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest
from tests.robots.test_urdf import as_urdf, build_urdf
from tests.simulation.standing import energy, floating, ground_height, hold, momentum, posture, robot

from gaitsmith.errors import BadInput
from gaitsmith.estimation.measurement import make_measurement
from gaitsmith.simulation.plant import Plant
from gaitsmith.simulation.terrain import Region, parse_terrain

GRAVITY = 9.81
MOMENTUM_TOLERANCE = 2e-3  # N·s: the legs move while a step of first order is taken
NEWTON_TOLERANCE = 0.5  # N of 390: the same, in one step
EXACT = 1e-12  # the same formula in another order


@pytest.fixture
def plant() -> Plant:
    made = Plant(robot())
    made.reset(posture())
    return made


@pytest.mark.parametrize("impulse", [(15.0, 0.0, 0.0), (0.0, -40.0, 0.0), (3.0, 4.0, -5.0)])
def test_a_push_changes_momentum_by_its_impulse(impulse):
    plant = floating()
    before, ticks = momentum(plant), 100
    plant.push(np.array(impulse) / (ticks * plant.control_step))
    for _ in range(ticks):
        plant.step(np.zeros(8))
    plant.push(np.zeros(3))
    weight = robot().mass * GRAVITY * ticks * plant.control_step
    gained = momentum(plant) - before + np.array([0.0, 0.0, weight])
    np.testing.assert_allclose(gained, impulse, atol=MOMENTUM_TOLERANCE)


def test_internal_torques_do_not_change_momentum():
    plant, rng = floating(), np.random.default_rng(0)
    before = momentum(plant)
    for _ in range(50):
        plant.step(rng.uniform(-30, 30, 8))
    fell = robot().mass * GRAVITY * 50 * plant.control_step
    np.testing.assert_allclose(momentum(plant) - before, [0, 0, -fell], atol=MOMENTUM_TOLERANCE)


def test_a_heavier_robot_weighs_more_on_the_ground():
    heavier = Plant(robot(), mass_factor=1.1)
    uneven = [Plant(robot(), mass_spread=0.05, seed=seed)._model.body_mass[1:] for seed in (0, 0, 1)]
    np.testing.assert_allclose(heavier._model.body_subtreemass[0], 1.1 * robot().mass)
    np.testing.assert_allclose(heavier._model.body_inertia, 1.1 * robot().model.body_inertia)
    ratio = uneven[0] / robot().model.body_mass[1:]
    assert 0.0 < np.max(np.abs(ratio - 1.0)) <= 0.05
    assert np.array_equal(uneven[0], uneven[1])
    assert not np.array_equal(uneven[0], uneven[2])


def test_flight_without_torque_keeps_energy_to_first_order():
    lost = []
    for physics_step in (5e-4, 1.25e-4):
        plant = floating(physics_step=physics_step)
        plant.v[6:] = 0.5
        plant.refresh()
        before = energy(plant)
        for _ in range(200):
            plant.step(np.zeros(8))
        lost.append(abs(energy(plant) - before))
    # A falling mass loses m g² t dt / 2 to a symplectic step of first order, and a quarter of the step is a quarter.
    assert lost[0] == pytest.approx(robot().mass * GRAVITY**2 * 0.2 * 5e-4 / 2, rel=0.05)
    assert lost[1] == pytest.approx(lost[0] / 4, rel=0.05)


def test_sole_forces_are_what_changes_the_momentum():
    plant = Plant(robot(), control_step=5e-4)
    plant.reset(posture())
    measured = make_measurement(8)
    hold(plant, 200)
    for _ in range(20):
        before = momentum(plant)[2]
        hold(plant, 1)
        plant.measure(measured)
        rate = (momentum(plant)[2] - before) / plant.control_step
        assert np.sum(measured.sole_force) == pytest.approx(rate + robot().mass * GRAVITY, abs=NEWTON_TOLERANCE)


def test_the_accelerometer_reads_specific_force():
    measured = make_measurement(8)
    plant = floating()
    plant.step(np.zeros(8))
    plant.measure(measured)
    np.testing.assert_allclose(measured.accelerometer, 0.0, atol=1e-6)
    plant.reset(posture())
    readings = []
    for _ in range(300):
        hold(plant, 1)
        plant.measure(measured)
        readings.append(measured.accelerometer.copy())
    assert np.mean(readings, axis=0)[2] == pytest.approx(GRAVITY, rel=0.02)


def test_reset_puts_the_soles_on_the_ground():
    plant = Plant(robot())
    q = posture()
    q[2] = 3.7
    plant.reset(q)
    assert min(plant.truth.sole[2], plant.truth.sole[5]) == pytest.approx(0.0, abs=EXACT)


@pytest.mark.parametrize("bad", [np.zeros(3), np.full(15, np.nan)])
def test_reset_refuses_what_is_no_configuration(plant, bad):
    with pytest.raises(BadInput, match="15 finite numbers"):
        plant.reset(bad)


def test_observed_values_agree_with_the_engine_on_a_tumbling_robot():
    plant, rng = floating(), np.random.default_rng(3)
    plant.v[:] = rng.uniform(-1, 1, 14)
    model, data = robot().model, mujoco.MjData(robot().model)
    smallest, far, start = np.inf, 0.0, plant.q[:2].copy()
    for _ in range(150):
        plant.step(rng.uniform(-20, 20, 8))
        data.qpos[:], data.qvel[:] = plant.q, plant.v
        mujoco.mj_forward(model, data)
        mujoco.mj_subtreeVel(model, data)
        seen = dict(zip(plant.truth_columns, plant.truth_buffer, strict=True))
        torso = data.xmat[robot().torso_body].reshape(3, 3)
        yaw = math.atan2(torso[1, 0], torso[0, 0])
        into_heading = np.array([[math.cos(yaw), math.sin(yaw)], [-math.sin(yaw), math.cos(yaw)]])
        soles = [
            data.xpos[leg.sole_body] + data.xmat[leg.sole_body].reshape(3, 3) @ leg.sole_position
            for leg in robot().legs
        ]
        apart = (into_heading @ (soles[0] - soles[1])[:2])[1]
        hip = data.xpos[robot().torso_body] + torso @ robot().hip_midpoint
        smallest, far = min(smallest, apart), max(far, float(np.hypot(*(plant.q[:2] - start))))
        velocity = into_heading @ data.subtree_linvel[0][:2]
        assert [seen["com_velocity_x"], seen["com_velocity_y"]] == pytest.approx(velocity, abs=EXACT)
        assert seen["com_velocity_z"] == pytest.approx(data.subtree_linvel[0][2], abs=EXACT)
        assert seen["foot_separation"] == pytest.approx(apart, abs=EXACT)
        assert seen["torso_yaw"] == pytest.approx(yaw, abs=EXACT)
        assert seen["hip_height_left"] == pytest.approx(hip[2] - soles[0][2], abs=EXACT)
    # At every physics step, so never more than what is seen once a tick, and near it.
    assert smallest - 2e-3 < plant.truth.least_separation[0] <= smallest
    assert far <= plant.truth.excursion[0] + EXACT


def test_torque_comes_after_its_delay():
    speeds = {}
    for delay in (0.0, 0.002):
        plant = floating(torque_delay=delay)
        plant.step(np.zeros(8))
        trace = []
        for _ in range(5):
            plant.step(np.full(8, 5.0))
            trace.append(float(plant.v[9]))
        speeds[delay] = trace
    at_rest = floating()
    at_rest.step(np.zeros(8))
    assert abs(speeds[0.002][1]) < 0.02 * abs(speeds[0.0][1])
    assert speeds[0.002][2] == pytest.approx(speeds[0.0][0], rel=0.05)


def test_the_plant_holds_torques_within_the_limits():
    limited, free = floating(), floating()
    limited.step(1e6 * np.ones(8))
    free.step(robot().torque_limit)
    np.testing.assert_array_equal(limited.v, free.v)


def test_coulomb_friction_holds_a_joint_against_less_torque():
    moved = {}
    for friction in (0.0, 3.0):
        plant = floating(joint_friction=friction)
        torque = np.zeros(8)
        torque[3] = 2.0
        start = plant.q[7:].copy()
        for _ in range(100):
            plant.step(torque)
        moved[friction] = abs(plant.q[10] - start[3])
    assert moved[3.0] < 0.01 * moved[0.0]


def test_friction_can_differ_from_joint_to_joint():
    names = robot().joint_names
    plant = floating(joint_friction=3.0, joint_frictions={names[7]: 0.0})
    torque = np.zeros(8)
    torque[[3, 7]] = 2.0
    start = plant.q[7:].copy()
    for _ in range(100):
        plant.step(torque)
    assert abs(plant.q[10] - start[3]) < 0.01 * abs(plant.q[14] - start[7])


def test_a_touch_between_the_legs_is_counted_once_however_long():
    plant = floating()
    roll = [robot().joint_names.index(f"{side}_hip_roll") for side in ("left", "right")]
    torque = np.zeros(8)
    torque[roll] = (-40.0, 40.0)
    for _ in range(150):
        plant.step(torque)
    assert 1 <= plant.truth.leg_contacts[0] < 20
    assert plant.truth.least_separation[0] < 0.1


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_state_that_is_not_finite_is_reported_and_writes_no_log_file(plant, bad, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    other = floating()
    plant.q[7] = bad
    for _ in range(3):
        plant.step(np.zeros(8))
        other.step(np.zeros(8))
    assert plant.truth.diverged[0] > 0
    assert plant.warnings
    assert other.warnings == []
    plant.reset(posture())
    assert plant.warnings == []
    assert list(Path(tmp_path).iterdir()) == []


def test_the_same_seed_gives_the_same_bits():
    ends = []
    for _ in range(2):
        plant = Plant(robot(), terrain=parse_terrain("boxes:0.05", 4), seed=4)
        plant.reset(posture())
        hold(plant, 200)
        ends.append((plant.q.copy(), plant.v.copy(), plant.truth_buffer.copy()))
    for first, second in zip(*ends, strict=True):
        np.testing.assert_array_equal(first, second)


def test_a_run_after_a_reset_equals_the_first_run(plant):
    hold(plant, 100)
    first = plant.q.copy()
    plant.reset(posture())
    hold(plant, 100)
    np.testing.assert_array_equal(plant.q, first)


@pytest.mark.parametrize("name", ["flat", "slope:8", "slope:-8", "boxes:0.06"])
def test_the_engine_s_ground_is_where_the_terrain_says(name):
    plant = Plant(robot(), terrain=parse_terrain(name, 2), region=Region((-3.0, 5.0), (-2.0, 2.0)))
    plant.reset(posture())
    plant.q[0] = -50.0
    plant.refresh()
    for x, y in ((0.0, 0.0), (0.3, 0.1), (1.61, 0.02), (3.05, -0.95), (4.5, 0.0)):
        assert ground_height(plant, x, y) == pytest.approx(parse_terrain(name, 2).height(x, y), abs=1e-9)


def test_an_unknown_body_is_named(plant):
    with pytest.raises(BadInput, match=r"push\.body: got 'head', expected one of torso"):
        plant.push((1, 0, 0), "head")


def test_the_control_step_must_be_whole_physics_steps():
    with pytest.raises(BadInput, match="control_step"):
        Plant(robot(), control_step=0.0007)


def test_what_is_fixed_to_the_sole_is_the_foot(tmp_path: Path) -> None:
    """The sole's own link has no shape; the link that it is fixed to carries the load, and is no other body."""
    root = as_urdf(robot())
    for link in root.iter("link"):
        for shape in link.iter("cylinder"):
            shape.tag, shape.attrib = "box", {"size": "0.2 0.06 0.129"}
    plant = Plant(build_urdf(root, tmp_path))
    plant.reset(posture())
    hold(plant, 150)
    assert plant.truth.body_contact[0] == 0.0
    assert plant.truth.force.sum() == pytest.approx(robot().mass * GRAVITY, rel=0.3)


def test_a_torso_s_centre_of_mass_moves_alone():
    plain, shifted = (Plant(robot(), torso_shift=shift)._model for shift in ((0.0, 0.0, 0.0), (0.03, -0.02, 0.01)))
    moved = np.zeros_like(plain.body_ipos)
    moved[robot().torso_body] = (0.03, -0.02, 0.01)
    np.testing.assert_allclose(shifted.body_ipos - plain.body_ipos, moved, atol=1e-12)
    np.testing.assert_array_equal(shifted.body_mass, plain.body_mass)


def test_stairs_down_begin_on_their_upper_end():
    terrain = parse_terrain("stairs:-0.05,0.2,0.12,3")
    plant = Plant(robot(), terrain=terrain)
    plant.reset(posture())
    found = plant.q[2]
    flat = Plant(robot())
    flat.reset(posture())
    assert found - flat.q[2] == pytest.approx(0.15, abs=1e-12)
