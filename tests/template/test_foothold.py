"""Footholds: eq. 15 as printed, the law of a linear pendulum, and the bounds that come last."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.control.walking import Held, parameters
from tests.template.steps import OMEGA, Array, a_step, forecast, gains, inputs, swing

from gaitsmith.template.foothold import (
    FootholdGains,
    SpeedGains,
    choose_speed,
    foothold_target,
    forecast_touchdown,
    landing_height,
    make_speed_gains,
)
from gaitsmith.template.step import GaitInputs

EXACT = 1e-12  # m
sides = st.sampled_from([-1.0, 1.0])
speeds = st.tuples(st.floats(-0.4, 0.4), st.floats(-0.2, 0.2))
periods = st.floats(0.25, 0.6)
arms = st.tuples(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1))


def foothold(
    law: FootholdGains,
    gait: GaitInputs,
    arm: Array,
    velocity: Array,
    side: float,
    time: float = 0.0,
    beside: float = 0.0,
) -> Array:
    """Foothold relative to the CoM, which is at the hip midpoint."""
    step, cast, out = a_step(gait, time), forecast(), np.zeros(2)
    cast.arm[:2] = arm
    forecast_touchdown(step, gait, law, np.asarray(velocity), side, cast)
    moves = foothold_target(step, gait, law, cast, np.zeros(2), beside, side, out)
    assert moves == (abs(side * (out[1] - beside) - law.separation) < EXACT)  # with the stance sole
    return out


@given(speeds, arms, speeds, sides, st.floats(0.0, 0.2))
def test_equation_15(wanted: tuple[float, float], arm: Array, velocity: Array, side: float, time: float) -> None:
    """With all shares at zero: T v_d / 2 + k_v (v - v_d) around ±W, whatever the pendulum would do."""
    law = gains(velocity_gain=(0.3, 0.2), deadbeat=0.0, prediction=0.0, mean_speed=0.0, sway=0.0)
    gait = inputs(speed=wanted)
    expected = 0.5 * gait.period[0] * gait.speed + [0.3, 0.2] * (np.array(velocity) - wanted)
    expected[1] += side * gait.width[0]
    np.testing.assert_allclose(foothold(law, gait, arm, velocity, side, time, -side * 10.0), expected, atol=EXACT)


@given(periods, arms, speeds, sides, st.floats(0.0, 1.0))
def test_a_pendulum_is_stopped_in_one_step(
    period: float, arm: Array, velocity: Array, side: float, share: float
) -> None:
    """Commanded to zero with no width: from any state the next step's end has no speed left, forward and lateral.

    The foothold is asked for at any time of the step, and stays the same as the pendulum swings on.
    """
    law, gait = gains(), inputs(period=period, width=1e-12, speed=(0.0, 0.0))
    time = share * period
    here, speed = swing(np.array(arm), np.array(velocity), time)
    place = foothold(law, gait, here, speed, side, time, -side * 10.0)
    np.testing.assert_allclose(place, foothold(law, gait, arm, velocity, side, 0.0, -side * 10.0), atol=1e-9)
    _, landed = swing(np.array(arm), np.array(velocity), period)
    _, end = swing(-place, landed, period)
    np.testing.assert_allclose(end, 0.0, atol=1e-9)


@given(periods, speeds, sides, st.floats(0.05, 0.15), arms)
def test_the_gait_is_reached_and_kept(
    period: float, speed: tuple[float, float], side: float, width: float, arm: Array
) -> None:
    """From any start: after two steps the mean speed is the commanded one and the soles are 2 W apart."""
    law, gait = gains(), inputs(period=period, speed=speed, width=width)
    arm_, velocity, soles = np.array(arm), np.array([0.3, -0.1]), [np.zeros(2)]
    for _ in range(6):
        step = foothold(law, gait, arm_, velocity, side, 0.0, -side * 10.0)
        arm_, velocity = swing(arm_, velocity, period)
        soles.append(soles[-1] + arm_ + step)
        arm_, side = -step, -side
    strides = np.diff(soles, axis=0)[3:]
    np.testing.assert_allclose(strides[:, 0], period * speed[0], atol=1e-6)
    np.testing.assert_allclose(strides[:-1, 1] + strides[1:, 1], 2.0 * period * speed[1], atol=1e-6)
    np.testing.assert_allclose(np.abs(np.diff(strides[:, 1])), 4.0 * width, atol=1e-6)


def test_without_sway_the_stance_widens() -> None:
    """By 1 / (1 - tanh(ωT/2) coth(ωT)): the cause of BHR-B2's wide stance."""
    law, gait = gains(sway=0.0), inputs()
    period, width = float(gait.period[0]), float(gait.width[0])
    arm, velocity, side, strides = np.array([0.0, -width]), np.zeros(2), 1.0, []
    for _ in range(40):
        step = foothold(law, gait, arm, velocity, side, 0.0, -side * 10.0)
        arm, velocity = swing(arm, velocity, period)
        strides.append(abs(float(arm[1] + step[1])))
        arm, side = -step, -side
    expected = 2.0 * width / (1.0 - math.tanh(0.5 * OMEGA * period) / math.tanh(OMEGA * period))
    assert strides[-1] == pytest.approx(expected, rel=1e-6)


@settings(max_examples=60)
@given(speeds, st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0)), sides, st.floats(-0.2, 0.2))
def test_bounds(speed: tuple[float, float], velocity: Array, side: float, beside: float) -> None:
    """Reach, spread and separation hold however fast the robot moves; the separation is never undone."""
    law = gains(reach=0.2, spread=0.16, separation=0.11)
    place = foothold(law, inputs(speed=speed), (0.0, 0.0), velocity, side, 0.0, beside)
    assert abs(place[0]) <= 0.2
    assert side * (place[1] - beside) >= 0.11 - EXACT
    assert abs(place[1]) <= max(0.16, side * beside + 0.11) + EXACT


def test_foothold_is_measured_from_the_com() -> None:
    """A CoM ahead of the hips takes the foothold with it."""
    gait, out = inputs(speed=(0.2, 0.0)), np.zeros(2)
    step, cast = a_step(gait), forecast()
    places = []
    for offset in ((0.0, 0.0), (0.05, 0.02)):
        foothold_target(step, gait, gains(), cast, np.array(offset), -1.0, 1.0, out)
        places.append(out.copy())
    np.testing.assert_allclose(places[1] - places[0], [0.05, 0.02], atol=EXACT)


SPEED: SpeedGains = make_speed_gains(parameters("thbip_ii").speed)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("drift", [0.01, -0.01, 5.0, -5.0])
def test_station_keeping_walks_home(axis: int, drift: float) -> None:
    """Speed against the drift, proportional up to a bound; only once a station is kept."""
    gait, cast = inputs(), forecast()
    step = a_step(gait)
    cast.drift[axis], step.integral[:] = drift, (0.01, 0.02)
    choose_speed(step, gait, SPEED, cast)
    np.testing.assert_array_equal(step.speed, gait.speed + step.integral)
    step.station_kept[0] = 1
    choose_speed(step, gait, SPEED, cast)
    gain = (SPEED.station_gain_x, SPEED.station_gain_y)[axis]
    home = -np.clip(gain * drift, -SPEED.station_limit, SPEED.station_limit)
    assert step.speed[axis] - gait.speed[axis] - step.integral[axis] == pytest.approx(home)
    assert step.speed[1 - axis] == gait.speed[1 - axis] + step.integral[1 - axis]


def test_the_way_home_is_as_fast_in_every_direction() -> None:
    """Straight towards the station, never faster than the bound, however the robot is turned."""
    gait, cast = inputs(), forecast()
    step = a_step(gait)
    step.station_kept[0] = 1
    for angle in (0.3, 0.25 * math.pi, 2.0):
        cast.drift[:] = 5.0 * math.cos(angle), 5.0 * math.sin(angle)
        choose_speed(step, gait, SPEED, cast)
        np.testing.assert_allclose(step.speed - gait.speed, -SPEED.station_limit * cast.drift / 5.0, atol=EXACT)


@pytest.mark.parametrize("yaw", [-2.0, 0.5, 3.0])
def test_foothold_does_not_depend_on_the_heading(yaw: float) -> None:
    """Turned by any angle, the robot steps to the same place in its heading frame."""
    found, c, s = [], math.cos(yaw), math.sin(yaw)
    for turned in (False, True):
        held = Held("thbip_ii")
        held.v[:2] = (0.2 * c + 0.1 * s, 0.2 * s - 0.1 * c) if turned else (0.2, -0.1)
        if turned:
            held.q[3:7] = math.cos(0.5 * yaw), 0.0, 0.0, math.sin(0.5 * yaw)
        held.controller.command(speed=(0.1, 0.05))
        held.controller.walk()
        held.tick()
        found.append(held.controller.telemetry.foothold.copy())
    np.testing.assert_allclose(found[1], found[0], atol=1e-9)


@given(speeds, sides, st.floats(-0.3, 0.3), st.floats(-0.3, 0.3))
def test_the_hips_sink_for_a_foothold_out_of_the_leg_s_reach(
    wanted: tuple[float, float], side: float, ahead: float, aside: float
) -> None:
    """The leg reaches what lies beyond the walk's own foothold; the walk's own never lowers the hips."""
    gait, leg, lowest = inputs(speed=wanted), 0.385, 0.26
    law = gains()._replace(leg=leg, lowest_hips=lowest)
    usual = 0.5 * gait.period[0] * gait.speed + [0.0, side * gait.width[0]]
    height = landing_height(gait, law, usual, side, 0.0)
    assert height == gait.height[0]
    way = np.array([0.0, side * gait.width[0]]) + 0.5 * gait.period[0] * np.abs(gait.speed) * np.sign([ahead, aside])
    found = landing_height(gait, law, np.add(way, (ahead, aside)), side, 0.0)
    assert found == pytest.approx(min(height, max(lowest, math.sqrt(max(leg**2 - ahead**2 - aside**2, 0.0)))))


def test_the_leg_reaches_down_to_a_foothold_a_step_lower() -> None:
    """Before a drop as deep as the lift, the hips sink until the leg, stretched to it, is long enough."""
    gait = inputs(speed=(0.4, 0.0))
    law, drop = gains()._replace(leg=0.385, lowest_hips=0.2), float(gait.lift[0])
    foothold = np.array([0.12, gait.width[0]])
    height = landing_height(gait, law, foothold, 1.0, drop)
    assert math.hypot(height + drop, 0.12) == pytest.approx(0.385)
    levels = [landing_height(gait, law, foothold, 1.0, share * drop) for share in np.linspace(0.0, 1.0, 20)]
    assert np.all(np.diff(levels) <= 0.0)
