"""IPOPT behind one file: a program solved from a cold start, derivatives compiled per point and assembled sparsely."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt

from gaitsmith.files import ENDING
from gaitsmith.synthesis.program.assembly import Assembly
from gaitsmith.synthesis.program.program import Program

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Progress:
    """One iteration.

    Attributes:
        iteration: its number.
        objective: J.
        violation: of the worst row, as a share of ``span``.
        constraint: what that row says.
        unit: its unit.
        span: its range, in ``unit``.
    """

    iteration: int
    objective: float
    violation: float
    constraint: str = ""
    unit: str = ""
    span: float = 1.0


def progress_of(program: Program, iteration: int, objective: float, rows: Array) -> Progress:
    """Progress of an iteration from the values of the rows; ``objective`` is unscaled."""
    gaps = program.violation(rows)
    worst = int(np.argmax(gaps))
    label = program.labels[worst]
    return Progress(iteration, objective, float(gaps[worst]), label.name, label.unit, label.span)


@dataclass(frozen=True, eq=False)
class Solution:
    """What a solver found.

    Attributes:
        x: unknowns.
        solved: whether the optimality conditions hold to the tolerance.
        status: the solver's word for how it ended.
        iterations: of this solve.
        setup_s: time to build the problem, s.
        multipliers: of the rows; of bounds, those that are met.
        independent: which of the equalities may stand for all of them, in order; None where nobody looked.
    """

    x: Array
    solved: bool
    status: str
    iterations: int
    setup_s: float
    multipliers: Array
    independent: npt.NDArray[np.int64] | None = None


class _Watch(ca.Callback):
    """Reports iterations, and stops the solver on Ctrl-C."""

    def __init__(self, program: Program, report: Callable[[Progress], None] | None) -> None:
        ca.Callback.__init__(self)
        self.program, self.report = program, report
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

    def eval(self, arg: Any) -> list[Any]:
        self.iteration += 1
        if self.interrupted is not None:
            return [1]
        try:
            if self.report is not None:
                g = np.array(arg[ca.nlpsol_out().index("g")]).ravel()
                f = float(arg[ca.nlpsol_out().index("f")]) / self.program.scale
                self.report(progress_of(self.program, self.iteration, f, g))
        except BaseException as error:
            self.interrupted = error
            return [1]
        return [0]


@contextmanager
def _signals_kept(watch: _Watch) -> Iterator[None]:
    """Ctrl-C and the like end the solve at its next iteration: no exception leaves the engine half-way."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def note(*_: object) -> None:
        watch.interrupted = KeyboardInterrupt()

    before = {number: signal.getsignal(number) for number in ENDING}
    heard = [number for number in ENDING if callable(before[number])]
    for number in heard:
        signal.signal(number, note)
    try:
        yield
    finally:
        for number in heard:
            signal.signal(number, before[number])


def solve_ipopt(
    program: Program,
    start: Array,
    tolerance: float,
    max_iterations: int,
    report: Callable[[Progress], None] | None = None,
    options: dict[str, Any] | None = None,
) -> Solution:
    """Solve a program with IPOPT and MUMPS.

    Args:
        program: the program.
        start: unknowns to start from.
        tolerance: on optimality and on scaled rows.
        max_iterations: before it gives up.
        report: called at every iteration.
        options: further IPOPT options.

    Raises:
        KeyboardInterrupt: Ctrl-C during the solve.
    """
    begin = time.perf_counter()
    assembly = Assembly(program)
    watch = _Watch(program, report)
    ipopt: dict[str, Any] = {
        "print_level": 0,
        "sb": "yes",
        "tol": tolerance,
        "constr_viol_tol": tolerance,
        "acceptable_iter": 0,
        "max_iter": max_iterations,
        "mu_strategy": "adaptive",
        "alpha_for_y": "min-dual-infeas",
        "bound_push": 0.1,
        "bound_frac": 0.1,
        "slack_bound_push": 0.1,
        "slack_bound_frac": 0.1,
        "linear_solver": "mumps",
        "option_file_name": "",  # or a file ipopt.opt in the working folder would change every plan
        # The rows are scaled already; MUMPS's own scaling takes as long as its factorisation.
        "mumps_scaling": 0,
        "mumps_permuting_scaling": 0,
    } | (options or {})
    solver = ca.nlpsol(
        "solver",
        "ipopt",
        assembly.problem,
        {
            "grad_f": assembly.gradient,
            "jac_g": assembly.jacobian,
            "hess_lag": assembly.hessian,
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
    with _signals_kept(watch):
        result = solver(x0=start, lbg=program.low, ubg=program.high)
    stats = solver.stats()
    if watch.interrupted is not None:
        raise watch.interrupted
    return Solution(
        x=np.array(result["x"]).ravel(),
        solved=bool(stats["success"]),
        status=str(stats["return_status"]),
        iterations=int(stats["iter_count"]),
        setup_s=ready - begin,
        multipliers=_of_met(program, np.array(result["g"]).ravel(), np.array(result["lam_g"]).ravel()),
    )


def _of_met(program: Program, rows: Array, multipliers: Array) -> Array:
    """The multipliers that outweigh the distances of their bounds; an interior point leaves a trifle at all of them."""
    above, below = np.maximum(program.high - rows, 0.0), np.maximum(rows - program.low, 0.0)
    met = (program.high <= program.low) | (multipliers > above) | (-multipliers > below)
    return np.where(met, multipliers, 0.0)
