"""What is told of a run of a plan: tilt in the planned torso's axes, turns of any size, soles that strike and leave."""

import math

import numpy as np
import pytest

from gaitsmith.compiled import Arena
from gaitsmith.simulation.plan_errors import OFF, PLANNED, REAL, STRIKE, compare_with_plan, make_plan_errors
from gaitsmith.whole_body.reference import FLAT, HEEL, NONE, TOE

EXACT = 1e-12


def turned(yaw, pitch=0.0, roll=0.0):
    """Rz Ry Rx."""
    (cz, sz), (cy, sy), (cx, sx) = ((math.cos(a), math.sin(a)) for a in (yaw, pitch, roll))
    z, y = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]]), np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    return z @ y @ np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])


class Run:
    """A run that the test writes tick by tick."""

    def __init__(self):
        shared = (np.eye(3), np.eye(3), np.full(2, FLAT), np.zeros(2))
        self._arena = Arena(make_plan_errors(*shared))
        self.found = self._arena.view

    def tick(self, real=None, planned=None, contact=(FLAT, FLAT), pitch=(0.0, 0.0)):
        self.found.real[:], self.found.planned[:] = (np.eye(3) if r is None else r for r in (real, planned))
        self.found.contact[:], self.found.sole_pitch[:] = contact, pitch
        compare_with_plan(self._arena.address)


def test_tilt_is_the_largest_one_in_the_planned_torsos_axes():
    run = Run()
    for roll, pitch in ((0.02, 0.0), (-0.05, 0.01), (0.03, -0.04), (0.0, 0.02)):
        for yaw in (0.0, 2.5):
            plan = turned(yaw, 0.3)
            run.tick(plan @ turned(0.0, pitch, roll), plan)
    np.testing.assert_allclose(run.found.tilt, [0.05, 0.04], atol=1e-4)


def test_a_tilt_that_is_no_number_stays_one():
    run = Run()
    run.tick(np.full((3, 3), np.nan))
    run.tick()
    assert np.isnan(run.found.tilt).all()


def test_turns_add_up_beyond_a_whole_one_either_way():
    run = Run()
    for k in range(101):
        run.tick(turned(0.3 + 0.1 * k), turned(-0.2 * k))
    assert run.found.turn[REAL] == pytest.approx(10.0, abs=EXACT)
    assert run.found.turn[PLANNED] == pytest.approx(-20.0, abs=EXACT)


def test_strikes_and_toe_offs_are_counted_and_flat_landings_are_not():
    run = Run()
    kinds = (
        (NONE, FLAT),
        (HEEL, FLAT),
        (FLAT, TOE),
        (FLAT, NONE),
        (FLAT, FLAT),
        (TOE, FLAT),
        (NONE, FLAT),
        (TOE, FLAT),
    )
    for kind, pitch in zip(kinds, (0.0, -0.11, 0.2, 0.25, 0.01, 0.3, 0.35, -0.07), strict=True):
        run.tick(contact=kind, pitch=(pitch, pitch))
    np.testing.assert_allclose(run.found.pitch[STRIKE], [0.11 + 0.07, 2], atol=EXACT)  # toe up positive
    np.testing.assert_allclose(run.found.pitch[OFF], [0.25 + 0.35, 2], atol=EXACT)  # toe down positive


def test_the_first_tick_is_no_event():
    run = Run()
    run.tick(contact=(HEEL, NONE), pitch=(0.3, 0.3))
    assert not run.found.pitch.any()
    assert not run.found.turn.any()
