"""Footholds follow eqs. 13 and 15 within their bounds; integral and station push back against what they see."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.control.walking import Held, parameters

from gaitsmith.robots.parameters import FootholdParameters, GaitParameters
from gaitsmith.template.foothold import finish_step, make_foothold_gains, observe_motion
from gaitsmith.template.step import RIGHT, make_gait, make_step_state

EXACT = 1e-12  # m
SLOW, FAST = st.floats(-0.3, 0.3), st.floats(-2.0, 2.0)


def first_foothold(held: Held, speed: tuple[float, float]) -> np.ndarray:
    """Foothold of the first tick of a walk."""
    held.controller.command(speed=speed)
    held.controller.reset()
    held.controller.walk()
    held.tick()
    return held.controller.telemetry.foothold.copy()


PAPER = parameters("bhr_b2", "paper")
GAINS = PAPER.foothold  # eq. 15 as printed: present velocity, fixed gain
HELD, TURNED = Held(chosen=PAPER), Held(chosen=PAPER)


@settings(max_examples=60)
@given(command=st.tuples(SLOW, SLOW), x=SLOW, y=SLOW)
def test_equation_15(command: tuple[float, float], x: float, y: float) -> None:
    """T v_d / 2 + k_v (v - v_d) around ±W, as long as no bound is met; the whole robot moves at (x, y)."""
    HELD.v[:2] = x, y
    found = first_foothold(HELD, command)
    velocity, wanted = HELD.controller.telemetry.com_velocity[:2], np.array(command)
    np.testing.assert_allclose(velocity, [x, y], atol=1e-12)
    expected = 0.5 * HELD.gait.period * wanted + np.array(GAINS.velocity_gain) * (velocity - wanted)
    side = 1.0 if HELD.controller.telemetry.stance[0] == RIGHT else -1.0
    expected[1] += side * HELD.gait.width
    stance_y = HELD.groups.frames.relative[HELD.groups.step.stance[0], 0, 1]
    expected[1] = side * max(side * expected[1], side * stance_y + GAINS.separation)
    np.testing.assert_allclose(found, expected, atol=EXACT)


@settings(max_examples=60)
@given(command=st.tuples(SLOW, SLOW), x=FAST, y=FAST)
def test_bounds(command: tuple[float, float], x: float, y: float) -> None:
    """Reach, spread, and separation hold however fast the robot moves."""
    HELD.v[:2] = x, y
    found = first_foothold(HELD, command)
    stance = int(HELD.groups.step.stance[0])
    outward = 1.0 if stance == RIGHT else -1.0
    assert abs(found[0]) <= GAINS.reach
    assert abs(found[1]) <= GAINS.spread
    assert outward * (found[1] - HELD.groups.frames.relative[stance, 0, 1]) >= GAINS.separation - EXACT


@settings(max_examples=20)
@given(yaw=st.floats(-3.1, 3.1))
def test_foothold_does_not_depend_on_the_heading(yaw: float) -> None:
    """Turned by any angle, the robot steps to the same place in its heading frame."""
    HELD.v[:2] = 0.2, -0.1
    straight = first_foothold(HELD, (0.1, 0.05))
    c, s = np.cos(yaw), np.sin(yaw)
    TURNED.q[3:7] = np.cos(0.5 * yaw), 0.0, 0.0, np.sin(0.5 * yaw)
    TURNED.v[:2] = 0.2 * c + 0.1 * s, 0.2 * s - 0.1 * c
    np.testing.assert_allclose(first_foothold(TURNED, (0.1, 0.05)), straight, atol=1e-9)


@pytest.mark.parametrize("speed", [-0.3, 0.0, 0.4])
def test_a_pendulum_at_its_periodic_speed_is_left_alone(speed: float) -> None:
    """With the forecast on, a linear pendulum that walks at the commanded speed steps half a step ahead of its CoM."""
    pendulum = {"deadbeat": 1.0, "prediction": 1.0, "mean_speed": 1.0}
    held = Held(chosen=parameters("bhr_b2", "paper", foothold=pendulum), width=0.1)
    first_foothold(held, (speed, 0.0))
    frames, com = held.groups.frames, held.groups.tree_state.com
    stance = int(held.groups.step.stance[0])
    arm = com - frames.sole_position[stance]
    omega, period = np.sqrt(9.81 / arm[2]), held.gait.period
    # At mid-step the periodic pendulum is above its foot; move the robot's body there in velocity alone.
    end = 0.5 * omega * period / np.tanh(0.5 * omega * period) * speed
    held.v[0] = (end - omega * np.sinh(omega * period) * arm[0]) / np.cosh(omega * period)
    found = first_foothold(held, (speed, 0.0))
    offset = com[0] - frames.hip_position[0]
    np.testing.assert_allclose(found[0], 0.5 * period * speed + offset, atol=1e-9)


BASE = FootholdParameters(
    velocity_gain=(0.3, 0.3),
    integral_gain=(0.05, 0.04),
    integral_limit=0.1,
    station_gain=(0.1, 0.1),
    reach=0.4,
    spread=0.35,
    separation=0.09,
)


def finished(velocity: tuple[float, float], steps: int, speed: tuple[float, float] = (0.2, 0.0)) -> np.ndarray:
    """Integral after some steps at a constant velocity."""
    step, gait = make_step_state(), make_gait(GaitParameters(speed=speed, period=0.4, height=0.7, lift=0.1, width=0.04))
    step.settling[0] = 1  # the first step has no stride
    for _ in range(steps):
        for _ in range(10):
            observe_motion(step, np.array(velocity), np.zeros(2))
        finish_step(step, gait, make_foothold_gains(BASE))
    return step.integral.copy()


def test_integral_grows_while_the_robot_is_too_slow() -> None:
    """The foothold is at minus the integral: too slow, it moves back, and the robot falls forward."""
    assert (finished((0.1, -0.1), 5) > 0.0).all()
    assert (finished((0.3, 0.1), 5) < 0.0).all()
    np.testing.assert_allclose(finished((0.2, 0.0), 30)[1], 0.0, atol=EXACT)


def test_integral_adds_gain_times_mean_error_and_is_bounded() -> None:
    step_by_step = finished((0.1, 0.0), 4) - finished((0.1, 0.0), 3)
    np.testing.assert_allclose(step_by_step, [0.05 * 0.1, 0.0], atol=EXACT)
    np.testing.assert_allclose(finished((-2.0, 5.0), 200), [0.1, -0.1], atol=EXACT)


def test_lateral_sway_does_not_fill_the_integral() -> None:
    """Opposite sway on the two legs has no mean over a stride."""
    step, gait = make_step_state(), make_gait(GaitParameters(period=0.4, height=0.7, lift=0.1, width=0.04))
    step.settling[0] = 1
    for k in range(21):
        observe_motion(step, np.array([0.0, 0.3 * (-1) ** k]), np.zeros(2))
        finish_step(step, gait, make_foothold_gains(BASE))
    assert abs(step.integral[1]) <= EXACT


def test_a_step_without_ticks_teaches_nothing() -> None:
    step, gait = make_step_state(), make_gait(GaitParameters(period=0.4, height=0.7, lift=0.1, width=0.04))
    step.integral[0], step.last_mean_velocity[0] = 0.02, 0.1
    finish_step(step, gait, make_foothold_gains(BASE))
    assert (step.integral[0], step.last_mean_velocity[0]) == (0.02, 0.1)


def test_station_is_the_mean_place_of_a_stride() -> None:
    """Until it is kept; then it stays."""
    step, gait = make_step_state(), make_gait(GaitParameters(period=0.4, height=0.7, lift=0.1, width=0.04))
    for x in (1.0, 3.0):
        observe_motion(step, np.zeros(2), np.array([x, -x]))
        finish_step(step, gait, make_foothold_gains(BASE))
    np.testing.assert_allclose(step.station, [2.0, -2.0], atol=EXACT)
    step.station_kept[0] = 1
    observe_motion(step, np.zeros(2), np.array([9.0, 9.0]))
    finish_step(step, gait, make_foothold_gains(BASE))
    np.testing.assert_allclose(step.station, [2.0, -2.0], atol=EXACT)


@pytest.mark.parametrize(("drift", "axis"), [(0.2, 0), (0.2, 1), (5.0, 0), (-5.0, 1)])
def test_station_keeping_steps_further_out(drift: float, axis: int) -> None:
    """Drifted forward, the robot steps further forward and falls back; the offset is bounded."""
    gains = GAINS.model_copy(update={"station_gain": (0.1, 0.08), "station_limit": 0.05})
    held = Held(chosen=PAPER.model_copy(update={"foothold": gains}), width=0.1)
    at_home = first_foothold(held, (0.0, 0.0))
    held.groups.step.station[axis] -= drift
    held.tick()
    offset = float(np.clip(gains.station_gain[axis] * drift, -gains.station_limit, gains.station_limit))
    moved = held.controller.telemetry.foothold - at_home
    np.testing.assert_allclose(moved[axis], offset, atol=EXACT)
