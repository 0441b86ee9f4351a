"""A sole frame is where the engine has it."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from tests.dynamics.trees import random_state

from gaitsmith.dynamics import sole_pose

ORACLE = 1e-9  # relative


@pytest.mark.parametrize("name", ["bhr_b2", "planar", "with_arms"])
def test_sole_pose_agrees_with_mujoco(name):
    model, data, tree, state, _, _ = random_state(name, 0)
    for site in range(model.nsite):
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, model.site_quat[site])
        position, rotation = np.zeros(3), np.zeros((3, 3))
        body = int(model.site_bodyid[site])
        sole_pose(tree, state, body, model.site_pos[site].copy(), turn.reshape(3, 3), position, rotation)
        np.testing.assert_allclose(position, data.site_xpos[site], rtol=ORACLE, atol=ORACLE)
        np.testing.assert_allclose(rotation.ravel(), data.site_xmat[site], atol=ORACLE)
