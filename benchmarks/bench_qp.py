"""Time of one quadratic program of the size of the whole-body controller's: ours against DAQP, warm and cold.

``python benchmarks/bench_qp.py [--json] [--variables 13] [--rows 10] [--count 2000]``. The problems are a random walk,
as a controller's are from tick to tick. Times are of one call from Python and include its overhead.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable, Iterator

import daqp
import numpy as np
import numpy.typing as npt

from gaitsmith.compiled import Arena, bind, kernel
from gaitsmith.qp.quadratic_program import QuadraticProgram, make_quadratic_program, solve

Array = npt.NDArray[np.float64]
Problem = tuple[Array, Array, Array, Array, Array]


@kernel
def solve_bound(table: int) -> int:
    """Solve the problem in an arena; returns iterations, or -1 - status on failure."""
    status, iterations = solve(bind(QuadraticProgram, table), 500)
    return iterations if status == 0 else -1 - status


def walk(n: int, m: int, count: int, seed: int) -> Iterator[Problem]:
    """Hessian, gradient, rows, row limits (lower), bounds: torques and contact forces of a slowly changing task."""
    rng = np.random.default_rng(seed)
    weights = 10.0 ** rng.uniform(-1.0, 2.0, 2 * n)
    task, rows = rng.normal(size=(2 * n, n)), rng.normal(size=(m, n))
    aim = rng.normal(size=2 * n)
    for _ in range(count):
        task += 0.002 * rng.normal(size=task.shape)
        rows += 0.002 * rng.normal(size=rows.shape)
        aim += 0.02 * rng.normal(size=aim.shape) - 0.001 * aim
        hessian = task.T @ (weights[:, None] * task) + 1e-4 * np.eye(n)
        yield hessian, -task.T @ (weights * aim), rows.copy(), np.full(m, -0.3), np.full(n, 0.35)


def timed(call: Callable[[], object]) -> float:
    """Time of one call, µs."""
    start = time.perf_counter_ns()
    call()
    return 1e-3 * (time.perf_counter_ns() - start)


def measure(n: int, m: int, count: int) -> dict[str, dict[str, float]]:
    """Median and 99th percentile of every solver, µs, and the largest difference of their solutions.

    Each solver runs through all problems on its own, so that none finds its code evicted by another's.
    """
    arena = Arena(make_quadratic_program(n, m))
    qp, table = arena.view, arena.address
    problems = list(walk(n, m, count, seed=1))
    times: dict[str, list[float]] = {"warm, set kept": [], "warm, set changed": [], "cold": []}
    iterations, active, solutions = [], [], []
    for is_cold in (False, True):
        for hessian, gradient, rows, low, bound in problems:
            qp.hessian[:], qp.gradient[:], qp.rows[:], qp.row_lower[:] = hessian, gradient, rows, low
            qp.lower[:], qp.upper[:] = -bound, bound
            if is_cold:
                qp.active[:] = 0
            start = time.perf_counter_ns()
            steps = solve_bound(table)
            elapsed = 1e-3 * (time.perf_counter_ns() - start)
            times["cold" if is_cold else "warm, set changed" if steps else "warm, set kept"].append(elapsed)
            if is_cold:
                iterations.append(steps)
            else:
                solutions.append(qp.solution.copy())
                active.append(int(np.count_nonzero(qp.active)))
    difference = _measure_daqp(problems, solutions, times)
    result = {
        name: {"count": len(found), "median_us": float(np.median(found)), "p99_us": float(np.percentile(found, 99))}
        for name, found in times.items()
        if found
    }
    result["problem"] = {
        "variables": n,
        "rows": m,
        "active": float(np.mean(active)),
        "iterations_cold": float(np.mean(iterations)),
        "largest_difference": difference,
        "call_overhead_us": float(np.median([timed(lambda: noop(table)) for _ in range(1000)])),
    }
    return result


def _measure_daqp(problems: list[Problem], solutions: list[Array], times: dict[str, list[float]]) -> float:
    """Add DAQP's times; returns the largest difference from our solutions."""
    times["DAQP warm"], times["DAQP cold"] = [], []
    model, difference = daqp.Model(), 0.0
    sense = np.zeros(problems[0][1].size + problems[0][3].size, dtype=np.int32)
    for index, (hessian, gradient, rows, low, bound) in enumerate(problems):
        above, below = np.concatenate([bound, np.full(low.size, 1e30)]), np.concatenate([-bound, low])
        if index == 0:
            model.setup(hessian, gradient, rows, above, below, sense)
        start = time.perf_counter_ns()
        model.update(H=hessian, f=gradient, A=rows, bupper=above, blower=below)
        theirs = model.solve()[0]
        times["DAQP warm"].append(1e-3 * (time.perf_counter_ns() - start))
        difference = max(difference, float(np.max(np.abs(solutions[index] - theirs))))
    for hessian, gradient, rows, low, bound in problems:
        above, below = np.concatenate([bound, np.full(low.size, 1e30)]), np.concatenate([-bound, low])
        start = time.perf_counter_ns()
        daqp.solve(hessian, gradient, rows, above, below, sense)
        times["DAQP cold"].append(1e-3 * (time.perf_counter_ns() - start))
    return difference


@kernel
def noop(table: int) -> int:
    """What a call from Python costs without solving anything."""
    return table


def main() -> None:
    """Print the table, or one JSON document with ``--json``."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--variables", type=int, default=13)
    parser.add_argument("--rows", type=int, default=10)
    parser.add_argument("--count", type=int, default=2000)
    options = parser.parse_args()
    noop(0, 0)
    measure(options.variables, options.rows, 2)
    result = measure(options.variables, options.rows, options.count)
    if options.json:
        json.dump(result, sys.stdout, indent=2)
        sys.stdout.write("\n")
        return
    problem = result.pop("problem")
    sys.stdout.write("  ".join(f"{key} {value:.3g}" for key, value in problem.items()) + "\n")
    for name, row in result.items():
        sys.stdout.write(
            f"{name:20s} n {row['count']:5.0f}  median {row['median_us']:6.2f} µs  p99 {row['p99_us']:6.2f} µs\n"
        )


if __name__ == "__main__":
    main()
