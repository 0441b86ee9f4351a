"""A histogram of wall times tells what the times themselves would."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitsmith.simulation.wall_time import WallTimes

WITHIN = 5e-3  # relative; the width of a bin


@given(st.lists(st.integers(100, 10**10), min_size=1, max_size=2500))
def test_median_and_late_are_within_half_a_per_cent(times):
    walls = WallTimes(1e-3)
    for time in times:
        walls.add(time)
    found = walls.summary()
    exact = np.percentile(times, [50, 99], method="inverted_cdf") / 1000.0
    assert (found.median, found.p99) == pytest.approx(tuple(exact), rel=WITHIN)
    assert found.max == pytest.approx(max(times) / 1000.0)
    assert found.overruns == sum(time > 10**6 for time in times)
    assert int(walls.histogram()[1].sum()) == len(times)


def test_no_tick_took_no_time():
    assert WallTimes(1e-3).summary().max == 0.0
