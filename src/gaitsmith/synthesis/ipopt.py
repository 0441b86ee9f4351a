"""IPOPT behind one file: a program solved from a cold start, derivatives compiled per point and assembled sparsely."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from gaitsmith.synthesis.program import OBJECTIVE_SCALE, Program

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Progress:
    """One iteration: number, objective J, largest violation of a row (share of its range)."""

    iteration: int
    objective: float
    violation: float


@dataclass(frozen=True, eq=False)
class Solution:
    """What a solver found.

    Attributes:
        x: unknowns.
        solved: whether the optimality conditions hold to the tolerance.
        status: the solver's word for how it ended.
        iterations: of this solve.
        setup_s: time to build the problem, s.
        solve_s: time to solve it, s.
        multipliers: of the rows.
    """

    x: Array
    solved: bool
    status: str
    iterations: int
    setup_s: float
    solve_s: float
    multipliers: Array


def _sparse(matrix: sp.spmatrix) -> Any:
    """A SciPy matrix as CasADi's."""
    found = sp.csc_matrix(matrix)
    found.sort_indices()
    pattern = ca.Sparsity(found.shape[0], found.shape[1], found.indptr.tolist(), found.indices.tolist())
    return ca.DM(pattern, found.data)


def _blocks(pattern: Any, count: int) -> Any:
    """Block-diagonal pattern with ``count`` equal blocks."""
    return ca.diagcat(*([pattern] * count))


def _functions(program: Program) -> tuple[Any, Any, Any, Any]:
    """The program itself and its gradient, Jacobian and Hessian as CasADi functions."""
    fun, layout, count = program.functions, program.functions.layout, program.points.count
    n = layout.joints
    x, p = ca.MX.sym("x", program.size), ca.MX.sym("p", 0)
    B, C, D = _sparse(program.inputs), _sparse(program.outputs), _sparse(program.linear)
    pivots = ca.DM(program.pivots)
    weight = ca.DM(program.points.weight * OBJECTIVE_SCALE).T
    z = ca.reshape(ca.mtimes(B, x), layout.inputs, count)
    o = fun.value.map(count)(z, pivots)
    torque, u = o[:n, :], z[layout.wrench :, :]
    f = ca.dot(ca.repmat(weight, n, 1) * torque, torque)
    f += program.wrench_weight * ca.dot(ca.repmat(weight, 6, 1) * u, u)
    g = ca.mtimes(C, ca.vec(o)) + ca.mtimes(D, x)
    o2, jac = fun.jacobian.map(count)(z, pivots)
    blocks = _blocks(fun.jacobian.sparsity_out(1), count)
    J = ca.sparsity_cast(jac, blocks)
    slope = ca.vertcat(2 * ca.repmat(weight, n, 1) * o2[:n, :], ca.MX(layout.outputs - n, count))
    zslope = ca.vertcat(ca.MX(layout.wrench, count), 2 * program.wrench_weight * ca.repmat(weight, 6, 1) * u)
    grad = ca.mtimes(B.T, ca.mtimes(J.T, ca.vec(ca.densify(slope))) + ca.vec(ca.densify(zslope)))
    g2 = ca.mtimes(C, ca.vec(o2)) + ca.mtimes(D, x)
    jac_g = ca.mtimes(ca.mtimes(C, J), B) + D
    lam_f, lam_g = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", program.rows)
    lam_o = ca.reshape(ca.mtimes(C.T, lam_g), layout.outputs, count)
    lam_o = lam_o + lam_f * ca.vertcat(2 * ca.repmat(weight, n, 1) * torque, ca.MX(layout.outputs - n, count))
    hess = fun.hessian.map(count)(z, pivots, lam_o, lam_f * weight)
    H = ca.sparsity_cast(hess, _blocks(fun.hessian.sparsity_out(0), count))
    u_part = np.zeros((layout.inputs, count))
    u_part[layout.wrench :, :] = 2 * program.wrench_weight * np.asarray(program.points.weight) * OBJECTIVE_SCALE
    constant = _sparse(program.inputs.T @ sp.diags(u_part.T.ravel()) @ program.inputs)
    full = ca.mtimes(ca.mtimes(B.T, H), B) + lam_f * constant
    return (
        {"x": x, "f": f, "g": g},
        ca.Function("nlp_grad_f", [x, p], [f, grad], ["x", "p"], ["f", "grad_f_x"]),
        ca.Function("nlp_jac_g", [x, p], [g2, jac_g], ["x", "p"], ["g", "jac_g_x"]),
        ca.Function("nlp_hess_l", [x, p, lam_f, lam_g], [ca.triu(full)], ["x", "p", "lam_f", "lam_g"], ["hess"]),
    )


class _Watch(ca.Callback):  # type: ignore[misc]
    """Reports iterations, and stops the solver at the time limit or on Ctrl-C."""

    def __init__(self, program: Program, report: Callable[[Progress], None] | None, deadline: float) -> None:
        ca.Callback.__init__(self)
        self.program, self.report, self.deadline = program, report, deadline
        self.interrupted: BaseException | None = None
        self.iteration = -1
        self.construct("watch", {})

    def get_n_in(self) -> int:
        return int(ca.nlpsol_n_out())

    def get_n_out(self) -> int:
        return 1

    def get_sparsity_in(self, i: int) -> Any:
        name = ca.nlpsol_out(i)
        if name == "f":
            return ca.Sparsity.scalar()
        if name in ("x", "lam_x"):
            return ca.Sparsity.dense(self.program.size)
        if name in ("g", "lam_g"):
            return ca.Sparsity.dense(self.program.rows)
        return ca.Sparsity(0, 0)

    def eval(self, arg: list[Any]) -> list[Any]:
        self.iteration += 1
        try:
            if self.report is not None:
                g = np.array(arg[ca.nlpsol_out().index("g")]).ravel()
                f = float(arg[ca.nlpsol_out().index("f")]) / OBJECTIVE_SCALE
                self.report(Progress(self.iteration, f, float(self.program.violation(g).max(initial=0.0))))
        except BaseException as error:
            self.interrupted = error
            return [1]
        return [1 if time.perf_counter() > self.deadline else 0]


def solve_ipopt(
    program: Program,
    start: Array,
    tolerance: float,
    max_iterations: int,
    time_limit: float,
    report: Callable[[Progress], None] | None = None,
    options: dict[str, Any] | None = None,
    multipliers: Array | None = None,
) -> Solution:
    """Solve a program with IPOPT and MUMPS.

    Args:
        program: the program.
        start: unknowns to start from.
        tolerance: on optimality and on scaled rows.
        max_iterations: before it gives up.
        time_limit: s.
        report: called at every iteration.
        options: further IPOPT options.
        multipliers: of the rows, for a warm start.

    Raises:
        KeyboardInterrupt: Ctrl-C during the solve.
    """
    begin = time.perf_counter()
    nlp, grad, jac, hess = _functions(program)
    watch = _Watch(program, report, begin + time_limit)
    ipopt = {
        "print_level": 0,
        "sb": "yes",
        "tol": tolerance,
        "constr_viol_tol": tolerance,
        "acceptable_iter": 0,
        "max_iter": max_iterations,
        "max_wall_time": time_limit,
        "mu_strategy": "adaptive",
        "linear_solver": "mumps",
    } | (options or {})
    solver = ca.nlpsol(
        "solver",
        "ipopt",
        nlp,
        {
            "grad_f": grad,
            "jac_g": jac,
            "hess_lag": hess,
            "ipopt": ipopt,
            "print_time": False,
            "no_nlp_grad": True,
            "calc_lam_p": False,
            "calc_f": False,
            "calc_g": False,
            "iteration_callback": watch,
            "error_on_fail": False,
        },
    )
    ready = time.perf_counter()
    given = {"x0": start, "lbg": program.low, "ubg": program.high}
    if multipliers is not None:
        given["lam_g0"] = multipliers
    result = solver(**given)
    stats = solver.stats()
    if watch.interrupted is not None:
        raise watch.interrupted
    return Solution(
        x=np.array(result["x"]).ravel(),
        solved=bool(stats["success"]),
        status=str(stats["return_status"]),
        iterations=int(stats["iter_count"]),
        setup_s=ready - begin,
        solve_s=time.perf_counter() - ready,
        multipliers=np.array(result["lam_g"]).ravel(),
    )
