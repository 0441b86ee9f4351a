"""SLSQP, a stand-in for the paper's fmincon, on the same transcription as IPOPT: one static cyclic gait.

OMP_NUM_THREADS=1 python benchmarks/slsqp.py [seconds]
"""

import sys
import time

import numpy as np
from scipy.optimize import minimize

from gaitsmith.robots import load_robot
from gaitsmith.synthesis import Planner, Settings, StepParameters
from gaitsmith.synthesis.motions.catalogue import cyclic
from gaitsmith.synthesis.program.derivatives import Derivatives
from gaitsmith.synthesis.program.guess import default_start
from gaitsmith.synthesis.program.program import make_program
from gaitsmith.synthesis.program.transcription import Transcription
from gaitsmith.synthesis.solution.ipopt import solve_ipopt


class OutOfTime(Exception):
    """The time given to SLSQP is over."""


def main(limit: float) -> None:
    planner = Planner(load_robot("thbip_ii"), print)
    trans = Transcription(planner.biped, cyclic(planner.biped, StepParameters(0.15, 1.0)), Settings())
    program = make_program(trans, planner.functions, trans.points())
    start = default_start(trans)
    begin = time.process_time()
    ours = solve_ipopt(program, start, 1e-6, 400)
    spent = time.process_time() - begin
    z, o = program.evaluate(ours.x)
    print(f"{program.size} unknowns, {program.rows} rows, all bounds at all points")
    print(f"IPOPT: {ours.status}, {ours.iterations} iterations, {spent:.2f} s CPU, J = {program.objective(z, o):.2f}")

    slopes = Derivatives(program)
    equal = program.high == program.low
    below, above = ~equal & np.isfinite(program.low), ~equal & np.isfinite(program.high)
    last: dict[str, np.ndarray] = {}
    count = 0

    def derivatives(x: np.ndarray) -> dict[str, np.ndarray]:
        nonlocal count
        if "x" not in last or not np.array_equal(last["x"], x):
            if time.process_time() - begin > limit:
                raise OutOfTime
            gradient, rows, jacobian = slopes.first_order(x)
            last.update(x=x.copy(), gradient=gradient, rows=rows, jacobian=jacobian.toarray())
            count += 1
        return last

    def objective(x: np.ndarray) -> float:
        z, o = program.evaluate(x)
        return program.scale * program.objective(z, o)

    constraints = [
        {
            "type": "eq",
            "fun": lambda x: (derivatives(x)["rows"] - program.low)[equal],
            "jac": lambda x: derivatives(x)["jacobian"][equal],
        },
        {
            "type": "ineq",
            "fun": lambda x: np.concatenate(
                [(derivatives(x)["rows"] - program.low)[below], (program.high - derivatives(x)["rows"])[above]]
            ),
            "jac": lambda x: np.concatenate([derivatives(x)["jacobian"][below], -derivatives(x)["jacobian"][above]]),
        },
    ]
    begin = time.process_time()
    try:
        found = minimize(
            objective,
            start,
            jac=lambda x: derivatives(x)["gradient"],
            constraints=constraints,
            method="SLSQP",
            options={"maxiter": 500, "ftol": 1e-8},
        )
        ending, x = found.message, found.x
    except OutOfTime:
        ending, x = f"stopped after {limit:.0f} s", last["x"]
    z, o = program.evaluate(x)
    violation = program.violation(program.constraint(x, o)).max()
    spent = time.process_time() - begin
    print(f"SLSQP: {ending}, {count} evaluations, {spent:.1f} s CPU")
    print(f"       J = {program.objective(z, o):.2f}, worst violation {violation:.1e} of a range")


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 300.0)
