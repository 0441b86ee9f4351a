"""Taylor models enclose: at any time, sums, products, sines lie within the radius of the polynomial."""

import numpy as np
import pytest
from flint import arb, ctx
from hypothesis import given
from hypothesis import strategies as st

from gaitsmith.synthesis.proof.ranges import bernstein, suprema
from gaitsmith.synthesis.proof.taylor import DEGREE, Taylor, cross, matmul, sine_cosine

COUNT = 3  # stretches


def models(seed, *shape, size=1.0):
    rng = np.random.default_rng(seed)
    shrink = (0.3 ** np.arange(6)).reshape(-1, *(1,) * (len(shape) + 1))
    coefficients = np.zeros((DEGREE + 1, *shape, COUNT))
    coefficients[:6] = size * rng.normal(size=(6, *shape, COUNT)) * shrink
    return Taylor(coefficients, np.zeros((*shape, COUNT)))


def at(model, s, place):
    """A model's polynomial at a time, as an exact ball, and the ball that it stands for."""
    found = arb(0)
    for coefficient in model.c[(slice(None), *place)][::-1]:
        found = found * arb(float(s)) + arb(float(coefficient))
    return found, found + arb(0, float(model.r[place]))


@given(st.integers(0, 10**6), st.floats(-1.0, 1.0))
def test_products_and_sines_lie_within_their_radii(seed, s):
    ctx.prec = 200
    one, two = models(seed, 2), models(seed + 1, 2)
    product, (sine, cosine) = one * two - two * 0.5 + 1.5, sine_cosine(one)
    for place in np.ndindex(2, COUNT):
        a, b = at(one, s, place)[0], at(two, s, place)[0]
        for model, value in ((product, a * b - b / 2 + arb(1.5)), (sine, a.sin()), (cosine, a.cos())):
            assert at(model, s, place)[1].contains(value)


@given(st.integers(0, 10**6))
def test_radii_grow_by_what_they_stand_for(seed):
    """A model with a radius stands for the others within it: whatever is done to these stays inside."""
    ctx.prec = 200
    one, two = models(seed, 3), models(seed + 1, 3)
    wide = Taylor(one.c, one.r + 1e-3)
    moved = Taylor(one.c + 0.0, one.r)
    moved.c[0] += 0.9e-3
    for wider, within in ((cross(wide, two), cross(moved, two)), (sine_cosine(wide)[0], sine_cosine(moved)[0])):
        for place in np.ndindex(3, COUNT):
            assert at(wider, 0.3, place)[1].contains(at(within, 0.3, place)[0])


def test_matrices_multiply_as_numpy_does():
    one, two = models(1, 3, 3), models(2, 3, 3)
    found = matmul(one, two)
    for k in range(COUNT):
        assert np.allclose(found.c[0, ..., k], one.c[0, ..., k] @ two.c[0, ..., k])


def test_of_large_or_fast_angles_is_known_what_is_known_of_any():
    fast = models(0, 1, size=30.0)
    for angle in (Taylor.constant(np.array([11.0]), COUNT), fast):
        for found in sine_cosine(angle):
            assert (np.abs(found.c[0]) - found.r <= -1.0 + 1e-9).all()
            assert (found.r >= 1.0).all()


@given(st.integers(0, 10**6))
def test_the_largest_value_is_found(seed):
    model = models(seed, 4)
    group = np.array([0, 0, 1, 2])
    best = suprema(model.c, model.r, group, 3, 1e-7, 0.0)
    times = np.linspace(-1.0, 1.0, 2001)
    values = np.einsum("kmn,kt->mnt", model.c, times ** np.arange(DEGREE + 1)[:, None])
    for k in range(3):
        real = values[group == k].max()
        assert real - 1e-12 <= best.most[k]
        assert best.most[k] - best.least[k] < 2e-7
        assert best.least[k] <= real + 1e-5
        assert values[group == k][:, best.stretch[k]].max() >= real - 1e-6
    low, high = bernstein(model)
    assert (low <= values.min(axis=2) + 1e-12).all()
    assert (high >= values.max(axis=2) - 1e-12).all()


def test_what_is_not_finite_is_never_below_a_limit():
    model = Taylor.constant(np.array([-1.0]), 1)
    for broken in (Taylor(model.c * np.nan, model.r), Taylor(model.c, model.r + np.inf)):
        assert suprema(broken.c, broken.r, np.array([0]), 1, 1e-6, 0.0).most[0] == np.inf


@pytest.mark.parametrize("start", [0.0, -3.0, 9.9])
def test_a_function_that_starts_at_its_limit_is_decided(start):
    """s² times a negative number: 0 at an end, below it elsewhere."""
    c = np.zeros((DEGREE + 1, 1, 1))
    c[:3, 0, 0] = -1.0, -2.0, -1.0
    best = suprema(c * (1.0 + abs(start)), np.zeros((1, 1)), np.array([0]), 1, 1e-6, 1e-9)
    assert best.most[0] <= 1e-9
