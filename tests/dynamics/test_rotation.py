"""Rotations: the laws of the group, against MuJoCo's own conversions."""

import mujoco
import numpy as np
import pytest

from gaitsmith.dynamics.rotation import (
    axis_angle_entries,
    heading_to_world,
    product_entries,
    rotation_entries,
    rotation_matrix,
    turn_quaternion,
    world_to_heading,
)

ROUNDING = 1e-14
_RNG = np.random.default_rng(7)
RANDOM = [q / np.linalg.norm(q) for q in _RNG.normal(size=(20, 4))]
HALF_TURNS = [np.roll([1.0, 0.0, 0.0, 0.0], k) for k in range(4)]


@pytest.mark.parametrize("quaternion", RANDOM + HALF_TURNS)
def test_the_matrix_is_the_engines(quaternion: np.ndarray) -> None:
    engine = np.zeros(9)
    mujoco.mju_quat2Mat(engine, quaternion)
    entries = rotation_entries(*quaternion)
    np.testing.assert_allclose(entries, engine, atol=ROUNDING)
    np.testing.assert_allclose(rotation_matrix(3.0 * quaternion).ravel(), engine, atol=ROUNDING)


def test_a_quaternion_is_turned_in_body_axes():
    for before, axis, angle in zip(RANDOM, _RNG.normal(size=(20, 3)), _RNG.uniform(-3.0, 3.0, 20), strict=True):
        unit, after = axis / np.linalg.norm(axis), before.copy()
        turn_quaternion(after, *(angle * unit))
        wanted = product_entries(rotation_entries(*before), axis_angle_entries(*unit, angle))
        np.testing.assert_allclose(rotation_entries(*after), wanted, atol=ROUNDING)
        assert abs(np.linalg.norm(after) - 1.0) < ROUNDING
    still = RANDOM[0].copy()
    turn_quaternion(still, 0.0, 0.0, 0.0)
    np.testing.assert_allclose(still, RANDOM[0], atol=ROUNDING)


def test_axis_angle_is_the_quaternion_of_half_the_angle() -> None:
    for axis, angle in zip(_RNG.normal(size=(10, 3)), _RNG.uniform(-4.0, 4.0, 10), strict=True):
        unit = axis / np.linalg.norm(axis)
        quaternion = np.append(np.cos(angle / 2.0), np.sin(angle / 2.0) * unit)
        np.testing.assert_allclose(axis_angle_entries(*unit, angle), rotation_entries(*quaternion), atol=ROUNDING)


def test_heading_turns_counterclockwise_and_back() -> None:
    cos, sin = np.cos(0.4), np.sin(0.4)
    np.testing.assert_allclose(heading_to_world(cos, sin, 1.0, 0.0), (cos, sin), atol=ROUNDING)
    np.testing.assert_allclose(
        world_to_heading(cos, sin, *heading_to_world(cos, sin, 0.3, -0.8)), (0.3, -0.8), atol=ROUNDING
    )
