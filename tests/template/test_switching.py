"""Switching legs: the two rules of section 2.2, and parameters that take effect only then (section 2.3)."""

import numpy as np
import pytest

from gaitsmith.robots import load_robot
from gaitsmith.robots.parameters import GaitParameters
from gaitsmith.template.foothold import FootholdGains, make_foothold_gains
from gaitsmith.template.step import LEFT, RIGHT, WALK, Gait, StepState, make_gait, make_step_state
from gaitsmith.template.switching import begin_step, latch, switch_legs

GAINS: FootholdGains = make_foothold_gains(load_robot("bhr_b2").card.presets["default"].foothold)
OLD = GaitParameters(period=0.4, height=0.7, lift=0.1, width=0.04)
NEW = GaitParameters(speed=(0.3, -0.1), period=0.3, alpha=0.4, height=0.6, lift=0.05, width=0.05)


def walking(stance: int, count: int = 4) -> StepState:
    """In the middle of a walk, 0.38 s into a step, moving at 0.02 m/s."""
    step = make_step_state()
    step.mode[0], step.walk_requested[0], step.stance[0], step.count[0], step.time[0] = WALK, 1, stance, count, 0.38
    step.velocity_ticks[0] = 380
    step.velocity_sum[:] = 380 * 0.02
    step.last_mean_velocity[:] = 0.02
    return step


def same(one: Gait, other: Gait) -> bool:
    return all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))


def switch(step: StepState, requested: Gait, latched: Gait, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Switch with random desired and actual states, which are returned."""
    rng = np.random.default_rng(seed)
    desired, actual = rng.normal(size=(3, 3)), rng.normal(size=(2, 3))
    switch_legs(step, requested, latched, GAINS, desired, actual, 0.07)
    return desired, actual


def test_latch_copies_every_parameter() -> None:
    step, requested, latched = walking(LEFT), make_gait(NEW), make_gait(OLD)
    latch(step, requested, latched)
    assert same(requested, latched)
    requested.period[0] = 0.5
    assert latched.period[0] == NEW.period


def test_a_new_speed_must_settle() -> None:
    """The integral waits some steps after a change of speed, and after no other change."""
    step, latched = walking(LEFT), make_gait(OLD)
    latch(step, make_gait(OLD.model_copy(update={"height": 0.6, "period": 0.3})), latched)
    assert step.settling[0] == 0
    latch(step, make_gait(NEW), latched)
    waiting = int(step.settling[0])
    assert waiting > 0
    for k in range(waiting):
        integral = step.integral.copy()
        step.velocity_ticks[0], step.velocity_sum[:] = 10, 10 * 0.5
        switch(step, make_gait(NEW), latched)
        assert step.settling[0] == waiting - 1 - k
        np.testing.assert_array_equal(step.integral, integral)
    step.velocity_ticks[0], step.velocity_sum[:] = 10, 10 * 0.5
    switch(step, make_gait(NEW), latched)
    assert np.any(step.integral)


def test_durations_are_learnt_within_bounds() -> None:
    """The expected duration moves half of the way to the last one; what a push cut short counts as 0.8."""
    step, latched = walking(LEFT), make_gait(OLD)
    switch(step, make_gait(OLD), latched)
    assert step.duration_ratio[0] == pytest.approx(0.5 * (1.0 + 0.38 / 0.4))
    for time, limit in ((0.1, 0.8), (0.6, 1.1)):
        for _ in range(60):
            step.time[0] = time
            switch(step, make_gait(OLD), latched)
        assert step.duration_ratio[0] == pytest.approx(limit)


def test_begin_step_resets_the_clock_and_counts() -> None:
    step = walking(LEFT)
    begin_step(step, RIGHT, np.zeros((3, 3)), np.zeros((2, 3)), 0.2)
    assert (step.stance[0], step.count[0], step.time[0], step.last_duration[0]) == (RIGHT, 5, 0.0, 0.38)
    assert step.swing_pitch_start[0] == 0.2


@pytest.mark.parametrize("stance", [LEFT, RIGHT])
def test_both_rules(stance: int) -> None:
    """The landed leg goes on from its desired state, the leaving one from its actual state."""
    step = walking(stance)
    desired, actual = switch(step, make_gait(OLD), make_gait(OLD))
    assert step.stance[0] == (RIGHT if stance == LEFT else LEFT)
    np.testing.assert_array_equal(step.support_start, desired)
    np.testing.assert_array_equal(step.swing_start, actual)
    assert step.swing_pitch_start[0] == 0.07


def test_a_switch_latches() -> None:
    requested, latched = make_gait(NEW), make_gait(OLD)
    switch(walking(LEFT), requested, latched)
    assert same(requested, latched)


def test_integral_learns_from_the_gait_that_was_walked() -> None:
    """The command that arrives with the switch must not count for the step before it."""
    step, latched = walking(LEFT), make_gait(OLD)
    switch(step, make_gait(NEW), latched)
    expected = -0.02 * np.array([GAINS.integral_gain_x, GAINS.integral_gain_y])
    np.testing.assert_allclose(step.integral, expected, rtol=1e-12)


def test_station_is_kept_once_a_stopped_robot_is_slow() -> None:
    """Not on the switch that latches the stop, but on the next one; any command gives it up."""
    still, moving = make_gait(OLD), make_gait(NEW)
    step, latched = walking(LEFT), make_gait(NEW)
    switch(step, still, latched)
    assert step.station_kept[0] == 0
    step.velocity_ticks[0], step.velocity_sum[:] = 100, 100 * 0.02
    switch(step, still, latched)
    assert step.station_kept[0] == 1
    step.velocity_ticks[0] = 100
    switch(step, moving, latched)
    assert step.station_kept[0] == 0


def test_station_is_not_kept_at_speed() -> None:
    step, latched = walking(LEFT), make_gait(OLD)
    step.velocity_sum[0] = 380 * 0.3
    switch(step, make_gait(OLD), latched)
    assert step.station_kept[0] == 0
