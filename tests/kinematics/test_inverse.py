"""Leg kinematics against MuJoCo and finite differences; steps reach what is in reach and never leave the limits."""

from pathlib import Path

import mujoco
import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitsmith.errors import BadInput
from gaitsmith.kinematics.inverse import (
    InverseGains,
    LegKinematics,
    leg_forward,
    leg_step,
    make_inverse_kinematics,
    make_leg_kinematics,
    orientation_error,
    solve_leg,
)
from gaitsmith.qp.quadratic_program import NOT_FINITE, OPTIMAL, make_quadratic_program
from gaitsmith.robots import Robot, load_robot

Array = npt.NDArray[np.float64]

STEP = 1e-6  # rad, central differences
DIFFERENCE = 1e-8  # their truncation and rounding together
ROUNDING = 1e-12  # m, a chain of six rotations
REACHED = 1e-8  # m and rad, solve_leg against the pose it was asked for
DT = 1e-3
GAINS = InverseGains(gain=10.0, step_weight=1e-6, change_weight=1e-6, pitch_weight=1.0)  # of the default preset

MODELS = Path(__file__).resolve().parent.parent / "models"
ROBOTS = {
    name: load_robot(name) for name in ("bhr_b2", str(MODELS / "six_joint_legs.toml"), str(MODELS / "with_arms.toml"))
}
CHAINS = [(robot, leg, make_leg_kinematics(robot, leg)) for robot in ROBOTS.values() for leg in robot.legs]
chains = st.sampled_from(range(len(CHAINS)))
seeds = st.integers(0, 2**32 - 1)


def pose(kin: LegKinematics, q: Array) -> tuple[Array, Array, Array]:
    """Sole position, rotation, and Jacobian in the torso frame."""
    position, rotation, jacobian = np.zeros(3), np.zeros((3, 3)), np.zeros((6, q.size))
    leg_forward(kin, q, position, rotation, jacobian)
    return position, rotation, jacobian


def within(kin: LegKinematics, seed: int, margin: float = 0.0) -> Array:
    """Random joint values inside the limits."""
    span = kin.upper - kin.lower
    return np.random.default_rng(seed).uniform(kin.lower + margin * span, kin.upper - margin * span)


def missed(kin: LegKinematics, q: Array, position: Array, rotation: Array) -> float:
    """Largest error of position and of the orientation that the leg controls."""
    actual, turned, _ = pose(kin, q)
    turn = np.zeros(3)
    orientation_error(kin, turned, rotation, turn)
    return float(max(np.max(np.abs(actual - position)), np.max(np.abs(turn))))


@given(chains, seeds)
def test_forward_kinematics_are_those_of_mujoco(chain: int, seed: int) -> None:
    """Position and rotation of the sole site relative to the torso, for a torso anywhere."""
    robot, leg, kin = CHAINS[chain]
    rng = np.random.default_rng(seed)
    data = mujoco.MjData(robot.model)
    data.qpos[:] = rng.normal(size=robot.model.nq)
    mujoco.mj_kinematics(robot.model, data)
    site = data.site(leg.sole_site)
    torso, origin = data.xmat[robot.torso_body].reshape(3, 3), data.xpos[robot.torso_body]
    position, rotation, _ = pose(kin, data.qpos[7 + leg.joint_indices])
    np.testing.assert_allclose(position, torso.T @ (site.xpos - origin), atol=ROUNDING)
    np.testing.assert_allclose(rotation, torso.T @ site.xmat.reshape(3, 3), atol=ROUNDING)


@given(chains, seeds)
def test_jacobian_by_finite_differences(chain: int, seed: int) -> None:
    """Columns are the velocity of the sole's origin and its angular velocity."""
    kin = CHAINS[chain][2]
    q = within(kin, seed)
    _, rotation, jacobian = pose(kin, q)
    for j in range(q.size):
        change = np.zeros(q.size)
        change[j] = STEP
        high, low = pose(kin, q + change), pose(kin, q - change)
        np.testing.assert_allclose((high[0] - low[0]) / (2.0 * STEP), jacobian[:3, j], atol=DIFFERENCE)
        spin = (high[1] - low[1]) @ rotation.T / (2.0 * STEP)
        np.testing.assert_allclose([spin[2, 1], spin[0, 2], spin[1, 0]], jacobian[3:, j], atol=DIFFERENCE)


def test_controlled_axes_follow_from_the_joints() -> None:
    """Four joints: pitch alone; six joints: all of the sole's orientation."""
    for robot, leg, kin in CHAINS:
        expected = [0, 1, 0] if len(leg.joints) == 4 else [1, 1, 1]
        assert kin.turning.tolist() == expected, (robot.card.name, leg.name)


@given(chains, seeds, st.booleans())
def test_reachable_poses_are_reached(chain: int, seed: int, from_middle: bool) -> None:
    """The pose of any joint values within the limits, from a start that knows nothing of them."""
    kin = CHAINS[chain][2]
    position, rotation, _ = pose(kin, within(kin, seed, 0.02))
    found = solve_leg(kin, position, rotation, 0.5 * (kin.lower + kin.upper) if from_middle else None)
    assert missed(kin, found, position, rotation) <= REACHED
    assert np.all((found >= kin.lower) & (found <= kin.upper))


@pytest.mark.parametrize("target", [[0.0, 0.1, -5.0], [2.0, 0.0, 0.0], [0.0, 0.1, 0.5], [np.nan, 0.0, 0.0]])
def test_unreachable_poses_are_refused(target: list[float]) -> None:
    """One line that says what was wrong."""
    for _, _, kin in CHAINS:
        with pytest.raises(BadInput, match="sole"):
            solve_leg(kin, np.array(target), np.eye(3))


def follow(kin: LegKinematics, q: Array, targets: list[tuple[Array, Array, Array]]) -> tuple[Array, float]:
    """Track position, velocity, rotation tick by tick; checks the limits at every tick."""
    ik, qp = make_inverse_kinematics(q.size), make_quadratic_program(q.size, 0)
    active = np.zeros(q.size, dtype=np.int64)
    reference, rate = q.copy(), np.zeros(q.size)
    worst = 0.0
    for position, velocity, rotation in targets:
        before = reference.copy()
        status = leg_step(kin, ik, qp, active, GAINS, reference, rate, position, velocity, rotation, DT)
        assert status == OPTIMAL
        assert np.all((reference >= kin.lower) & (reference <= kin.upper))
        assert np.all(np.abs(reference - before) <= kin.velocity_limit * DT * (1.0 + 1e-9) + 1e-15)
        np.testing.assert_allclose(rate * DT, reference - before, atol=1e-12)
        worst = max(worst, missed(kin, reference, position + velocity * DT, rotation))
    return reference, worst


@settings(max_examples=25)
@given(chains, seeds)
def test_a_moving_target_is_tracked(chain: int, seed: int) -> None:
    """A swing of the foot within reach: 0.1 s at up to 1 rad/s, tracked to a tenth of a millimetre."""
    kin = CHAINS[chain][2]
    start = within(kin, seed, 0.3)
    speed = np.random.default_rng(seed + 1).uniform(-1.0, 1.0, start.size)
    targets = []
    for k in range(100):
        position, _, jacobian = pose(kin, start + speed * k * DT)
        ahead = pose(kin, start + speed * (k + 1) * DT)[1]
        targets.append((position, jacobian[:3] @ speed, ahead))
    assert follow(kin, start, targets)[1] <= 1e-4


@settings(max_examples=25)
@given(chains, seeds)
def test_a_fixed_target_is_approached_with_the_gain(chain: int, seed: int) -> None:
    """The position error decays at k_IK: to e⁻⁵ within 0.5 s, from nearby."""
    kin = CHAINS[chain][2]
    start = within(kin, seed, 0.3)
    nearby = start + np.random.default_rng(seed + 1).uniform(-0.05, 0.05, start.size)
    position, rotation, _ = pose(kin, nearby)
    far = float(np.linalg.norm(pose(kin, start)[0] - position))
    reference, _ = follow(kin, start, [(position, np.zeros(3), rotation)] * 500)
    assert np.linalg.norm(pose(kin, reference)[0] - position) <= 0.02 * far + 1e-9


@settings(max_examples=25)
@given(chains, seeds)
def test_an_unreachable_target_leaves_the_leg_within_limits(chain: int, seed: int) -> None:
    """Far out of reach, from anywhere: every tick stays within position and velocity limits (checked on the way)."""
    kin = CHAINS[chain][2]
    rng = np.random.default_rng(seed)
    target = 3.0 * rng.normal(size=3)
    follow(kin, within(kin, seed), [(target, np.zeros(3), np.eye(3))] * 300)


def test_roll_error_does_not_disturb_the_pitch() -> None:
    """A leg without ankle roll keeps its sole level along its length, whatever roll is asked of it."""
    _, leg, kin = CHAINS[0]
    assert len(leg.joints) == 4
    q = np.array([0.15, -0.4, 0.8, -0.4])
    position, rotation, _ = pose(kin, q)
    turn = np.zeros(3)
    for roll in (-0.5, 0.0, 0.3):
        target = np.array([[1, 0, 0], [0, np.cos(roll), -np.sin(roll)], [0, np.sin(roll), np.cos(roll)]])
        orientation_error(kin, rotation, target, turn)
        np.testing.assert_allclose(turn, 0.0, atol=ROUNDING)
        np.testing.assert_allclose(solve_leg(kin, position, target, q), q, atol=REACHED)


def test_a_reference_outside_its_limits_is_moved_onto_them_and_nan_is_reported() -> None:
    """Neither makes the step fail silently: the first is repaired, the second leaves the reference alone."""
    kin = CHAINS[0][2]
    ik, qp, active = make_inverse_kinematics(4), make_quadratic_program(4, 0), np.zeros(4, dtype=np.int64)
    reference, rate = kin.upper + 1.0, np.full(4, 3.0)
    target, still = pose(kin, 0.5 * (kin.lower + kin.upper))[0], np.zeros(3)
    assert leg_step(kin, ik, qp, active, GAINS, reference, rate, target, still, np.eye(3), DT) == OPTIMAL
    assert np.all((reference >= kin.lower) & (reference <= kin.upper))
    before = reference.copy()
    broken = np.array([np.nan, 0.0, 0.0])
    assert leg_step(kin, ik, qp, active, GAINS, reference, rate, broken, still, np.eye(3), DT) == NOT_FINITE
    np.testing.assert_array_equal(reference, before)
    np.testing.assert_array_equal(rate, 0.0)


def test_a_chain_with_a_joint_that_is_not_the_legs_is_refused() -> None:
    """The message names the joints that lie between torso and sole."""
    robot: Robot = next(iter(ROBOTS.values()))
    leg = robot.legs[0]
    broken = type(leg)(**{**vars(leg), "joints": leg.joints[1:], "joint_indices": leg.joint_indices[1:]})
    with pytest.raises(BadInput, match=leg.joints[0]):
        make_leg_kinematics(robot, broken)
