"""Rows by name: views of a buffer whose numbers have names."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt


class Columns:
    """Buffers that change in place, and names for their numbers.

    Args:
        groups: names and (n,) buffer of each.
    """

    def __init__(self, *groups: tuple[Sequence[str], npt.NDArray[np.float64]]) -> None:
        self._groups = groups
        self.names = tuple(name for names, _ in groups for name in names)
        self.buffers = tuple(buffer for _, buffer in groups)

    def find(self, name: str) -> npt.NDArray[np.float64] | None:
        """View of the columns called ``name`` or ``name.anything``, which stand side by side; None without any."""
        names = [other for other in self.names if other == name or other.startswith(name + ".")]
        return self.block(names) if names else None

    def block(self, names: Sequence[str]) -> npt.NDArray[np.float64]:
        """View of columns that stand side by side.

        Raises:
            KeyError: they do not, or there are none of these names.
        """
        for known, buffer in self._groups:
            if names[0] in known:
                first = known.index(names[0])
                if tuple(known[first : first + len(names)]) == tuple(names):
                    return buffer[first : first + len(names)]
        raise KeyError(names[0])

    def labels(self, name: str) -> tuple[str, ...]:
        """What follows ``name.`` in the columns' names."""
        return tuple(other.removeprefix(name + ".") for other in self.names if other.startswith(name + "."))
