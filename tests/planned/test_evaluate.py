"""Curves of a plan: NumPy's own Chebyshev series, and derivatives that are derivatives."""

import numpy as np
import pytest
from numpy.polynomial import chebyshev
from scipy.spatial.transform import Rotation
from tests.planned.plans import JOINTS, two_steps

from gaitsmith.planned.evaluate import evaluate, make_plan_sample, orientation
from gaitsmith.planned.table import TORSO


def sampled(plan, section, time):
    sample = make_plan_sample(2, JOINTS)
    evaluate(plan, section, time, sample)
    return sample.motion.copy(), sample.effort.copy()


@pytest.mark.parametrize("section", [0, 3])
@pytest.mark.parametrize("share", [0.0, 0.13, 1.0])
def test_values_and_derivatives_are_those_of_the_series(section, share):
    plan = two_steps(seed=1)
    span = plan.duration[section]
    motion, effort = sampled(plan, section, share * span)
    x = 2.0 * share - 1.0
    for order in range(3):
        series = chebyshev.chebder(plan.motion[section], order, axis=0)
        expected = chebyshev.chebval(x, series) * (2.0 / span) ** order
        np.testing.assert_allclose(motion[order], expected, atol=1e-9 / span**order)
    np.testing.assert_allclose(effort, chebyshev.chebval(x, plan.effort[section]), atol=1e-12)


def test_beyond_its_ends_a_section_holds_its_ends():
    plan = two_steps(seed=1)
    np.testing.assert_array_equal(sampled(plan, 0, -0.1)[0], sampled(plan, 0, 0.0)[0])
    np.testing.assert_array_equal(sampled(plan, 0, 9.0)[0], sampled(plan, 0, plan.duration[0])[0])


def test_angular_velocity_and_acceleration_are_the_rotations_derivatives():
    plan, heading, step = two_steps(seed=2), 0.7, 1e-5

    def turned(time):
        rotation, spin, turn = np.zeros((3, 3)), np.zeros(3), np.zeros(3)
        orientation(sampled(plan, 1, time)[0], TORSO, heading, rotation, spin, turn)
        return rotation, spin, turn

    rotation, spin, turn = turned(0.04)
    angles = sampled(plan, 1, 0.04)[0][0, TORSO : TORSO + 3]
    expected = Rotation.from_euler("ZYX", angles + np.array([heading, 0.0, 0.0])).as_matrix()
    np.testing.assert_allclose(rotation, expected, atol=1e-12)
    before, after = turned(0.04 - step), turned(0.04 + step)
    rate = Rotation.from_matrix(after[0] @ before[0].T).as_rotvec() / (2.0 * step)
    np.testing.assert_allclose(spin, rate, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(turn, (after[1] - before[1]) / (2.0 * step), rtol=1e-6, atol=1e-5)
