"""Storage of a small dense quadratic program: the problem, its solution, and the scratch of the solver."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import Cube, IntMatrix, IntVector, Matrix, Vector
from gaitsmith.compiled.lanes import storage
from gaitsmith.errors import BadInput

OPTIMAL = 0
INFEASIBLE = 1
ITERATION_LIMIT = 2
NOT_CONVEX = 3
NOT_FINITE = 4

# Scaled units: variable i is measured in 1 / sqrt(H_ii), constraint k in the norm of its scaled normal. Rounding
# in a problem with a condition number of 1e10 stays below PRIMAL_TOLERANCE; DEPENDENT is the sine of an angle.
PRIMAL_TOLERANCE = 1e-10
DUAL_TOLERANCE = 1e-10
SIGN_TOLERANCE = 1e-14  # a multiplier of the wrong sign moves x by far more where the cost is weak
DEPENDENT = 1e-9
INFEASIBLE_TOLERANCE = 1e-7

MAX_VARIABLES = 1000

# Rows of ``vectors``. The guess and the dual method share some: neither keeps anything there for the other.
METRIC, LOW, HIGH, INVERSE, FULL = 0, 1, 2, 3, 4
SLOPE, GAP, STEP, FORCE = 5, 6, 7, 8
NORMAL, MULTIPLIER, SIDE = 9, 10, 11
KEPT_SOLUTION, KEPT_MULTIPLIERS, PIVOT = 12, 13, 14


class QuadraticProgram(NamedTuple):
    """minimise ½ xᵀH x + gᵀx subject to lower ≤ x ≤ upper and row_lower ≤ A x ≤ row_upper.

    The storage holds n variables and m rows; a solve uses the leading ``size[0]`` variables and ``size[1]`` rows.
    Constraint k < n is the bound on x[k]; constraint n + j is row j (n of the storage, not of the solve).

    Attributes:
        hessian: H (n, n), symmetric positive definite; both triangles are read.
        gradient: g (n).
        rows: A (m, n).
        span: (m, 2) columns of each row, from and to before, outside which it is zero.
        row_lower: (m), -inf where there is none; equal to row_upper for an equality.
        row_upper: (m), +inf where there is none.
        lower: (n), -inf where there is none; equal to upper for a fixed variable.
        upper: (n), +inf where there is none.
        solution: x (n), result.
        multipliers: y (n + m), result: H x + g = [I; A]ᵀ y; y > 0 holds a lower limit, y < 0 an upper one.
        active: (n + m), result and warm start of the next solve: -1 at the lower limit, +1 at the upper, 0 free.
            A fixed variable or an equality row is marked by the sign of its multiplier. Zeros are a cold start.
        size: (2), variables and rows in use.
        squares: scratch (3, n, 2 n + 1) with padded columns: Cholesky factor and what is eliminated with it, basis,
            triangle.
        vectors: scratch (15, n + m) with padded columns, rows named above.
        indices: scratch (3, n + m).
        gram: scratch (m, n + 1) with padded columns.
        schur: scratch (m, m).
    """

    hessian: Matrix
    gradient: Vector
    rows: Matrix
    span: IntMatrix
    row_lower: Vector
    row_upper: Vector
    lower: Vector
    upper: Vector
    solution: Vector
    multipliers: Vector
    active: IntVector
    size: IntVector
    squares: Cube
    vectors: Matrix
    indices: IntMatrix
    gram: Matrix
    schur: Matrix


def make_quadratic_program(n: int, m: int) -> QuadraticProgram:
    """An empty problem with n variables and m rows: H = I, g = 0, no limits, all of it in use.

    Raises:
        BadInput: n is not in 1..1000 or m is not in 0..1000.
    """
    if not 1 <= n <= MAX_VARIABLES:
        raise BadInput("n", n, f"1 to {MAX_VARIABLES} variables")
    if not 0 <= m <= MAX_VARIABLES:
        raise BadInput("m", m, f"0 to {MAX_VARIABLES} rows")
    return QuadraticProgram(
        hessian=np.eye(n),
        gradient=np.zeros(n),
        rows=np.zeros((m, n)),
        span=np.tile(np.array([0, n], dtype=np.int64), (m, 1)),
        row_lower=np.full(m, -np.inf),
        row_upper=np.full(m, np.inf),
        lower=np.full(n, -np.inf),
        upper=np.full(n, np.inf),
        solution=np.zeros(n),
        multipliers=np.zeros(n + m),
        active=np.zeros(n + m, dtype=np.int64),
        size=np.array([n, m], dtype=np.int64),
        squares=storage(3, n, 2 * n + 1),
        vectors=storage(15, n + m),
        indices=np.zeros((3, n + m), dtype=np.int64),
        gram=storage(m, n + 1),
        schur=np.zeros((m, m)),
    )
