"""Pushes deliver their impulse, at their time or phase, whatever else happens."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitsmith.errors import BadInput
from gaitsmith.robots import load_robot
from gaitsmith.simulation.disturbances import Push, Pushes, StrideClock, crossed
from gaitsmith.simulation.plant import Plant

DT = 1e-3
EXACT = 1e-9


class Body:
    """Integrates the force that is set on it."""

    def __init__(self):
        self.force = {}
        self.impulse = np.zeros(3)

    def push(self, force, body=None, joint=None):
        self.force[body, joint] = np.array(force, dtype=float)

    def advance(self):
        for force in self.force.values():
            self.impulse += force * DT


def _run(pushes, ticks, phase=lambda t: math.nan):
    body = Body()
    applied = Pushes(tuple(pushes), body, DT)
    for k in range(ticks):
        applied.apply(k * DT, phase(k * DT))
        body.advance()
    return body, applied


impulses = st.tuples(*(st.floats(-100, 100) for _ in range(3)))


@given(st.lists(st.builds(Push, time=st.floats(0, 0.5), impulse=impulses, duration=st.floats(1e-3, 0.3)), max_size=4))
def test_overlapping_pushes_deliver_the_sum_of_their_impulses(pushes):
    body, applied = _run(pushes, 900)
    assert applied.done
    np.testing.assert_allclose(body.impulse, np.sum([p.impulse for p in pushes] or [np.zeros(3)], axis=0), atol=1e-7)


def test_a_push_is_rectangular_and_starts_on_time():
    body = Body()
    pushes = Pushes((Push(time=0.02, impulse=(15.0, 0.0, 0.0)),), body, DT)
    trace = []
    for k in range(200):
        pushes.apply(k * DT, math.nan)
        trace.append(body.force.get((None, None), np.zeros(3))[0])
    assert np.count_nonzero(trace) == 100
    assert set(trace) == {0.0, 150.0}
    assert trace.index(150.0) == 20
    assert pushes.started == [0.02]


@given(st.integers(0, 11), st.floats(0.3, 0.9))
def test_a_phased_push_starts_at_its_phase_after_its_time(twelfth, stride):
    phase = twelfth / 12
    _, applied = _run([Push(time=1.0, impulse=(1.0, 0.0, 0.0), phase=phase)], 2500, lambda t: (t / stride) % 1.0)
    began = applied.started[0]
    late = ((began / stride) % 1.0 - phase) % 1.0
    assert 1.0 <= began <= 1.0 + stride + 2 * DT
    assert late <= DT / stride + EXACT


@given(st.floats(0, 0.999), st.floats(0, 0.999), st.floats(0, 0.7))
def test_crossing_agrees_with_unwrapping(phase, before, travelled):
    unwrapped = phase if phase > before else phase + 1.0
    margin = abs(unwrapped - before - travelled)
    if margin > 1e-9 and abs(phase - before) > 1e-9:
        assert crossed(phase, before, (before + travelled) % 1.0) == (unwrapped <= before + travelled)


def test_no_phase_no_push():
    _, applied = _run([Push(time=0.0, impulse=(1.0, 0.0, 0.0), phase=0.3)], 500)
    assert math.isnan(applied.started[0])
    assert not applied.done


def test_the_clock_measures_steps_as_they_are():
    clock, seen = StrideClock(), {}
    duration, began, count = 0.36, 0.0, 0
    for k in range(2000):
        t = k * DT
        if t - began >= duration - EXACT:
            began, count = t, count + 1
        seen[k] = (clock.phase(t, True, count % 2, t - began, count, 0.4), count, t - began)
    for phase, count, into in list(seen.values())[800:]:
        expected = 0.5 * (count % 2) + 0.5 * min(into / duration, 1.0)
        assert phase == pytest.approx(expected, abs=1e-6)
    assert math.isnan(clock.phase(2.0, False, 2, 0.0, count, 0.4))


def test_a_step_that_begins_on_both_feet_has_phases_from_its_beginning():
    clock, seen = StrideClock(), []
    for k in range(2000):
        step, time = divmod(k, 500)
        stance = 2 if time < 150 and step else step % 2
        seen.append(clock.phase(k * DT, True, stance, time * DT, step, 0.5))
    np.testing.assert_allclose(seen, [0.5 * (k / 500) % 1.0 for k in range(2000)], atol=EXACT)
    assert math.isnan(clock.phase(2.0, False, 2, 0.0, 4, 0.5))
    assert math.isnan(clock.phase(2.1, True, 2, 0.0, 4, 0.5))


def test_a_step_without_a_posture_and_a_push_without_a_force_are_refused() -> None:
    plant = Plant(load_robot("bhr_b2"))
    with pytest.raises(BadInput, match=r"plant: .* call reset\(q\) first"):
        plant.step(np.zeros(8))
    for force in ((1.0, 2.0), (0.0, math.nan, 0.0)):
        with pytest.raises(BadInput, match=r"push\.force"):
            plant.push(force)
