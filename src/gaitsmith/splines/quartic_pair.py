"""Two quartics joined C² at a via point: the curve of every coordinate of a leg's end (Han 2023, eqs. 1-6).

The paper calls it a cubic spline. It fixes position, velocity, and acceleration at both ends and the position at the
joint: ten conditions for ten coefficients. :func:`w_matrix` and :func:`coefficients` are the paper's equations to the
letter, for reading and for tests; :func:`evaluate_pair` is the same curve in closed form, for the control tick.

Closed form. With s = t / h₀ on the first section (h₀ = t₁) and σ = (t₂ - t) / h₁ on the second (h₁ = t₂ - t₁),

    κ = ζ₀ + V₀ s + ½ A₀ s² + (D₀ - c) s³ + c s⁴,    V₀ = h₀ v₀,  A₀ = h₀² ψ₀,  D₀ = ζ₁ - ζ₀ - V₀ - ½ A₀
    κ = ζ₂ - V₂ σ + ½ A₂ σ² + (D₁ - e) σ³ + e σ⁴,    V₂ = h₁ v₂,  A₂ = h₁² ψ₂,  D₁ = ζ₁ - ζ₂ + V₂ - ½ A₂

meet all end conditions; equal velocity and acceleration at t₁ give c = (S + h₀ P) / (h₁ t₂) and
e = (h₁ P - S) / (h₀ t₂) with P and S as in the code.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from gaitsmith.compiled import Vector, kernel
from gaitsmith.splines.polynomial import power_basis

Array = npt.NDArray[np.float64]


def time_vectors(t: float) -> Array:
    """Rows p(t), ṗ(t), p̈(t) of eq. 1: shape (3, 5), powers of t in s⁰..s⁴ and their derivatives."""
    return np.array([power_basis(4, t, derivative) for derivative in range(3)])


def w_matrix(t0: float, t1: float, t2: float) -> Array:
    """W(t0, t1, t2) of eqs. 2-4, shape (10, 10): what the ten coefficients must satisfy. Times in s, t0 < t1 < t2."""
    at_joint = time_vectors(t1)
    w = np.zeros((10, 10))
    w[0:4, 0:5] = np.vstack([time_vectors(t0), at_joint[0]])
    w[4:8, 5:10] = np.vstack([time_vectors(t2), at_joint[0]])
    w[8:10, 0:5] = at_joint[1:]
    w[8:10, 5:10] = -at_joint[1:]
    return w


def coefficients(t0: float, t1: float, t2: float, chi: Array) -> Array:
    """Coefficients ξ of eq. 5, shape (10,): five powers of t for [t0, t1], then five for [t1, t2].

    Args:
        t0: start, s.
        t1: joint, s.
        t2: end, s; t0 < t1 < t2.
        chi: (ζ₀, v₀, ψ₀, ζ₁, ζ₂, v₂, ψ₂, ζ₁, 0, 0): position, velocity, acceleration at the start, position at the
            joint, position, velocity, acceleration at the end, position at the joint, and the two jumps at the joint.
    """
    solved: Array = np.asarray(np.linalg.solve(w_matrix(t0, t1, t2), chi), dtype=np.float64)
    return solved


@kernel
def evaluate_pair(
    t: float,
    t1: float,
    t2: float,
    p0: float,
    v0: float,
    a0: float,
    p1: float,
    p2: float,
    v2: float,
    a2: float,
    out3: Vector,
) -> None:
    """Position, velocity, acceleration of the curve at time t (eq. 6 and its derivatives), for a start at time 0.

    Before the start the curve is taken at the start. After the end it holds p2 at rest (velocity and acceleration
    zero): a late touchdown must not carry the foot on.

    Args:
        t: time since the start, s.
        t1: time of the joint, s; 0 < t1 < t2.
        t2: time of the end, s.
        p0: position at the start.
        v0: velocity at the start, 1/s.
        a0: acceleration at the start, 1/s².
        p1: position at the joint.
        p2: position at the end.
        v2: velocity at the end, 1/s.
        a2: acceleration at the end, 1/s².
        out3: (3) receives position, velocity, acceleration.
    """
    if t > t2:
        out3[0], out3[1], out3[2] = p2, 0.0, 0.0
        return
    first, second = t1, t2 - t1
    start_velocity, start_acceleration = first * v0, 0.5 * first * first * a0
    end_velocity, end_acceleration = second * v2, 0.5 * second * second * a2
    start_gap = (p1 - p0) - start_velocity - start_acceleration
    end_gap = (p1 - p2) + end_velocity - end_acceleration
    speed = first * (end_velocity - 2.0 * end_acceleration - 3.0 * end_gap) - second * (
        start_velocity + 2.0 * start_acceleration + 3.0 * start_gap
    )
    bend = first * first * (end_acceleration / 3.0 + end_gap) - second * second * (start_acceleration / 3.0 + start_gap)
    if t < t1:
        s = max(t, 0.0) / first
        quartic = (bend + first * speed) / (second * t2)
        cubic = start_gap - quartic
        out3[0] = p0 + s * (start_velocity + s * (start_acceleration + s * (cubic + s * quartic)))
        out3[1] = (start_velocity + s * (2.0 * start_acceleration + s * (3.0 * cubic + s * 4.0 * quartic))) / first
        out3[2] = (2.0 * start_acceleration + s * (6.0 * cubic + s * 12.0 * quartic)) / (first * first)
    else:
        s = (t2 - t) / second
        quartic = (second * speed - bend) / (first * t2)
        cubic = end_gap - quartic
        out3[0] = p2 + s * (-end_velocity + s * (end_acceleration + s * (cubic + s * quartic)))
        out3[1] = (end_velocity - s * (2.0 * end_acceleration + s * (3.0 * cubic + s * 4.0 * quartic))) / second
        out3[2] = (2.0 * end_acceleration + s * (6.0 * cubic + s * 12.0 * quartic)) / (second * second)
