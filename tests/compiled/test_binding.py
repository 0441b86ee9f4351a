"""What a kernel binds is the arena's own memory, and binding allocates nothing."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

from gaitsmith.compiled import Arena, Cube, IntVector, Matrix, Vector, bind, kernel


class First(NamedTuple):
    """Scalars and arrays."""

    gain: float
    count: int
    values: Vector
    table: Matrix


class Second(NamedTuple):
    """Integers and three axes."""

    places: IntVector
    block: Cube


class Both(NamedTuple):
    """Two groups."""

    first: First
    second: Second


@kernel
def combine(table: int) -> None:
    """Write a sum of everything bound into the first group's values."""
    both = bind(Both, table)
    first, second = both.first, both.second
    for k in range(first.count):
        first.values[k] = first.gain * first.table[k, k + 1] + second.places[k] + second.block[1, 0, k]


def arena() -> Arena[Both]:
    """Two groups whose combination is known."""
    first = First(2.0, 3, np.zeros(3), np.arange(12.0).reshape(3, 4))
    return Arena(Both(first, Second(np.array([10, 20, 30]), np.arange(12.0).reshape(2, 2, 3))))


def test_a_kernel_reads_and_writes_the_arena() -> None:
    kept = arena()
    combine(kept.address)
    expected = 2.0 * np.array([1.0, 6.0, 11.0]) + [10, 20, 30] + np.array([6.0, 7.0, 8.0])
    np.testing.assert_array_equal(kept.view.first.values, expected)


def test_a_scalar_changed_in_the_arena_reaches_the_next_call() -> None:
    kept = arena()
    kept.view.first.gain[0] = 0.0
    combine(kept.address)
    np.testing.assert_array_equal(kept.view.first.values, [16.0, 27.0, 38.0])


def test_arrays_that_fit_are_shared() -> None:
    values = np.zeros(3)
    kept = Arena(First(1.0, 3, values, np.zeros((3, 4))))
    assert np.shares_memory(kept.view.values, values)


@pytest.mark.parametrize("values", [np.zeros((3, 3)), np.zeros((2, 2, 2))])
def test_a_wrong_number_of_axes_is_refused(values: np.ndarray) -> None:
    with pytest.raises(TypeError, match=r"First\.values"):
        Arena(First(1.0, 3, values, np.zeros((3, 4))))


def test_an_annotation_that_cannot_be_bound_is_refused() -> None:
    class Wrong(NamedTuple):
        """A field that no kernel can hold."""

        name: str

    with pytest.raises(TypeError, match="cannot be bound"):
        Arena(Wrong("x"))
