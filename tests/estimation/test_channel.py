"""A reading that passes at once is kept just as the whole check keeps it."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitsmith.estimation.channel import judge, passes, settle
from gaitsmith.estimation.measurement import make_measurement
from gaitsmith.estimation.readings import ANGLES, GOOD, POSITION, Readings, make_readings

DT = 0.001


def seen(c: int, off: float, still: bool, lost: int, what: int, trusted: int) -> Readings:
    """A channel whose reading is ``off`` gates from what the model says."""
    readings, _ = make_readings(make_measurement(2, 2), False, 400.0, 4.0, 0.6, DT)
    entries = slice(int(readings.first[c]), int(readings.first[c + 1]))
    readings.wanted[entries] = 0.1
    readings.values[entries] = 0.1 + off * readings.gate[c]
    readings.before[entries] = readings.values[entries] if still else 0.2
    readings.still[c], readings.lost[c], readings.what[c] = 3 * still, lost, what
    readings.moving[0], readings.trusted[0] = 1, trusted
    return readings


@settings(max_examples=60)
@given(
    c=st.sampled_from([POSITION, ANGLES]),
    off=st.sampled_from([0.0, 0.5, -0.99, 1.01, np.nan, np.inf]),
    still=st.booleans(),
    lost=st.sampled_from([0, 0, 2]),
    what=st.sampled_from([GOOD, GOOD, 3]),
    trusted=st.integers(0, 1),
)
def test_a_reading_that_passes_is_kept_as_by_the_whole_check(
    c: int, off: float, still: bool, lost: int, what: int, trusted: int
) -> None:
    at_once, whole = seen(c, off, still, lost, what, trusted), seen(c, off, still, lost, what, trusted)
    before = [array.copy() for array in at_once]
    passed = passes(at_once, c)
    if not passed:
        for name, now, then in zip(Readings._fields, at_once, before, strict=True):
            np.testing.assert_array_equal(now, then, err_msg=name)
        return
    assert (abs(off) < 1.0, still, lost, what) == (True, False, 0, GOOD)
    assert judge(whole, c, DT) == GOOD
    settle(whole, c, GOOD, True)
    for name, one, other in zip(Readings._fields, at_once, whole, strict=True):
        np.testing.assert_array_equal(one, other, err_msg=name)
