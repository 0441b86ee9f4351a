"""Ground that joins exactly, starts level, and depends on nothing but its name and seed."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitsmith.errors import BadInput
from gaitsmith.simulation.terrain import BOX_PITCH, SLOPE_START, Region, parse_terrain

EXACT = 1e-12


def _top(block, x):
    """Height of a block's top face at x, in the plane y = 0."""
    along = np.array([math.cos(block.pitch), -math.sin(block.pitch)])
    up = np.array([math.sin(block.pitch), math.cos(block.pitch)])
    corner = np.array([block.centre[0], block.centre[2]]) + block.half_size[2] * up
    return corner[1] + (x - corner[0]) / along[0] * along[1]


@given(st.floats(-30.0, 30.0))
def test_a_slope_meets_the_level_start_exactly(degrees):
    level, incline = parse_terrain(f"slope:{degrees!r}").blocks(Region())
    assert _top(level, SLOPE_START) == pytest.approx(0.0, abs=EXACT)
    assert _top(incline, SLOPE_START) == pytest.approx(0.0, abs=EXACT)
    assert _top(incline, 4.0) == pytest.approx((4.0 - SLOPE_START) * math.tan(math.radians(degrees)), abs=1e-9)


@given(st.floats(1e-3, 0.3), st.integers(0, 2**32 - 1))
def test_boxes_lie_within_their_heights_and_leave_the_start_level(height, seed):
    blocks = parse_terrain(f"boxes:{height!r}", seed).blocks(Region((-2.0, 3.0), (-1.5, 1.5)))
    tops = np.array([block.centre[2] + block.half_size[2] for block in blocks])
    assert np.all(tops > 0.0)
    assert np.all(tops <= height + EXACT)
    assert all(math.hypot(*block.centre[:2]) > 1.0 for block in blocks)


def test_box_heights_are_spread_evenly():
    tops = [b.centre[2] + b.half_size[2] for b in parse_terrain("boxes:0.1", 3).blocks(Region((-30, 30), (-30, 30)))]
    # 40,000 draws: the mean of U(0, .1) is known to 1.5e-4 (one standard deviation).
    assert np.mean(tops) == pytest.approx(0.05, abs=1e-3)
    assert np.std(tops) == pytest.approx(0.1 / math.sqrt(12), rel=0.02)


def test_a_larger_region_keeps_the_boxes_of_a_smaller_one():
    terrain = parse_terrain("boxes:0.05", 7)
    small, large = (set(terrain.blocks(Region((-2.0, x), (-1.0, 1.0)))) for x in (2.0, 9.0))
    assert small < large
    assert len(set(parse_terrain("boxes:0.05", 8).blocks(Region((-2.0, 2.0), (-1.0, 1.0)))) & small) == 0


@pytest.mark.parametrize("name", ["slope:5", "boxes:0.06"])
def test_height_is_that_of_the_blocks(name):
    terrain = parse_terrain(name, 1)
    for block in terrain.blocks(Region((-2.0, 5.0), (-1.5, 1.5))):
        if block.pitch == 0.0 and terrain.kind == "boxes":
            x, y, _ = block.centre
            assert terrain.height(x + 0.4 * BOX_PITCH, y) == pytest.approx(block.centre[2] + block.half_size[2])


@pytest.mark.parametrize("rise", [0.05, -0.04])
def test_stairs_rise_by_a_tread_at_every_edge_and_end_in_the_plane(rise):
    terrain = parse_terrain(f"stairs:{rise},0.25,0.3,4")
    heights = [terrain.height(x, 0.0) for x in (0.29, 0.31, 0.56, 0.81, 1.06, 2.0, 4.0)]
    assert np.diff(heights[:5]) == pytest.approx(rise)
    assert heights[4] == heights[5] == heights[6]
    assert min(heights) == pytest.approx(0.0)
    tops = [(b.centre[0] - b.half_size[0], b.centre[0] + b.half_size[0], b) for b in terrain.blocks(Region())]
    for x in (-1.0, 0.29, 0.31, 0.56, 0.81, 1.06, 4.0):
        found = [b.centre[2] + b.half_size[2] for low, high, b in tops if low < x < high]
        assert (found or [0.0]) == pytest.approx([terrain.height(x, 0.0)])


@pytest.mark.parametrize("name", ["stairs:0,0.2,0.1,5", "stairs:0.05,0.2,0.1", "stairs:1,0.2,0.1,5", "stairs:a,b,c,d"])
def test_stairs_that_are_none_are_refused(name):
    with pytest.raises(BadInput, match=r"terrain: got .*, expected stairs:RISE,TREAD,EDGE,COUNT"):
        parse_terrain(name)


@pytest.mark.parametrize(
    "name",
    ["", "hill", "slope", "slope:", "slope:31", "slope:nan", "boxes:-0.1", "boxes:1", "flat:3", "boxes:inf", "slope:a"],
)
def test_other_names_are_refused_in_one_line_that_says_what_is_valid_there(name):
    kind = name.partition(":")[0]
    told = kind if kind in ("slope", "boxes") else "flat, slope"
    with pytest.raises(BadInput, match=f"expected {told}:") as caught:
        parse_terrain(name)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("degrees", [-8.0, 5.0])
def test_a_slope_across_contains_the_path(degrees):
    level, tilted = parse_terrain(f"cross:{degrees}").blocks(Region())
    up = np.array([0.0, -math.sin(tilted.roll), math.cos(tilted.roll)])
    top = np.array(tilted.centre) + tilted.half_size[2] * up
    assert top @ up == pytest.approx(0.0, abs=1e-9)
    assert level.centre[2] + level.half_size[2] == 0.0
    assert parse_terrain(f"cross:{degrees}").height(2.0, 0.5) == pytest.approx(0.5 * math.tan(math.radians(degrees)))


def test_ice_is_a_patch_of_level_ground():
    before, ice, after = parse_terrain("ice:0.15,1,2").blocks(Region())
    assert (before.friction, ice.friction, after.friction) == (None, 0.15, None)
    edges = [
        (block.centre[0] - block.half_size[0], block.centre[0] + block.half_size[0]) for block in (before, ice, after)
    ]
    assert edges[0][1] == edges[1][0] == 1.0
    assert edges[1][1] == edges[2][0] == 3.0


@pytest.mark.parametrize(
    "name", ["cross:40", "cross:", "ice:0.1", "ice:0.1,1", "ice:9,1,1", "ice:0.1,0,1", "slope:1,2"]
)
def test_ground_that_is_not_valid(name):
    with pytest.raises(BadInput):
        parse_terrain(name)
