from __future__ import annotations

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from tests.dynamics.trees import random_state

from gaitsmith.dynamics import sole_corners, sole_pose, support_polygon, zmp_margin

ORACLE = 1e-9  # relative
GEOMETRY = 1e-9  # m; coordinates are of order 1

# Corners on a millimetre grid: collinear and repeated ones come up often.
clouds = arrays(np.int64, st.tuples(st.integers(1, 12), st.just(2)), elements=st.integers(-300, 300)).map(
    lambda grid: grid * 1e-3
)


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


def test_sole_corners():
    np.testing.assert_array_equal(sole_corners(0.1, 0.2), [[-0.1, 0, 0], [0.2, 0, 0]])
    assert len(sole_corners(0.1, 0.2, 0.03)) == 4


@given(clouds)
def test_the_polygon_is_convex_counterclockwise_and_holds_every_corner(points):
    polygon = support_polygon(points)
    assert all(any(np.array_equal(vertex, point) for point in points) for vertex in polygon)
    for point in points:
        assert zmp_margin(polygon, point) >= -GEOMETRY
    if len(polygon) > 2:
        edges = np.roll(polygon, -1, axis=0) - polygon
        following = np.roll(edges, -1, axis=0)
        assert np.all(edges[:, 0] * following[:, 1] - edges[:, 1] * following[:, 0] > 0.0)


@given(clouds, arrays(np.float64, 2, elements=st.floats(-1.0, 1.0)))
def test_the_margin_changes_no_faster_than_the_zmp_moves(points, zmp):
    polygon = support_polygon(points)
    step = np.array([0.003, -0.004])
    assert abs(zmp_margin(polygon, zmp + step) - zmp_margin(polygon, zmp)) <= 0.005 + GEOMETRY


def test_margin_of_a_rectangle_a_line_and_a_point():
    rectangle = support_polygon(sole_corners(0.1, 0.2, 0.03))
    assert zmp_margin(rectangle, np.array([0.0, 0.0])) == pytest.approx(0.03)
    assert zmp_margin(rectangle, np.array([0.19, 0.0])) == pytest.approx(0.01)
    assert zmp_margin(rectangle, np.array([0.25, 0.0])) == pytest.approx(-0.05)
    line = support_polygon(sole_corners(0.1, 0.2))
    assert zmp_margin(line, np.array([0.0, 0.0])) == 0.0
    assert zmp_margin(line, np.array([0.23, 0.04])) == pytest.approx(-0.05)
    assert zmp_margin(support_polygon(np.zeros((3, 3))), np.array([0.3, 0.4])) == pytest.approx(-0.5)
