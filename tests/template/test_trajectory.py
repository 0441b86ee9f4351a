"""Leg trajectories meet the boundary conditions of eqs. 7-12, join smoothly, and sink when the ground is late."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from gaitsmith.robots.parameters import GaitParameters
from gaitsmith.template.step import GaitInputs, StepState, make_gait_inputs, make_step_state
from gaitsmith.template.trajectory import (
    Printed,
    follow_foothold,
    smooth_share,
    support_foot,
    swing_foot,
    swing_pitch,
    swing_yaw,
)

EXACT = 1e-9  # m, m/s, m/s²: rounding of a closed form whose terms reach 1e3
JOIN = 1e-6  # s, on both sides of the joint
DESCENT = 0.25  # m/s
REPLACED, PRINTED = Printed(*[0.0] * 6), Printed(*[1.0] * 6)

gaits = st.builds(
    GaitParameters,
    period=st.floats(0.2, 1.0),
    alpha=st.floats(0.2, 0.8),
    height=st.floats(0.4, 0.75),
    lift=st.floats(0.02, 0.2),
    width=st.just(0.04),
)
seeds = st.integers(0, 2**32 - 1)


def a_step(seed: int) -> tuple[StepState, np.ndarray]:
    """A step that starts from a random state of both soles, and a foothold."""
    rng, step = np.random.default_rng(seed), make_step_state(2, 4)
    step.support_start[:] = rng.normal(size=(3, 3)) * [[0.2], [0.5], [2.0]]
    step.support_start[0, 2] = -rng.uniform(0.4, 0.75)
    step.speed[:] = rng.uniform(-0.5, 0.5, size=2)
    step.swing_start[:] = rng.normal(size=(2, 3)) * [[0.2], [0.5]]
    step.swing_start[0, 2] = -rng.uniform(0.4, 0.75)
    return step, rng.uniform(-0.3, 0.3, size=2)


def support_at(step: StepState, gait: GaitInputs, time: float, printed: Printed = REPLACED) -> np.ndarray:
    """State of a left support sole, which is at rest below the hips where no curve says otherwise."""
    step.time[0] = step.place[0] = time
    out = np.zeros((3, 3))
    support_foot(step, gait, printed, float(gait.height[0]), 1.0, np.zeros(3), out)
    return out


def swing_at(
    step: StepState, gait: GaitInputs, foothold: np.ndarray, time: float, printed: Printed = REPLACED
) -> np.ndarray:
    """State of a right swing sole."""
    step.time[0] = step.place[0] = time
    out = np.zeros((3, 3))
    low = -gait.height[0]
    swing_foot(step, gait, foothold, low, low, 0.5, printed, -1.0, DESCENT, np.zeros(3), out)
    return out


@given(gaits, seeds)
def test_support_goes_from_its_desired_state_to_the_height(parameters: GaitParameters, seed: int) -> None:
    """First rule of section 2.2 at the start, eq. 7 at the end."""
    gait, (step, _) = make_gait_inputs(parameters), a_step(seed)
    np.testing.assert_allclose(support_at(step, gait, 0.0)[:, 2], step.support_start[:, 2], atol=EXACT)
    end = support_at(step, gait, parameters.period)
    np.testing.assert_allclose(end[:, 2], [-parameters.height, 0.0, 0.0], atol=EXACT)
    assert not np.any(end[:, :2])


@given(gaits, seeds)
def test_the_support_sole_as_printed(parameters: GaitParameters, seed: int) -> None:
    """Eqs. 7 to 9: from the desired state at the switch; at αT below the hips and at H, at T half a step behind."""
    gait, (step, _) = make_gait_inputs(parameters), a_step(seed)
    np.testing.assert_allclose(support_at(step, gait, 0.0, PRINTED), step.support_start, atol=EXACT)
    middle = support_at(step, gait, parameters.alpha * parameters.period, PRINTED)[0]
    np.testing.assert_allclose(middle, [0.0, parameters.width, -parameters.height], atol=EXACT)
    end = support_at(step, gait, parameters.period, PRINTED)
    half = 0.5 * parameters.period * step.speed[0]
    np.testing.assert_allclose(end[0], [-half, parameters.width, -parameters.height], atol=EXACT)
    np.testing.assert_allclose(end[1:], 0.0, atol=EXACT)


@given(gaits, seeds)
def test_the_swing_sole_as_printed(parameters: GaitParameters, seed: int) -> None:
    """Eqs. 10 and 11: below its hip at αT; start, lift and end are the same."""
    gait, (step, foothold) = make_gait_inputs(parameters), a_step(seed)
    for time in (0.0, parameters.period):
        usual = swing_at(step, gait, foothold, time)
        np.testing.assert_allclose(swing_at(step, gait, foothold, time, PRINTED), usual, atol=EXACT)
    middle = swing_at(step, gait, foothold, parameters.alpha * parameters.period, PRINTED)[0]
    np.testing.assert_allclose(middle, [0.0, -parameters.width, parameters.lift - parameters.height], atol=EXACT)


@given(gaits)
def test_support_at_its_height_stays_there(parameters: GaitParameters) -> None:
    """Eq. 7 to the letter: nothing moves."""
    gait, step = make_gait_inputs(parameters), make_step_state(2, 4)
    step.support_start[0, 2] = -parameters.height
    for time in np.linspace(0.0, 1.5 * parameters.period, 20):
        found = support_at(step, gait, time)[:, 2]
        np.testing.assert_allclose(found, [-parameters.height, 0.0, 0.0], atol=EXACT)


@given(gaits, seeds)
def test_swing_boundary_conditions(parameters: GaitParameters, seed: int) -> None:
    """From the actual state (second rule of section 2.2) over the lift to rest on the foothold (eqs. 10-12)."""
    gait, (step, foothold) = make_gait_inputs(parameters), a_step(seed)
    landing = np.array([*foothold, -parameters.height])
    start = swing_at(step, gait, foothold, 0.0)
    np.testing.assert_allclose(start[:2], step.swing_start, atol=EXACT)
    np.testing.assert_allclose(start[2], 0.0, atol=EXACT)
    middle = swing_at(step, gait, foothold, parameters.alpha * parameters.period)[0]
    np.testing.assert_allclose(middle[:2], 0.5 * (step.swing_start[0, :2] + foothold), atol=EXACT)
    np.testing.assert_allclose(middle[2], parameters.lift - parameters.height, atol=EXACT)
    end = swing_at(step, gait, foothold, parameters.period)
    np.testing.assert_allclose(end, [landing, np.zeros(3), np.zeros(3)], atol=EXACT)


@given(gaits, seeds)
def test_sections_join_with_equal_acceleration(parameters: GaitParameters, seed: int) -> None:
    """No jump at αT beyond what a microsecond of the curve's own jerk makes."""
    gait, (step, foothold) = make_gait_inputs(parameters), a_step(seed)
    joint = parameters.alpha * parameters.period
    before = swing_at(step, gait, foothold, joint - JOIN)
    after = swing_at(step, gait, foothold, joint + JOIN)
    shortest = min(joint, parameters.period - joint)
    jerk = 1e3 * (1.0 + np.max(np.abs(after))) / shortest
    assert np.max(np.abs(after - before)) < jerk * JOIN


@given(gaits, seeds, st.floats(0.02, 0.98))
def test_rates_are_the_derivatives(parameters: GaitParameters, seed: int, share: float) -> None:
    """Velocity and acceleration by central differences, away from the joint."""
    gait, (step, foothold) = make_gait_inputs(parameters), a_step(seed)
    period, delta = parameters.period, 1e-5
    time = share * period
    if abs(time - parameters.alpha * period) < 2.0 * delta:
        return
    low, here, high = (swing_at(step, gait, foothold, time + shift) for shift in (-delta, 0.0, delta))
    slope = (high - low) / (2.0 * delta)
    np.testing.assert_allclose(slope[0], here[1], atol=1e-4 * (1.0 + np.max(np.abs(here))))
    np.testing.assert_allclose(slope[1], here[2], atol=1e-3 * (1.0 + np.max(np.abs(here)) / period))


@given(gaits, seeds, st.floats(0.0, 0.6))
def test_late_sole_goes_on_downwards(parameters: GaitParameters, seed: int, late: float) -> None:
    """Past T it stays over the foothold and sinks at the given speed, without a jump."""
    gait, (step, foothold) = make_gait_inputs(parameters), a_step(seed)
    late = max(late, 1e-6)
    found = swing_at(step, gait, foothold, parameters.period + late)
    np.testing.assert_allclose(found[0], [*foothold, -parameters.height - DESCENT * late], atol=EXACT)
    np.testing.assert_allclose(found[1], [0.0, 0.0, -DESCENT], atol=EXACT)
    assert not np.any(found[2])


@given(gaits, seeds)
def test_foothold_may_move_during_the_step(parameters: GaitParameters, seed: int) -> None:
    """The curve is linear in the foothold, and its end is wherever the foothold is now."""
    gait, (step, foothold) = make_gait_inputs(parameters), a_step(seed)
    time = 0.7 * parameters.period
    here = swing_at(step, gait, foothold, time)
    shift = np.array([0.1, -0.05])
    once = swing_at(step, gait, foothold + shift, time) - here
    twice = swing_at(step, gait, foothold + 2.0 * shift, time) - here
    np.testing.assert_allclose(twice, 2.0 * once, atol=EXACT)
    assert not np.any(once[:, 2])


@given(gaits, seeds, st.floats(0.3, 3.0))
def test_a_shortened_step_runs_the_same_curve_faster(parameters: GaitParameters, seed: int, rate: float) -> None:
    """Place on the curve decides where the sole is; its rate scales velocity once and acceleration twice."""
    gait, (step, foothold) = make_gait_inputs(parameters), a_step(seed)
    usual = swing_at(step, gait, foothold, 0.6 * parameters.period)
    step.rate[0] = rate
    fast = swing_at(step, gait, foothold, 0.6 * parameters.period)
    np.testing.assert_allclose(fast, usual * np.array([[1.0], [rate], [rate**2]]), atol=EXACT)


@given(gaits, st.floats(-0.3, 0.3))
def test_the_swing_sole_is_level_when_it_has_been_lifted(parameters: GaitParameters, pitch: float) -> None:
    """From its pitch at the switch to none at αT, and none from then on."""
    gait, step = make_gait_inputs(parameters), make_step_state(2, 4)
    step.swing_pitch_start[0] = pitch
    assert swing_pitch(step, gait, 0.0) == pitch
    for time in (parameters.alpha * parameters.period, parameters.period, 1.5 * parameters.period):
        step.time[0] = step.place[0] = time
        assert abs(swing_pitch(step, gait, 0.0)) < EXACT


@given(gaits, st.floats(-1.0, 1.0), st.floats(-0.3, 0.3))
def test_the_sole_lands_half_a_steps_turn_ahead(parameters: GaitParameters, rate: float, start: float) -> None:
    """The heading turns on while the sole stands: half of it behind, half ahead. At first the sole is where it was."""
    gait = make_gait_inputs(parameters.model_copy(update={"yaw_rate": rate}))
    step = make_step_state(2, 4)
    step.swing_yaw_start[0] = start
    assert swing_yaw(step, gait) == start
    for time in (parameters.period, 1.3 * parameters.period):
        step.time[0] = step.place[0] = time
        assert abs(swing_yaw(step, gait) - 0.5 * rate * parameters.period) < EXACT


@given(st.floats(0.1, 2.0))
def test_a_smooth_share_goes_from_nothing_to_all(span: float) -> None:
    """Without a slope at either end; all of it past the end, and at once for no span."""
    shares = [smooth_share(time, span) for time in np.linspace(0.0, span, 50)]
    assert (shares[0], shares[-1], smooth_share(2.0 * span, span), smooth_share(0.0, 0.0)) == (0.0, 1.0, 1.0, 1.0)
    assert (np.diff(shares) > 0.0).all()
    assert shares[1] < 0.002
    assert shares[-2] > 0.998


@given(gaits, seeds, st.floats(0.05, 0.95), st.floats(-2.0, 2.0))
def test_a_moving_foothold_is_followed(parameters: GaitParameters, seed: int, share: float, rate: float) -> None:
    """Velocity and acceleration are those of the curve, linear in its end, whose end moves aside at a steady rate."""
    gait, (step, foothold) = make_gait_inputs(parameters), a_step(seed)
    now, aside = share * parameters.period, np.array([0.0, 1.0])
    found, still = swing_at(step, gait, foothold, now), swing_at(step, gait, foothold, now)
    slope = swing_at(step, gait, foothold + aside, now) - still
    before, after = (swing_at(step, gait, foothold + rate * dt * aside, now + dt)[0] for dt in (-JOIN, JOIN))
    step.time[0] = step.place[0] = now
    follow_foothold(step, gait, 0.5, rate, np.zeros(3), found)
    np.testing.assert_allclose(found[1], (after - before) / (2.0 * JOIN), atol=1e-3)
    np.testing.assert_allclose(found - still, rate * np.vstack([0.0 * slope[0], slope[0], 2.0 * slope[1]]), atol=EXACT)
