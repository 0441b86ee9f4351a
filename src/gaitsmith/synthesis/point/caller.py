"""CasADi functions called on NumPy arrays, without copies of their results."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]


class Caller:
    """Calls a CasADi function on NumPy arrays without copies of its sparse results.

    Args:
        function: the function.

    Attributes:
        results: nonzeros of every output, overwritten by the next call.
    """

    def __init__(self, function: Any) -> None:
        self._buffer, self._call = function.buffer()
        self._arguments: list[Any] = [np.zeros(function.nnz_in(k)) for k in range(function.n_in())]
        self.results: list[Any] = [np.zeros(function.nnz_out(k)) for k in range(function.n_out())]
        self._function = function
        self._patterns: dict[int, tuple[Indices, Indices, tuple[int, int]]] = {}  # made when asked for: they are long
        for k, array in enumerate(self._arguments):
            self._buffer.set_arg(k, memoryview(array))
        for k, array in enumerate(self.results):
            self._buffer.set_res(k, memoryview(array))

    def __call__(self, *arguments: Array | float) -> list[Array]:
        """Nonzeros of the outputs at these arguments, column by column."""
        for array, given in zip(self._arguments, arguments, strict=True):
            array[:] = given
        self._call()
        return self.results

    def matrix(self, output: int) -> sp.csc_matrix:
        """An output of the last call as a sparse matrix that shares its memory."""
        if output not in self._patterns:
            pattern = self._function.sparsity_out(output)
            shape = pattern.size1(), pattern.size2()
            self._patterns[output] = np.array(pattern.row()), np.array(pattern.colind()), shape
        row, colind, shape = self._patterns[output]
        return sp.csc_matrix((self.results[output], row, colind), shape=shape)
