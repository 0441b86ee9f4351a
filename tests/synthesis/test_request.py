"""Any two of speed, step length and period decide the third."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitsmith.errors import BadInput
from gaitsmith.synthesis.request import stride


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
