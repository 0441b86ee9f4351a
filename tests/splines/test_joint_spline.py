"""Splines: joined C², linear in their control points."""

import numpy as np
import pytest

from gaitsmith.splines.joint_spline import JointSpline

ROUNDING = 1e-9


@pytest.mark.parametrize("degree", [4, 5])
def test_spline_is_continuous_to_the_second_derivative(degree):
    rng = np.random.default_rng(0)
    knots = np.cumsum(rng.uniform(0.1, 0.6, 7))
    spline = JointSpline(knots, degree)
    control = rng.normal(size=spline.size)
    for k in range(1, len(knots) - 1):
        for derivative in range(3):
            values = [
                spline.row(s, knots[k], derivative) @ control[spline.first(s) : spline.first(s) + degree + 1]
                for s in (k - 1, k)
            ]
            assert abs(values[0] - values[1]) < ROUNDING * max(1.0, abs(values[0]))


@pytest.mark.parametrize("degree", [4, 5])
def test_constant_control_points_give_a_constant(degree):
    spline = JointSpline(np.array([0.0, 0.2, 0.7, 0.9]), degree)
    for section, t in ((0, 0.1), (1, 0.5), (2, 0.9)):
        assert abs(spline.row(section, t).sum() - 1.0) < ROUNDING
        assert abs(spline.row(section, t, 1).sum()) < ROUNDING


@pytest.mark.parametrize("degree", [4, 5])
def test_a_line_s_values_at_the_places_of_the_control_points_give_the_line(degree):
    spline = JointSpline(np.array([0.0, 0.2, 0.7, 0.9]), degree)
    control = 0.3 - 2.0 * spline.places
    for section, t in ((0, 0.1), (1, 0.5), (2, 0.9)):
        own = control[spline.first(section) : spline.first(section) + degree + 1]
        assert abs(spline.row(section, t) @ own - (0.3 - 2.0 * t)) < ROUNDING
        assert abs(spline.row(section, t, 1) @ own + 2.0) < ROUNDING
