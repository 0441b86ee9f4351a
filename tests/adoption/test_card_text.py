"""Numbers in a card turn frames as the loader turns them."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitsmith.adoption.card_text import rpy

_Angle = st.floats(-math.pi, math.pi)


def turned(angles: list[float]) -> np.ndarray:
    """Rotation of roll, then pitch, then yaw about fixed axes."""
    quaternion, matrix = np.empty(4), np.empty(9)
    mujoco.mju_euler2Quat(quaternion, np.array(angles), "XYZ")
    mujoco.mju_quat2Mat(matrix, quaternion)
    return matrix.reshape(3, 3)


@given(roll=_Angle, pitch=_Angle, yaw=_Angle)
def test_angles_give_the_rotation_back(roll: float, pitch: float, yaw: float) -> None:
    rotation = turned([roll, pitch, yaw])
    assert turned(rpy(rotation)) == pytest.approx(rotation, abs=1e-4)


@pytest.mark.parametrize("pitch", [-math.pi / 2, math.pi / 2])
def test_also_where_pitch_is_a_right_angle(pitch: float) -> None:
    rotation = turned([0.4, pitch, 1.3])
    assert turned(rpy(rotation)) == pytest.approx(rotation, abs=1e-5)
