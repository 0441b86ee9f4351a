"""The heading is held where the robot stands, and turned by the commanded rate while it walks."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.control.walking import DT, Held

from gaitsmith.template.phase import within_turn


@given(st.floats(-100.0, 100.0))
def test_within_turn_is_the_same_angle(angle: float) -> None:
    found = within_turn(angle)
    assert -math.pi <= found <= math.pi
    assert math.cos(found) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(found) == pytest.approx(math.sin(angle), abs=1e-9)


def turned(held: Held, yaw: float) -> Held:
    """The same robot with another yaw."""
    held.q[3:7] = math.cos(0.5 * yaw), 0.0, 0.0, math.sin(0.5 * yaw)
    return held


def wanted_yaw(held: Held) -> float:
    """Yaw of the torso's reference, rad."""
    rotation = held.groups.reference.torso_rotation
    return math.atan2(rotation[1, 0], rotation[0, 0])


def test_the_first_heading_is_the_robots_own() -> None:
    held = turned(Held("thbip_ii"), 2.0)
    held.tick()
    assert held.controller.telemetry.heading[0] == pytest.approx(2.0)


def test_standing_holds_the_heading() -> None:
    """Whatever turn is commanded; a robot that is turned away is drawn back, by half a radian at most."""
    held = Held("thbip_ii")
    held.controller.command(yaw_rate=0.5)
    for _ in range(200):
        held.tick()
    assert held.controller.telemetry.heading[0] == pytest.approx(0.0)
    yaw, rate = 0.0, 4.0
    for goal, expected in ((0.2, 0.0), (2.0, 1.5), (-2.0, -1.5)):
        held.v[5] = math.copysign(rate, goal - yaw)
        while abs(goal - yaw) > 0.5 * rate * DT:
            yaw += held.v[5] * DT
            turned(held, yaw).tick()
        assert wanted_yaw(held) == pytest.approx(expected)


@pytest.mark.parametrize("rate", [-0.5, 0.3])
def test_walking_turns_the_heading_by_the_rate(rate: float) -> None:
    held = Held("thbip_ii")
    held.controller.command(yaw_rate=rate)
    held.tick()
    held.controller.walk()
    held.stance_only()
    start = held.controller.telemetry.heading[0]
    for _ in range(100):
        held.stance_only()
    assert held.controller.telemetry.heading[0] - start == pytest.approx(100 * rate * DT)
    assert held.groups.reference.torso_spin[2] == rate  # so that the torso does not lag behind


def test_the_heading_passes_through_half_a_turn() -> None:
    """A robot that looks backwards is not turned the long way round."""
    held = turned(Held("thbip_ii"), math.pi - 1e-3)
    held.tick()
    turned(held, -math.pi + 1e-3).tick()
    away = within_turn(wanted_yaw(held) - (-math.pi + 1e-3))
    assert away == pytest.approx(-2e-3, abs=1e-6)


def test_legs_that_cannot_turn_have_no_heading_task() -> None:
    """Their torso's yaw weighs nothing; on legs that can it does."""
    for name, weight in (("bhr_b2", 0.0), ("thbip_ii", 1.0)):
        held = Held(name)
        held.tick()
        np.testing.assert_array_equal(held.groups.reference.torso_weight, [1.0, 1.0, weight])
