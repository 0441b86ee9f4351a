"""The closed form is the paper's W matrix solution, meets its end conditions, and stays accurate for short periods."""

from fractions import Fraction

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from gaitsmith.splines.polynomial import power_basis
from gaitsmith.splines.quartic_pair import evaluate_pair

Array = npt.NDArray[np.float64]

RELATIVE = 1e-12  # closed form against exact rational arithmetic: a few dozen roundings
W_ROUNDING = 1e-10  # W solved in doubles, at periods of about 1 s where its condition number is about 1e5
STEP = 1e-5  # s, central differences: truncation and rounding balance near 1e-9
DIFFERENCE = 1e-6

values = st.floats(-2.0, 2.0)
shares = st.floats(0.2, 0.8)
periods = st.floats(0.2, 1.5)
ends = st.tuples(values, values, values, values, values, values, values)


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


def curve(t: float, t1: float, t2: float, end: tuple[float, ...]) -> Array:
    """Position, velocity, acceleration by the kernel; ``end`` is (p0, v0, a0, p1, p2, v2, a2)."""
    out = np.full(3, np.nan)
    p0, v0, a0, p1, p2, v2, a2 = end
    evaluate_pair(t, t1, t2, p0, v0, a0, p1, p2, v2, a2, out)
    return out


def chi_of(end: tuple[float, ...]) -> Array:
    """The paper's χ from (p0, v0, a0, p1, p2, v2, a2)."""
    p0, v0, a0, p1, p2, v2, a2 = end
    return np.array([p0, v0, a0, p1, p2, v2, a2, p1, 0.0, 0.0])


def by_w(t: float, t1: float, t2: float, end: tuple[float, ...]) -> Array:
    """Eq. 6 and its derivatives through the W matrix."""
    xi = coefficients(0.0, t1, t2, chi_of(end))
    value: Array = time_vectors(t) @ (xi[:5] if t < t1 else xi[5:])
    return value


def exactly(t: float, t1: float, t2: float, end: tuple[float, ...]) -> Array:
    """The W matrix solution in rational arithmetic: the inputs' doubles are exact, so is everything after them."""

    def basis(x: Fraction) -> list[list[Fraction]]:
        one, two = Fraction(1), Fraction(2)
        return [
            [one, x, x**2, x**3, x**4],
            [0 * one, one, two * x, 3 * x**2, 4 * x**3],
            [0 * one, 0 * one, two, 6 * x, 12 * x**2],
        ]

    zero = [Fraction(0)] * 5
    start, joint, finish = (basis(Fraction(x)) for x in (0.0, t1, t2))
    rows = [r + zero for r in start] + [joint[0] + zero] + [zero + r for r in finish] + [zero + joint[0]]
    rows += [r + [-x for x in r] for r in joint[1:]]
    system = [[*row, Fraction(x)] for row, x in zip(rows, chi_of(end).tolist(), strict=True)]
    for i in range(10):
        pivot = next(k for k in range(i, 10) if system[k][i] != 0)
        system[i], system[pivot] = system[pivot], system[i]
        system[i] = [x / system[i][i] for x in system[i]]
        for k in range(10):
            if k != i and system[k][i] != 0:
                share = system[k][i]
                system[k] = [a - share * b for a, b in zip(system[k], system[i], strict=True)]
    xi = [row[10] for row in system]
    part = xi[:5] if t < t1 else xi[5:]
    return np.array([float(sum(a * b for a, b in zip(row, part, strict=True))) for row in basis(Fraction(t))])


def scales(t1: float, t2: float, end: tuple[float, ...]) -> Array:
    """Size of the terms that make up position, velocity, acceleration: what rounding is relative to."""
    p0, v0, a0, p1, p2, v2, a2 = np.abs(end)
    shortest = min(t1, t2 - t1)
    size = p0 + p1 + p2 + t2 * (v0 + v2) + t2 * t2 * (a0 + a2)
    size *= (t2 / shortest) ** 2
    return np.array([size, size / shortest, size / shortest**2]) + 1e-300


@given(ends, periods, shares, st.floats(0.0, 1.0))
def test_closed_form_is_the_w_matrix_solution(end: tuple[float, ...], period: float, share: float, at: float) -> None:
    """Both evaluate the same curve; W's own conditioning is the looser of the two."""
    t1, t = share * period, at * period
    error = np.abs(curve(t, t1, period, end) - by_w(t, t1, period, end))
    assert np.all(error <= W_ROUNDING * scales(t1, period, end))


@pytest.mark.parametrize("period", [1e-3, 0.02, 0.4, 3.0])
@pytest.mark.parametrize("share", [0.1, 0.5, 0.83])
def test_closed_form_against_exact_arithmetic(period: float, share: float) -> None:
    """To 1e-12 relative at every period, where W solved in doubles loses digits as the period shrinks."""
    end = (0.1, -0.4, 2.0, 0.25, -0.3, 0.7, -1.0)
    for at in (0.0, 0.3 * share, share, 0.5 * (1.0 + share), 1.0):
        exact = exactly(at * period, share * period, period, end)
        size = scales(share * period, period, end)
        assert np.all(np.abs(curve(at * period, share * period, period, end) - exact) <= RELATIVE * size)


def test_closed_form_beats_inverting_w_for_short_periods() -> None:
    """W's condition number grows like T⁻⁴: at 1 ms its solution is far less accurate than the closed form."""
    end = (0.1, -0.4, 2.0, 0.25, -0.3, 0.7, -1.0)
    conditions, ratios = [], []
    for period in (1.0, 0.1, 0.01, 0.001):
        t1, t = 0.5 * period, 0.3 * period
        exact = exactly(t, t1, period, end)
        ours = np.max(np.abs((curve(t, t1, period, end) - exact) / exact))
        theirs = np.max(
            np.abs((time_vectors(t) @ (np.linalg.inv(w_matrix(0.0, t1, period)) @ chi_of(end))[:5]) / exact - 1)
        )
        conditions.append(np.linalg.cond(w_matrix(0.0, t1, period)))
        ratios.append(theirs / max(ours, 1e-16))
    assert conditions[0] < 1e6
    assert conditions[-1] > 1e12
    assert ratios[-1] > 10.0


@given(ends, periods, shares)
def test_end_conditions_and_joint(end: tuple[float, ...], period: float, share: float) -> None:
    """Start and end states, the via point, and no jump of position, velocity, or acceleration at the joint."""
    t1 = share * period
    p0, v0, a0, p1, p2, v2, a2 = end
    size = RELATIVE * scales(t1, period, end)
    assert np.all(np.abs(curve(0.0, t1, period, end) - (p0, v0, a0)) <= size)
    assert np.all(np.abs(curve(period, t1, period, end) - (p2, v2, a2)) <= size)
    before, after = curve(np.nextafter(t1, 0.0), t1, period, end), curve(t1, t1, period, end)
    assert abs(after[0] - p1) <= size[0]
    assert np.all(np.abs(after - before) <= 100.0 * size)


@given(ends, periods, shares, st.floats(0.05, 0.95))
def test_derivatives_by_finite_differences(end: tuple[float, ...], period: float, share: float, at: float) -> None:
    """Velocity and acceleration are the derivatives of position and velocity."""
    t1, t = share * period, at * period
    assume(abs(t - t1) > 2.0 * STEP)  # the third derivative jumps there
    high, low = curve(t + STEP, t1, period, end), curve(t - STEP, t1, period, end)
    slope = (high[:2] - low[:2]) / (2.0 * STEP)
    size = scales(t1, period, end)
    assert np.all(np.abs(slope - curve(t, t1, period, end)[1:]) <= DIFFERENCE * size[1:])


@given(ends, periods, shares, st.floats(0.0, 1.0), st.floats(0.1, 10.0), st.floats(-3.0, 3.0))
def test_scaling_laws(
    end: tuple[float, ...], period: float, share: float, at: float, stretch: float, gain: float
) -> None:
    """Time stretched by k divides velocity by k and acceleration by k²; the curve is linear in its conditions."""
    t1, t = share * period, at * period
    p0, v0, a0, p1, p2, v2, a2 = end
    size = RELATIVE * scales(t1, period, end)
    slow = curve(
        stretch * t,
        stretch * t1,
        stretch * period,
        (p0, v0 / stretch, a0 / stretch**2, p1, p2, v2 / stretch, a2 / stretch**2),
    )
    plain = curve(t, t1, period, end)
    if min(abs(at - share), 1.0 - at) > 1e-9:
        assert np.all(np.abs(slow * [1.0, stretch, stretch**2] - plain) <= 10.0 * size)
    scaled = curve(t, t1, period, tuple(gain * x for x in end))
    assert np.all(np.abs(scaled - gain * plain) <= (1.0 + abs(gain)) * size)


@given(ends, periods, shares)
def test_outside_the_interval(end: tuple[float, ...], period: float, share: float) -> None:
    """The start state before the start; the end position at rest after the end."""
    t1 = share * period
    np.testing.assert_array_equal(curve(-0.1, t1, period, end), curve(0.0, t1, period, end))
    np.testing.assert_array_equal(curve(period + 1e-9, t1, period, end), [end[4], 0.0, 0.0])
