"""Random numbers as C++ programs draw them: ``std::mt19937`` seeded by ``std::seed_seq``, the same on every machine."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

_WORDS = 624  # of the engine's state
_ALL = 0xFFFFFFFF


def seed_sequence(seeds: Sequence[int], count: int) -> npt.NDArray[np.uint32]:
    """(count,) words of ``std::seed_seq{seeds...}.generate`` (ISO C++, [rand.util.seedseq]).

    Args:
        seeds: whole numbers of 32 bits.
        count: number of words, at least 1.
    """
    words, length = [0x8B8B8B8B] * count, len(seeds)
    t = next((t for least, t in ((623, 11), (68, 7), (39, 5), (7, 3)) if count >= least), (count - 1) // 2)
    p = (count - t) // 2
    q, rounds = p + t, max(length + 1, count)

    def mixed(value: int) -> int:
        return value ^ (value >> 27)

    for k in range(rounds):
        here, near, far = k % count, (k + p) % count, (k + q) % count
        first = 1664525 * mixed(words[here] ^ words[near] ^ words[(k - 1) % count]) & _ALL
        added = length if k == 0 else here + (seeds[k - 1] if k <= length else 0)
        second = (first + added) & _ALL
        words[near] = (words[near] + first) & _ALL
        words[far] = (words[far] + second) & _ALL
        words[here] = second
    for k in range(rounds, rounds + count):
        here, near, far = k % count, (k + p) % count, (k + q) % count
        first = 1566083941 * mixed((words[here] + words[near] + words[(k - 1) % count]) & _ALL) & _ALL
        second = (first - here) & _ALL
        words[near] ^= first
        words[far] ^= second
        words[here] = second
    return np.array(words, dtype=np.uint32)


class RandomStream:
    """``std::mt19937`` seeded by ``std::seed_seq``.

    Args:
        seeds: whole numbers of 32 bits.
    """

    def __init__(self, *seeds: int) -> None:
        key = seed_sequence(seeds, _WORDS)
        if key[0] >> 31 == 0 and not key[1:].any():
            key[0] = 1 << 31
        self._engine = np.random.MT19937()
        self._engine.state = {"bit_generator": "MT19937", "state": {"key": key, "pos": _WORDS}}

    def words(self, count: int) -> npt.NDArray[np.uint64]:
        """(count,) the engine's next numbers, each of 32 bits."""
        found: npt.NDArray[np.uint64] = self._engine.random_raw(count)
        return found

    def uniform(self, low: float, high: float, count: int = 1) -> npt.NDArray[np.float64]:
        """(count,) numbers from ``low`` to below ``high``, of 24 bits each."""
        units: npt.NDArray[np.float64] = np.asarray((self.words(count) >> np.uint64(8)) * 2.0**-24, dtype=np.float64)
        return low + (high - low) * units

    def below(self, bound: int) -> int:
        """A whole number from 0 to below ``bound``, each as likely as the others."""
        span = 2**32 // bound
        while (drawn := int(self.words(1)[0])) >= span * bound:
            pass
        return drawn // span
