"""Switching legs: the two rules of section 2.2, and parameters that take effect only then (section 2.3)."""

import numpy as np
import pytest
from tests.control.walking import parameters
from tests.template.steps import some_frames

from gaitsmith.robots.parameters import GaitParameters
from gaitsmith.template.foothold import SpeedGains, make_foothold_gains, make_speed_gains
from gaitsmith.template.step import WALK, GaitInputs, StepState, make_gait_inputs, make_step_state
from gaitsmith.template.switching import begin_step, latch, switch_legs
from gaitsmith.whole_body.frames import Frames

GAINS: SpeedGains = make_speed_gains(parameters("bhr_b2").speed)
SEPARATION = 0.06
FOOTHOLD = make_foothold_gains(parameters("bhr_b2").foothold, 9.81, 0.7, (0.3, 0.8))._replace(
    separation=SEPARATION, sway=1.0
)
OLD = GaitParameters(period=0.4, height=0.7, lift=0.1, width=0.04)
NEW = GaitParameters(speed=(0.3, -0.1), period=0.3, alpha=0.4, height=0.6, lift=0.05, width=0.05, yaw_rate=0.2)


def walking(stance: int, count: int = 4) -> StepState:
    """In the middle of a walk, 0.38 s into a step, moving at 0.02 m/s."""
    step = make_step_state(2, 4)
    step.mode[0], step.walk_requested[0], step.stance[0], step.count[0], step.time[0] = WALK, 1, stance, count, 0.38
    step.period[0] = 0.4
    step.velocity_ticks[0] = 380
    step.velocity_sum[:] = 380 * 0.02
    step.last_mean_velocity[:] = 0.02
    return step


def switch(step: StepState, requested: GaitInputs, latched: GaitInputs, seed: int = 0) -> tuple[np.ndarray, Frames]:
    """Switch with a random desired state of the landed sole and random frames, which are returned."""
    desired, frames = np.random.default_rng(seed).normal(size=(3, 3)), some_frames(seed)
    switch_legs(step, requested, latched, FOOTHOLD, GAINS, 1 - int(step.stance[0]), desired, frames)
    return desired, frames


def test_latch_copies_every_parameter() -> None:
    step, requested, latched = walking(0), make_gait_inputs(NEW), make_gait_inputs(OLD)
    latch(step, requested, latched, FOOTHOLD)
    assert np.array_equal(requested.values, latched.values)
    requested.period[0] = 0.5
    assert latched.period[0] == NEW.period


def test_the_near_step_of_a_sideways_walk_clears_the_stance_sole() -> None:
    """Every other step lands ``2 W - T |v|`` away: W grows to what the separation needs, and never without need."""
    step, latched = walking(0), make_gait_inputs(OLD)
    for speed, width in ((-0.3, 0.5 * (SEPARATION + 0.4 * 0.3)), (0.3, 0.5 * (SEPARATION + 0.4 * 0.3)), (0.04, 0.04)):
        latch(step, make_gait_inputs(OLD.model_copy(update={"speed": (0.5, speed)})), latched, FOOTHOLD)
        assert latched.width[0] == pytest.approx(width, rel=1e-12)
    latch(step, make_gait_inputs(OLD), latched, FOOTHOLD)
    assert latched.width[0] == OLD.width
    latch(step, make_gait_inputs(NEW), latched, FOOTHOLD._replace(sway=0.0))
    assert latched.width[0] == NEW.width


def test_a_new_speed_must_settle() -> None:
    """The integral waits some steps after a change of the commanded speed, and after no other command."""
    step, latched = walking(0), make_gait_inputs(OLD)
    step.last_mean_velocity[:] = step.stride_mean[:] = 0.5  # it moves at that speed all the time
    latch(step, make_gait_inputs(OLD.model_copy(update={"height": 0.6, "period": 0.3})), latched, FOOTHOLD)
    assert step.settling[0] == 0
    latch(step, make_gait_inputs(NEW), latched, FOOTHOLD)
    waiting = int(step.settling[0])
    assert waiting > 0
    for k in range(waiting):
        integral = step.integral.copy()
        step.velocity_ticks[0], step.velocity_sum[:] = 10, 10 * 0.5
        switch(step, make_gait_inputs(NEW), latched)
        assert step.settling[0] == waiting - 1 - k
        np.testing.assert_array_equal(step.integral, integral)
    step.velocity_ticks[0], step.velocity_sum[:] = 10, 10 * 0.5
    switch(step, make_gait_inputs(NEW), latched)
    assert np.any(step.integral)


def test_durations_are_learnt_within_bounds() -> None:
    """The expected duration moves half of the way to the last one; what a push cut short counts as 0.8."""
    step, latched = walking(0), make_gait_inputs(OLD)
    switch(step, make_gait_inputs(OLD), latched)
    assert step.duration_ratio[0] == pytest.approx(0.5 * (1.0 + 0.38 / 0.4))
    for time, limit in ((0.1, 0.8), (0.6, 1.1)):
        for _ in range(60):
            step.time[0] = time
            switch(step, make_gait_inputs(OLD), latched)
        assert step.duration_ratio[0] == pytest.approx(limit)


def test_begin_step_resets_the_clock_and_counts() -> None:
    step = walking(0)
    begin_step(step, 1, 0, np.zeros((3, 3)), some_frames())
    assert (step.stance[0], step.count[0], step.time[0], step.last_duration[0]) == (1, 5, 0.0, 0.38)


@pytest.mark.parametrize("stance", [0, 1])
def test_both_rules(stance: int) -> None:
    """The landed leg goes on from its desired state, the leaving one from its actual state."""
    step = walking(stance)
    desired, frames = switch(step, make_gait_inputs(OLD), make_gait_inputs(OLD))
    assert step.stance[0] == 1 - stance
    np.testing.assert_array_equal(step.support_start, desired)
    actual = [frames.relative_position[stance], frames.relative_velocity[stance]]
    np.testing.assert_array_equal(step.swing_start, actual)
    assert step.swing_pitch_start[0] == frames.sole_pitch[stance]
    assert step.swing_yaw_start[0] == frames.sole_yaw[stance]


def test_a_switch_latches() -> None:
    requested, latched = make_gait_inputs(NEW), make_gait_inputs(OLD)
    switch(walking(0), requested, latched)
    assert np.array_equal(requested.values, latched.values)


def test_integral_learns_from_the_gait_that_was_walked() -> None:
    """The command that arrives with the switch must not count for the step before it."""
    step, latched = walking(0), make_gait_inputs(OLD)
    switch(step, make_gait_inputs(NEW), latched)
    expected = -0.02 * np.array([GAINS.integral_gain_x, GAINS.integral_gain_y])
    np.testing.assert_allclose(step.integral, expected, rtol=1e-12)


def test_station_is_kept_once_a_stopped_robot_is_slow() -> None:
    """Not on the switch that latches the stop, but on the next one; any command gives it up."""
    still, moving = make_gait_inputs(OLD), make_gait_inputs(NEW)
    step, latched = walking(0), make_gait_inputs(NEW)
    switch(step, still, latched)
    assert step.station_kept[0] == 0
    step.velocity_ticks[0], step.velocity_sum[:] = 100, 100 * 0.02
    switch(step, still, latched)
    assert step.station_kept[0] == 1
    step.velocity_ticks[0] = 100
    switch(step, moving, latched)
    assert step.station_kept[0] == 0


def test_station_is_not_kept_at_speed() -> None:
    step, latched = walking(0), make_gait_inputs(OLD)
    step.velocity_sum[0] = 380 * 0.3
    switch(step, make_gait_inputs(OLD), latched)
    assert step.station_kept[0] == 0
