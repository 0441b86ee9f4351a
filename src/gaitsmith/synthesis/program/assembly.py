"""A program's derivatives as CasADi functions: compiled per point, mapped, and assembled sparsely as BᵀHB."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from gaitsmith.synthesis.program.program import Program

Array = npt.NDArray[np.float64]


def _sparse(matrix: sp.spmatrix) -> Any:
    """A SciPy matrix as CasADi's."""
    found = sp.csc_matrix(matrix)
    found.sort_indices()
    pattern = ca.Sparsity(found.shape[0], found.shape[1], found.indptr.tolist(), found.indices.tolist())
    return ca.DM(pattern, found.data)


def _blocks(pattern: Any, count: int) -> Any:
    """Block-diagonal pattern with ``count`` equal blocks."""
    return ca.diagcat(*([pattern] * count))


class Assembly:
    """CasADi functions of a whole program; the objective is scaled.

    Args:
        program: the program.
    """

    def __init__(self, program: Program) -> None:
        self.program = program
        self.x, self.p = ca.MX.sym("x", program.size), ca.MX.sym("p", 0)
        layout, count = program.functions.layout, program.points.count
        self._B, self._C, self._D = _sparse(program.inputs), _sparse(program.outputs), _sparse(program.linear)
        self._pivots, self._price = ca.DM(program.pivots), ca.DM(program.price)
        self._weight = ca.DM(program.points.weight * program.scale * float(program.torque_weight.min())).T
        self._z = ca.reshape(ca.mtimes(self._B, self.x), layout.inputs, count)
        self._S = _sparse(program.smooth)
        self._effort = ca.DM(np.outer(program.effort, program.points.weight * program.scale))
        self._o = program.functions.mapped("value", program.groups, self._z, self._pivots)[0]

    def _torque_slope(self, o: Any) -> Any:
        """D objective / d outputs, (outputs, K)."""
        layout, count = self.program.functions.layout, self.program.points.count
        rest = ca.MX(layout.outputs - layout.joints, count)
        torque = ca.vertcat(2 * ca.repmat(self._weight, layout.joints, 1) * o[: layout.joints, :], rest)
        rates = ca.mtimes(self._S.T, ca.mtimes(self._S, ca.vec(o)))
        return ca.densify(torque) + 2 * self.program.scale * ca.reshape(ca.densify(rates), layout.outputs, count)

    @cached_property
    def problem(self) -> dict[str, Any]:
        """Unknowns, objective and rows."""
        layout = self.program.functions.layout
        torque, rates = self._o[: layout.joints, :], ca.mtimes(self._S, ca.vec(self._o))
        f = ca.dot(ca.repmat(self._weight, layout.joints, 1) * torque, torque) + ca.dot(self._effort * self._z, self._z)
        f += self.program.scale * ca.dot(rates, rates) + ca.dot(self._price, self.x)
        return {"x": self.x, "f": f, "g": ca.mtimes(self._C, ca.vec(self._o)) + ca.mtimes(self._D, self.x)}

    def _jacobians(self) -> tuple[Any, Any]:
        """Outputs and their block-diagonal Jacobian."""
        fun, count = self.program.functions, self.program.points.count
        o, jac = fun.mapped("jacobian", self.program.groups, self._z, self._pivots)
        return o, ca.sparsity_cast(jac, _blocks(fun.pattern("jacobian"), count))

    def _slope(self, o: Any, J: Any) -> Any:
        """Gradient of the objective."""
        inner, outer = ca.vec(ca.densify(2 * self._effort * self._z)), ca.vec(self._torque_slope(o))
        return ca.mtimes(self._B.T, ca.mtimes(J.T, outer) + inner) + self._price

    @cached_property
    def gradient(self) -> Any:
        """(x, p) -> objective, gradient."""
        o, J = self._jacobians()
        return ca.Function("nlp_grad_f", [self.x, self.p], [self.problem["f"], self._slope(o, J)])

    @cached_property
    def jacobian(self) -> Any:
        """(x, p) -> rows, Jacobian of the rows."""
        o, J = self._jacobians()
        rows = ca.mtimes(self._C, ca.vec(o)) + ca.mtimes(self._D, self.x)
        return ca.Function("nlp_jac_g", [self.x, self.p], [rows, ca.mtimes(ca.mtimes(self._C, J), self._B) + self._D])

    @cached_property
    def hessian(self) -> Any:
        """(x, p, factor of the objective, multipliers) -> upper triangle of the Lagrangian's Hessian."""
        factor, multipliers = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", self.program.rows)
        found = ca.triu(self._lagrangian(factor, multipliers))
        return ca.Function("nlp_hess_l", [self.x, self.p, factor, multipliers], [found])

    def _lagrangian(self, factor: Any, multipliers: Any) -> Any:
        layout = self.program.functions.layout
        on_outputs = ca.reshape(ca.mtimes(self._C.T, multipliers), layout.outputs, self.program.points.count)
        return self._curvature(on_outputs + factor * self._torque_slope(self._o), factor)

    def _curvature(self, on_outputs: Any, factor: Any) -> Any:
        """BᵀHB for multipliers of the outputs (outputs, K) and a factor of the objective."""
        program, fun = self.program, self.program.functions
        count = program.points.count
        arguments = self._z, self._pivots, on_outputs, factor * self._weight
        (blocks,) = fun.mapped("hessian", program.groups, *arguments)
        H = ca.sparsity_cast(blocks, _blocks(fun.pattern("hessian"), count))
        effort = 2 * program.scale * np.outer(program.points.weight, program.effort).ravel()
        constant = _sparse(program.inputs.T @ sp.diags(effort) @ program.inputs)
        rates = ca.mtimes(ca.mtimes(self._S, self._jacobians()[1]), self._B)
        smooth = 2 * program.scale * ca.mtimes(rates.T, rates)
        return ca.mtimes(ca.mtimes(self._B.T, H), self._B) + factor * (constant + smooth)
