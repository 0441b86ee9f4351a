"""The streams are those of a C++ program: values printed by libstdc++, and the one that the C++ standard gives."""

from __future__ import annotations

import numpy as np
import pytest

from gaitsmith.simulation.random_stream import RandomStream, seed_sequence

STANDARD_SEED, TEN_THOUSANDTH = 5489, 4123659995  # ISO C++, [rand.predef]: of a default-constructed mt19937

# std::seed_seq s{id, stream}; std::mt19937 r(s): its first four numbers, and the 1001st.
PRINTED = {
    (0, 2): ([3825457058, 706492411, 2134599173, 1489500560], 2490646601),
    (1, 3): ([1809848369, 2997353437, 511698448, 4158610213], 1624682730),
    (31, 4): ([1980337911, 2156965964, 4281741967, 3398709330], 389855217),
    (4294967295, 4): ([2479652402, 2587096277, 3003785643, 2090346877], 1387865795),
}


@pytest.mark.parametrize("seeds", PRINTED)
def test_an_engine_draws_what_the_c_plus_plus_library_draws(seeds: tuple[int, int]) -> None:
    first, later = PRINTED[seeds]
    drawn = RandomStream(*seeds).words(1001)
    assert drawn[:4].tolist() == first
    assert drawn[1000] == later


def test_a_seed_sequence_shorter_than_its_engine() -> None:
    printed = [2165849492, 3530306812, 1203579122, 2974549325, 970787303, 1634671513, 2383395534, 905298870]
    assert seed_sequence((7, 2), 8).tolist() == printed


def test_the_engine_is_the_one_of_the_standard() -> None:
    words = [STANDARD_SEED]
    for k in range(1, 624):
        words.append((1812433253 * (words[-1] ^ (words[-1] >> 30)) + k) & 0xFFFFFFFF)
    stream = RandomStream(0)
    key = np.array(words, dtype=np.uint32)
    stream._engine.state = {"bit_generator": "MT19937", "state": {"key": key, "pos": 624}}
    assert stream.words(10_000)[-1] == TEN_THOUSANDTH


def test_uniform_numbers_stay_in_their_range_and_whole_ones_below_their_bound() -> None:
    stream = RandomStream(3, 1)
    drawn = stream.uniform(-2.0, 5.0, 10_000)
    assert -2.0 <= drawn.min() < -1.99
    assert 4.99 < drawn.max() < 5.0
    counts = np.bincount([stream.below(29) for _ in range(5800)], minlength=29)
    assert len(counts) == 29
    assert counts.min() > 130  # of 200 expected: five standard deviations
