"""CasADi functions of one point of a gait: values, Jacobian and Hessian, compiled when a C compiler is present."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt

from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.point.caller import Caller
from gaitsmith.synthesis.point.layout import KINDS, PointLayout, layout_of
from gaitsmith.synthesis.point.library import point_library

_KEPT = 64  # mapped functions that are remembered

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class PointFunctions:
    """The functions of a point and how they came about.

    Attributes:
        layout: meaning of inputs z and outputs o.
        sides: for the right foot as support, and for the left one unless the robot is its own mirror image:
            value: (z, pivot) -> o;
            jacobian: (z, pivot) -> (o, do/dz);
            hessian: (z, pivot, multipliers, weight) -> d²(multipliersᵀ o)/dz² + 2 weight JᵀJ with J = dτ/dz.
        compiled: whether they are machine code.
        compile_s: time spent compiling in this call, s.
    """

    layout: PointLayout
    sides: tuple[tuple[Any, Any, Any], ...]
    compiled: bool
    compile_s: float
    _mapped: dict[tuple[str, int, int], Caller] = field(default_factory=dict)

    def side(self, support: float) -> int:
        """Which of ``sides`` a phase takes; ``support``: +1 with the right foot as support, -1 with the left."""
        return 0 if support > 0.0 else len(self.sides) - 1

    def evaluate(self, points: Array, pivots: Array, support: float = 1.0) -> Array:
        """Outputs (outputs, K) for many points with one support: inputs (inputs, K), pivots (3, K; on slopes 6)."""
        count = points.shape[1]
        if count == 0:
            return np.zeros((self.layout.outputs, 0))
        (found,) = self._caller("value", count, self.side(support))(points.T.ravel(), pivots.T.ravel())
        return found.reshape(count, self.layout.outputs).T.copy()

    def differentiate(self, points: Array, pivots: Array, support: float) -> tuple[Array, Array]:
        """Outputs (outputs, K) and Jacobians (K, outputs, inputs) for many points with one support."""
        count = points.shape[1]
        values, slopes = self._caller("jacobian", count, self.side(support))(points.T.ravel(), pivots.T.ravel())
        rows, columns = self.pattern("jacobian").get_triplet()
        dense = np.zeros((count, self.layout.outputs, self.layout.inputs))
        dense[:, rows, columns] = slopes.reshape(count, -1)
        return values.reshape(count, self.layout.outputs).T.copy(), dense

    def pattern(self, kind: str) -> Any:
        """Sparsity of the last output of a function, the same for all sides."""
        function = self.sides[0][KINDS.index(kind)]
        return function.sparsity_out(function.n_out() - 1)

    def mapped(self, kind: str, groups: tuple[int, ...], *arguments: Any) -> list[Any]:
        """CasADi expressions of a function's outputs at many points: so many of each side, in the order of columns."""
        found = []
        for index, (side, count) in enumerate(zip(self.sides, groups, strict=True)):
            first = sum(groups[:index])
            if count:
                found.append(side[KINDS.index(kind)].map(count).call([a[:, first : first + count] for a in arguments]))
        return [ca.horzcat(*outputs) for outputs in zip(*found, strict=True)]

    def called(self, kind: str, count: int, side: int, arguments: Sequence[Array]) -> list[Array]:
        """Nonzeros of a function's outputs at many points of one side, overwritten by the next call."""
        return self._caller(kind, count, side)(*arguments)

    def _caller(self, kind: str, count: int, side: int) -> Caller:
        """The function mapped over a number of points, kept for the next time."""
        key = (kind, count, side)
        if key not in self._mapped:
            if len(self._mapped) > _KEPT:
                self._mapped.clear()
            self._mapped[key] = Caller(self.sides[side][KINDS.index(kind)].map(count))
        return self._mapped[key]


def point_functions(biped: Biped, notify: Callable[[str], None] | None = None) -> PointFunctions:
    """The functions of a point for one robot, from the cache, the compiler, or CasADi's virtual machine.

    Args:
        biped: the robot as the planner sees it.
        notify: called once before a slow operation (compiling, or working without a compiler or a cache).

    Raises:
        CacheRefused: the cache folder is not the owner's alone.
    """
    loaded, spent = point_library(biped, notify or (lambda _: None))
    compiled = loaded is not None
    if loaded is None:
        from gaitsmith.synthesis.point.expressions import point_expressions

        loaded = point_expressions(biped)
    sides = tuple((loaded[k], loaded[k + 1], loaded[k + 2]) for k in range(0, len(loaded), 3))
    return PointFunctions(layout_of(biped), sides, compiled, spent)
