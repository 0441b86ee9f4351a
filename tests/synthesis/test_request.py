"""Any two of speed, step length and period decide the third."""

from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitsmith.errors import BadInput
from gaitsmith.robots import load_robot
from gaitsmith.synthesis.motions.biped import biped_from
from gaitsmith.synthesis.motions.parameters import StepParameters
from gaitsmith.synthesis.requests.asked import RANGES, Request, stride
from gaitsmith.synthesis.requests.request import answer

RANGES_IN_ORDER = ("--speed", "--step-length", "--period")


@given(st.floats(0.05, 0.5), st.floats(0.4, 1.0))
def test_two_of_three(speed, period):
    length = speed * period
    for found in (stride(speed, None, period), stride(None, length, period), stride(speed, length, None)):
        assert found == pytest.approx((length, period))
    assert stride(speed, length, period) == pytest.approx((length, period))


def test_one_follows_the_papers_two_gaits():
    assert stride(0.15, None, None) == pytest.approx((0.15, 1.0))
    assert stride(0.40, None, None) == pytest.approx((0.20, 0.5))
    assert stride(None, 0.20, None) == pytest.approx((0.20, 0.5))
    assert stride(None, None, 0.5) == pytest.approx((0.20, 0.5))
    assert stride(None, None, None) == (0.15, 1.0)


@pytest.mark.parametrize(
    "given", [(0.4, 0.2, 0.6), (-1.0, None, None), (None, 0.1, None), (None, None, 0.2), (5.0, None, 1.0)]
)
def test_what_does_not_agree_is_refused(given):
    with pytest.raises(BadInput, match="--"):
        stride(*given)


@given(st.floats(0.01, 2.0), st.floats(0.005, 1.0), st.floats(0.1, 10.0))
def test_what_is_derived_is_in_range_too(speed, length, period):
    for values in ((speed, None, period), (None, length, period), (speed, length, None), (speed, None, None)):
        try:
            found, time = stride(*values)
        except BadInput as error:
            assert "--" in error.field
        else:
            for flag, value in (("--speed", found / time), ("--step-length", found), ("--period", time)):
                low, high = RANGES[flag]
                assert low * (1 - 1e-9) <= value <= high * (1 + 1e-9)


@pytest.mark.parametrize("given", [(0.01, 1.0, None), (2.0, None, 10.0), (None, 1.0, 0.1), (0.01, None, None)])
def test_what_is_derived_out_of_range_names_what_was_given(given):
    with pytest.raises(BadInput) as caught:
        stride(*given)
    flags = [flag for flag, value in zip(RANGES_IN_ORDER, given, strict=True) if value is not None]
    assert all(flag in caught.value.field for flag in flags)


@pytest.mark.parametrize(("faster", "solved_below", "tried"), [(True, 0.6, 3), (True, 0.0, 5), (False, 0.6, 1)])
def test_shorter_steps_at_the_same_speed_are_tried_where_there_is_no_gait(faster, solved_below, tried):
    seen = []

    def plan(motion, settings, neighbour, report):
        seen.append((motion.parameters["length"], motion.parameters["period"]))
        return SimpleNamespace(gait="gait" if seen[-1][1] < solved_below else None)

    planner = SimpleNamespace(biped=biped_from(load_robot("thbip_ii")), plan=plan)
    found = answer(planner, Request("cyclic", step=StepParameters(0.15, 1.0), faster=faster))
    assert found.gait == ("gait" if faster and solved_below else None)
    assert len(seen) == tried
    assert all(length / period == pytest.approx(0.15) for length, period in seen)
    assert found.periods == tuple(period for _, period in seen[:-1])
