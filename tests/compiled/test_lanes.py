"""Eight neighbours at once do what a loop over them does."""

from __future__ import annotations

import numpy as np
import pytest

from gaitsmith.compiled import Matrix, kernel
from gaitsmith.compiled.lanes import LANES, none, padded, plus, product, put, sum_of, take, times, total


@kernel
def _mix(a: Matrix, share: float, out: Matrix) -> float:
    """Row 0 of ``out`` from rows 0 and 1 of ``a``, eight columns from the third; returns the product of those rows."""
    first, second = take(a, 0, 2), take(a, 1, 2)
    put(out, 0, 2, plus(times(first, 3.0), share, sum_of(second, none())))
    return total(product(first, second))


def test_lanes_are_a_loop() -> None:
    a, out = np.random.default_rng(0).normal(size=(2, 16)), np.full((2, 16), 7.0)
    dot = _mix(a, -0.5, out)
    inside = slice(2, 2 + LANES)
    np.testing.assert_array_equal(out[0, inside], a[0, inside] * 3.0 + -0.5 * a[1, inside])
    out[0, inside] = 7.0
    assert (out == 7.0).all()
    assert dot == pytest.approx(a[0, inside] @ a[1, inside], rel=1e-14)


@pytest.mark.parametrize(("n", "columns"), [(0, 0), (1, 8), (8, 8), (9, 16)])
def test_storage_is_rounded_up(n: int, columns: int) -> None:
    assert padded(n) == columns
