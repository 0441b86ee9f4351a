"""Eight neighbours at once do what a loop over them does."""

from __future__ import annotations

import numpy as np
import pytest

from gaitsmith.compiled import Matrix, kernel
from gaitsmith.compiled.lanes import LANES, entry, none, padded, plus, put, storage, take, times


@kernel
def _mix(a: Matrix, share: float, out: Matrix) -> None:
    """Row 0 of ``out`` from rows 0 and 1 of ``a``, eight columns from the third."""
    put(out, 0, 2, plus(plus(none(), entry(a, 1, 0), take(a, 0, 2)), 1.0, times(take(a, 1, 2), share)))


def test_lanes_are_a_loop() -> None:
    a, out = np.random.default_rng(0).normal(size=(2, 16)), np.full((2, 16), 7.0)
    _mix(a, -0.5, out)
    inside = slice(2, 2 + LANES)
    np.testing.assert_array_equal(out[0, inside], a[0, inside] * a[1, 0] + -0.5 * a[1, inside])
    out[0, inside] = 7.0
    assert (out == 7.0).all()


@pytest.mark.parametrize(("n", "columns"), [(0, 0), (1, 8), (8, 8), (9, 16)])
def test_storage_is_rounded_up(n: int, columns: int) -> None:
    assert padded(n) == columns


@pytest.mark.parametrize("shape", [(3, 5), (2, 3, 8), (1, 17)])
def test_eight_neighbours_lie_in_one_line_of_the_cache(shape: tuple[int, ...]) -> None:
    for _ in range(5):
        found = storage(*shape)
        assert found.shape == (*shape[:-1], padded(shape[-1]))
        assert found.flags.c_contiguous
        assert found.ctypes.data % (8 * LANES) == 0
        assert not found.any()
        found[...] = 1.0  # all of it is memory of its own
