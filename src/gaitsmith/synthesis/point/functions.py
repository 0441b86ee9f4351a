"""CasADi functions of one point of a gait: values, Jacobian and Hessian, compiled when a C compiler is present."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.point.caller import Caller
from gaitsmith.synthesis.point.expressions import point_expressions
from gaitsmith.synthesis.point.layout import PointLayout
from gaitsmith.synthesis.point.library import point_library

_KEPT = 64  # mapped functions that are remembered

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class PointFunctions:
    """The three functions of a point and how they came about.

    Attributes:
        layout: meaning of inputs z and outputs o.
        value: (z, pivot) -> o.
        jacobian: (z, pivot) -> (o, do/dz).
        hessian: (z, pivot, multipliers, weight) -> d²(multipliersᵀ o)/dz² + 2 weight JᵀJ with J = dτ/dz.
        compiled: whether they are machine code.
        compile_s: time spent compiling in this call, s.
    """

    layout: PointLayout
    value: Any
    jacobian: Any
    hessian: Any
    compiled: bool
    compile_s: float
    _mapped: dict[tuple[str, int], Caller] = field(default_factory=dict)
    _places: dict[str, npt.NDArray[np.int64]] = field(default_factory=dict)

    def evaluate(self, points: Array, pivots: Array) -> Array:
        """Outputs (outputs, K) for many points: inputs (inputs, K) and pivots (3, K)."""
        count = points.shape[1]
        if count == 0:
            return np.zeros((self.layout.outputs, 0))
        (found,) = self._caller("value", count)(points.T.ravel(), pivots.T.ravel())
        return found.reshape(count, self.layout.outputs).T.copy()

    def differentiate(self, points: Array, pivots: Array) -> tuple[Array, Array]:
        """Outputs (outputs, K) and Jacobians (K, outputs, inputs) for many points."""
        count = points.shape[1]
        values, slopes = self._caller("jacobian", count)(points.T.ravel(), pivots.T.ravel())
        dense = self._dense("jacobian", 1, slopes, (self.layout.outputs, self.layout.inputs))
        return values.reshape(count, self.layout.outputs).T.copy(), dense

    def _dense(self, name: str, output: int, nonzeros: Array, shape: tuple[int, int]) -> Array:
        """Matrices (K, *shape) from the nonzeros of a mapped function's output."""
        if name not in self._places:
            rows, columns = getattr(self, name).sparsity_out(output).get_triplet()
            self._places[name] = np.array(rows) * shape[1] + np.array(columns)
        places = self._places[name]
        found = np.zeros((len(nonzeros) // len(places), shape[0] * shape[1]))
        found[:, places] = nonzeros.reshape(-1, len(places))
        return found.reshape(-1, *shape)

    def _caller(self, name: str, count: int) -> Caller:
        """The function mapped over a number of points, kept for the next time."""
        key = (name, count)
        if key not in self._mapped:
            if len(self._mapped) > _KEPT:
                self._mapped.clear()
            self._mapped[key] = Caller(getattr(self, name).map(count))
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
    value, jacobian, hessian = loaded if loaded is not None else point_expressions(biped)
    return PointFunctions(PointLayout(biped.joints), value, jacobian, hessian, loaded is not None, spent)
