"""The zero moment point is where the ground's forces act; the margin is how far inside the soles that is."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from gaitsmith.synthesis.gaits.support import contact_points, depths, hull, inside, zmp
from gaitsmith.synthesis.motions.motion import Phase

ROUNDING = 1e-12
STEP = Phase("flat", 0.2, "right", "flat", (0.3, -0.1), (0.5, 0.1))
LOAD = {"left": 120.0, "right": 200.0}


def pressed(phase, points):
    """Wrenches (12, 1) about the soles' origins of vertical loads at points of the world, by foot."""
    places = {phase.support: phase.foothold, "left" if phase.support == "right" else "right": phase.other}
    found = np.zeros((12, 1))
    for first, side in ((0, "left"), (6, "right")):
        if side in points:
            force = np.array([30.0, -20.0, LOAD[side]])  # friction on the ground moves no zero moment point
            arm = np.append(np.subtract(points[side], places[side]), 0.0)
            found[first : first + 6, 0] = np.concatenate([force, np.cross(arm, force)])
    return found


@pytest.mark.parametrize("side", ["left", "right"])
def test_under_one_foot_it_is_where_the_force_acts(side):
    point = {"left": (0.55, 0.12), "right": (0.26, -0.13)}[side]
    assert np.abs(zmp(STEP, pressed(STEP, {side: point}))[:, 0] - point).max() < ROUNDING


def test_under_two_feet_it_is_the_mean_by_load():
    points = {"left": (0.55, 0.12), "right": (0.26, -0.13)}
    mean = sum(LOAD[side] * np.array(point) for side, point in points.items()) / sum(LOAD.values())
    assert np.abs(zmp(STEP, pressed(STEP, points))[:, 0] - mean).max() < ROUNDING


def test_the_margin_is_the_distance_from_the_hulls_edge(planner):
    biped, single = planner.biped, Phase("swing", 0.4, "right", "air", (0.3, -0.1))
    sole = biped.leg("right").sole
    for depth in (0.005, -0.005):
        point = (0.3 + sole.toe - depth, -0.1)
        (found,) = depths(biped, [single], zmp(single, pressed(single, {"right": point})).T)
        assert abs(found - depth) < ROUNDING


def test_both_feet_bear_between_the_soles(planner):
    points = {"left": (0.5, 0.1), "right": (0.3, -0.1)}
    assert depths(planner.biped, [STEP], zmp(STEP, pressed(STEP, points)).T) > 0.0
    assert len(hull(contact_points(planner.biped, STEP))) == 6


# Corners on a millimetre grid: collinear and repeated ones come up often.
clouds = arrays(np.int64, st.tuples(st.integers(4, 12), st.just(2)), elements=st.integers(-300, 300)).map(
    lambda grid: grid * 1e-3
)


@given(clouds)
def test_the_hull_holds_its_points_and_turns_left_only(points):
    corners = hull(points)
    assume(len(corners) > 2)
    assert inside(corners, points.T).min() > -ROUNDING
    edges = np.roll(corners, -1, axis=0) - corners
    following = np.roll(edges, -1, axis=0)
    assert np.all(edges[:, 0] * following[:, 1] - edges[:, 1] * following[:, 0] > 0.0)


def test_distances_from_a_rectangles_edge():
    rectangle = hull(np.array([(x, y) for x in (-0.1, 0.2) for y in (-0.03, 0.03)]))
    points = np.array([[0.0, 0.0], [0.19, 0.0], [0.25, 0.0]]).T
    assert np.abs(inside(rectangle, points) - [0.03, 0.01, -0.05]).max() < ROUNDING


def test_hull_of_points():
    points = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 0.5], [0.5, 0.0]])
    assert sorted(map(tuple, hull(points))) == [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)]


def test_under_a_sole_that_rises_it_is_where_the_force_acts():
    """On its toe: the moment is about a point that has moved up and ahead."""
    moved, force = np.array([0.01, 0.0, 0.03]), np.array([30.0, -20.0, 400.0])
    single = replace(STEP, contact="air", other=None)
    point = np.add(single.foothold, (0.1, 0.02))
    arm = np.append(point - single.foothold, 0.0) - moved
    found = np.zeros((12, 1))
    first = 0 if single.support == "left" else 6
    found[first : first + 6, 0] = np.concatenate([force, np.cross(arm, force)])
    assert np.abs(zmp(single, found, moved[:, None])[:, 0] - point).max() < ROUNDING
