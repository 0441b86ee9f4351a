"""The limit named first is the one that was hit first and for long enough."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitsmith.simulation.fall import first_hits
from gaitsmith.simulation.monitor import MEMORY

NAMES = ("torque of knee saturated", "friction limit of the left sole", "legs touching each other")
DT = 1e-3


def _ring(flags: np.ndarray) -> np.ndarray:
    """Flags per tick as the monitor's ring holds them."""
    ring = np.zeros((MEMORY, flags.shape[1]), dtype=np.int64)
    for tick, row in enumerate(flags):
        ring[tick % MEMORY] = row
    return ring


@given(
    st.integers(10, 4000), st.lists(st.tuples(st.integers(0, 2), st.integers(0, 1400), st.integers(1, 60)), max_size=5)
)
def test_hits_are_found_where_they_began(ticks, episodes):
    flags = np.zeros((ticks, 3), dtype=np.int64)
    for column, before, length in episodes:
        start = max(0, ticks - 1 - before)
        flags[start : start + length, column] = 1
    found = {hit.name: hit.before for hit in first_hits(_ring(flags), ticks, NAMES, DT)}
    recent = flags[-MEMORY:]
    for column, need in enumerate((5, 5, 1)):
        runs = [i for i in range(len(recent) - need + 1) if recent[i : i + need, column].all()]
        if runs:
            assert found[NAMES[column]] == pytest.approx((len(recent) - 1 - runs[0]) * DT)
        else:
            assert NAMES[column] not in found


def test_the_earliest_comes_first():
    flags = np.zeros((2000, 3), dtype=np.int64)
    flags[1500:1600, 1] = 1
    flags[1900, 2] = 1
    flags[1700:1702, 0] = 1
    assert [hit.name for hit in first_hits(_ring(flags), 2000, NAMES, DT)] == [NAMES[1], NAMES[2]]


def test_what_is_older_than_the_memory_is_forgotten():
    flags = np.zeros((4000, 3), dtype=np.int64)
    flags[100:400, 0] = 1
    assert first_hits(_ring(flags), 4000, NAMES, DT) == []
