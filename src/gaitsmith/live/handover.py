"""Numbers and words handed from one process to another through shared memory; neither side ever waits.

One process writes, any number reads. A reader that is slow misses rows, and the writer never knows.
"""

from __future__ import annotations

import json
from multiprocessing.shared_memory import SharedMemory
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
_HEAD = 8  # bytes before the rows: how many were written
_WORDS = 32_768  # bytes of the longest note


class Ring:
    """The latest rows of numbers.

    A row carries its number before and behind its values, so that a reader notices one that is being overwritten.

    Args:
        columns: numbers in a row.
        rows: that are kept.
        name: of a ring that another process has made; None makes one.

    Attributes:
        name: to open it with in another process.
    """

    def __init__(self, columns: int, rows: int, name: str | None = None) -> None:
        size = _HEAD + 8 * rows * (columns + 2)
        self._memory = SharedMemory(name, create=name is None, size=size)
        self.name, self.columns, self._owner = self._memory.name, columns, name is None
        self._head: npt.NDArray[np.int64] = np.ndarray(1, np.int64, self._memory.buf)
        self._rows: Array = np.ndarray((rows, columns + 2), np.float64, self._memory.buf, _HEAD)
        if self._owner:
            self._head[0], self._rows[:] = 0, -1.0

    @property
    def written(self) -> int:
        """Rows written so far."""
        return int(self._head[0])

    def write(self, values: npt.ArrayLike) -> None:
        """Add a row; the oldest one goes."""
        number = int(self._head[0])
        row = self._rows[number % len(self._rows)]
        row[0] = row[-1] = -1.0
        row[1:-1] = values
        row[0] = row[-1] = number
        self._head[0] = number + 1

    def read(self, since: int, most: int | None = None) -> tuple[Array, int]:
        """(n, columns) rows from number ``since`` on that are still there, at most the latest ``most``, oldest first.

        Returns:
            The rows, and the number of the next one.
        """
        end = self.written
        first = max(since, end - len(self._rows), 0 if most is None else end - most)
        numbers = np.arange(first, end)
        at = numbers % len(self._rows)
        copy = self._rows[at]
        whole = (copy[:, 0] == numbers) & (copy[:, -1] == numbers) & (self._rows[at, 0] == numbers)
        return copy[whole, 1:-1], end

    def close(self) -> None:
        """Let go of the memory; the process that made it removes it."""
        del self._head, self._rows
        self._memory.close()
        if self._owner:
            self._memory.unlink()


class Note:
    """The latest few words, as plain data.

    Args:
        name: of a note that another process has made; None makes one.
    """

    def __init__(self, name: str | None = None) -> None:
        self._memory = SharedMemory(name, create=name is None, size=24 + _WORDS)
        self.name, self._owner = self._memory.name, name is None
        self._head: npt.NDArray[np.int64] = np.ndarray(3, np.int64, self._memory.buf)  # number, length, number
        self._text: npt.NDArray[np.uint8] = np.ndarray(_WORDS, np.uint8, self._memory.buf, 24)
        if self._owner:
            self._head[:] = 0

    def write(self, content: dict[str, Any]) -> None:
        """Replace what it says; what is too long is left out."""
        text = json.dumps(content).encode()
        if len(text) > _WORDS:
            return
        self._head[0] += 1
        self._text[: len(text)] = np.frombuffer(text, np.uint8)
        self._head[1] = len(text)
        self._head[2] = self._head[0]

    def read(self, seen: int) -> tuple[dict[str, Any], int]:
        """What it says and its number; nothing and ``seen`` if it has not changed or is being written."""
        number, length = int(self._head[2]), int(self._head[1])
        if number == seen:
            return {}, seen
        text = self._text[:length].tobytes()
        if int(self._head[0]) != number:
            return {}, seen
        try:
            content: dict[str, Any] = json.loads(text)
        except ValueError:
            return {}, seen
        return content, number

    def close(self) -> None:
        """Let go of the memory; the process that made it removes it."""
        del self._head, self._text
        self._memory.close()
        if self._owner:
            self._memory.unlink()
