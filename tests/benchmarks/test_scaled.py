"""A scaled robot is the same robot, seen from another distance."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from benchmarks.scaled import write_scaled

from gaitsmith.experiments.sets import leg_length
from gaitsmith.robots import load_robot

FACTOR = 2.0
EXACT = 1e-8


@pytest.mark.parametrize("name", ["bhr_b2", "thbip_ii"])
def test_masses_lengths_and_torques_scale_alike(tmp_path, name):
    small, large = load_robot(name), load_robot(str(write_scaled(name, FACTOR, tmp_path)))
    assert large.mass == pytest.approx(FACTOR**3 * small.mass)
    assert leg_length(large) == pytest.approx(FACTOR * leg_length(small))
    np.testing.assert_allclose(large.torque_limit, FACTOR**4 * small.torque_limit)
    np.testing.assert_allclose(large.model.body_inertia, FACTOR**5 * small.model.body_inertia, rtol=EXACT)
    np.testing.assert_allclose(large.model.body_ipos, FACTOR * small.model.body_ipos, atol=EXACT)


def test_the_same_torque_per_weight_and_length_bends_it_alike(tmp_path):
    """One physics step: accelerations of the joints go with 1/s, as all angles over the square of a time."""
    accelerations = []
    for name, factor in (("thbip_ii", 1.0), (str(write_scaled("thbip_ii", FACTOR, tmp_path)), FACTOR)):
        model = load_robot(name).model
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT  # its stiffness is a time of its own
        data = mujoco.MjData(model)
        data.qfrc_applied[6:] = factor**4 * np.linspace(-5.0, 5.0, model.nv - 6)
        mujoco.mj_forward(model, data)
        accelerations.append(data.qacc[3:].copy())
    np.testing.assert_allclose(FACTOR * accelerations[1], accelerations[0], rtol=1e-6, atol=1e-6)
