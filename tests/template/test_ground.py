"""A slope is felt where a sole has lain on it; what is told of the ground goes before what is felt."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.template.steps import OMEGA, a_step, at, forecast, inputs

from gaitsmith.simulation.episode import Simulation
from gaitsmith.simulation.scenario import make_scenario
from gaitsmith.template.ground import feel_slope, find_pivot, make_ground, plan_landing, share_of_way, stand_on

slopes = st.floats(-0.3, 0.3)
SOLE = (0.07, 0.12, 0.03, 0.01)  # m: heel, toe, half width, margin


@given(slopes, st.floats(0.0, 0.3))
def test_the_slope_is_that_of_the_sole_at_its_flattest(slope: float, tipped: float) -> None:
    """A sole that tips over its edge for a part of each step changes nothing; the estimate converges."""
    gait, ground = inputs(), make_ground()
    step = a_step(gait)
    for count in range(12):
        step.count[0] = count
        for time in np.linspace(0.0, gait.period[0], 20):
            late = time > 0.8 * gait.period[0]
            feel_slope(ground, at(step, time), slope + (math.copysign(tipped, slope) if late else 0.0))
    assert ground.pitch[0] == pytest.approx(slope, abs=abs(slope) * 2.0**-9 + 1e-12)


@given(slopes, st.floats(-0.2, 0.2))
def test_a_felt_slope_is_a_plane_through_the_stance_sole(slope: float, ahead: float) -> None:
    ground, step = make_ground(), at(a_step(inputs()), 10.0)
    ground.pitch[0] = slope
    out = np.array([ahead, 0.1])
    plan_landing(ground, step, forecast(), OMEGA, np.zeros(2), np.zeros(2), out)
    assert ground.rise[0] == pytest.approx(-math.tan(slope) * ground.planned[0])
    assert ground.highest[0] == max(ground.rise[0], 0.0)
    np.testing.assert_array_equal(out, [ahead, 0.1])


@given(slopes, st.integers(1, 5))
def test_what_was_told_is_believed_for_its_ticks_and_no_longer(slope: float, ticks: int) -> None:
    ground, step = make_ground(), at(a_step(inputs()), 10.0)
    ground.pitch[0], ground.known[0] = slope, ticks
    ground.shift[:], ground.rise[0], ground.highest[0] = (0.02, -0.01), 0.07, 0.09
    for tick in range(ticks + 1):
        out = np.array([0.1, 0.1])
        plan_landing(ground, step, forecast(), OMEGA, np.zeros(2), np.zeros(2), out)
        if tick < ticks:
            assert (ground.rise[0], ground.highest[0]) == (0.07, 0.09)
            np.testing.assert_allclose(out, [0.12, 0.09])
    np.testing.assert_array_equal(out, [0.1, 0.1])
    assert ground.rise[0] == pytest.approx(-math.tan(slope) * 0.1)


def test_a_climb_is_lifted_before_it_goes_ahead() -> None:
    """Half of the way by αT on level ground; none before a climb as high as the lift; more before a drop."""
    assert [share_of_way(0.0, 0.0, high, 0.1) for high in (-0.1, 0.0, 0.05, 0.1, 0.2)] == [0.5, 0.5, 0.5, 0.0, 0.0]
    assert share_of_way(0.0, 0.0, 0.075, 0.1) == pytest.approx(0.25)
    assert share_of_way(0.1, 0.1, 0.1, 0.1) == share_of_way(-0.1, -0.1, -0.1, 0.1) == 0.5
    assert 0.5 < share_of_way(0.1, 0.05, 0.1, 0.1) < share_of_way(0.1, 0.0, 0.1, 0.1) < 1.0
    assert share_of_way(0.1, -0.1, 0.2, 0.1) == share_of_way(0.1, -0.1, 0.1, 0.1)  # lifted for the drop: no climb


@given(st.floats(-0.3, 0.3), st.floats(-0.05, 0.05), st.booleans())
def test_a_moved_sole_bears_where_it_would_have_been(ahead: float, aside: float, known: bool) -> None:
    """As far as it reaches there; the next landing is told from the sole, whose pivot the pendulum stands on."""
    ground, step = make_ground(), at(a_step(inputs()), 0.0)
    ground.known[0], ground.shift[:] = int(known), (ahead, aside)
    stand_on(ground, 0.0, 0.6)
    find_pivot(ground, step, 0.0, *SOLE)
    wanted = (min(max(-ahead, -0.06), 0.11), min(max(-aside, -0.02), 0.02)) if known else (0.0, 0.0)
    np.testing.assert_allclose(ground.pivot, wanted)
    ground.known[0], out = 0, np.array([0.1, 0.1])
    plan_landing(ground, at(step, 10.0), forecast(), OMEGA, np.zeros(2), np.zeros(2), out)
    np.testing.assert_allclose(ground.planned, 0.1 + ground.pivot)


@given(slopes, st.floats(-0.3, 0.3), slopes)
def test_a_sole_whose_heel_drops_bears_at_its_toe(landed: float, turned: float, slope: float) -> None:
    """One whose toe drops, that lies still on a slope, or that comes to lie after its toe, bears where it did."""
    ground, step = make_ground(), a_step(inputs())
    ground.pitch[0] = slope
    stand_on(ground, 0.0, 0.6)
    find_pivot(ground, at(step, 0.0), landed, *SOLE)
    find_pivot(ground, at(step, 0.2 * step.period[0]), landed + turned, *SOLE)
    below = landed + turned - min(landed, slope)
    assert -0.06 - 1e-12 <= ground.pivot[0] <= 0.11 + 1e-12
    assert ground.pivot[0] == pytest.approx(min(max(0.095 * (-below - 0.03) / 0.1, 0.0), 0.11))


def test_a_stumble_lifts_the_next_steps() -> None:
    """By as much as the landing was higher than planned, less with every step; even ground is none."""
    ground, step = make_ground(), at(a_step(inputs()), 10.0)
    found = []
    for climbed in (0.01, 0.06, 0.0, 0.0):
        stand_on(ground, climbed, 0.6)
        plan_landing(ground, step, forecast(), OMEGA, np.zeros(2), np.zeros(2), np.zeros(2))
        found.append(float(ground.highest[0]))
    assert found[:2] == pytest.approx([0.0, 0.06])
    assert found[1] > found[2] > found[3] > 0.0
    assert ground.rise[0] == 0.0


@given(st.floats(-0.2, 0.2), slopes, st.floats(0.05, 0.2))
def test_a_slope_across_is_learnt_from_both_sides(across: float, ahead: float, beside: float) -> None:
    """From landings on it to the left and to the right; then the landings come at the heights that are expected."""
    ground, step = make_ground(), at(a_step(inputs()), 10.0)
    ground.pitch[0] = ahead
    for k in range(40):
        place = np.array([0.1, beside if k % 2 else -beside])
        plan_landing(ground, step, forecast(), OMEGA, np.zeros(2), np.zeros(2), place)
        stand_on(ground, across * place[1] - math.tan(ahead) * place[0], 0.7)
    assert ground.across[0] == pytest.approx(across, abs=1e-4)


@pytest.mark.parametrize("heights", [(0.05, 0.0), (0.05, 0.05), (0.0, -0.05), (-0.05, -0.05)])
def test_steps_up_and_down_are_no_slope_across(heights: tuple[float, float]) -> None:
    ground, step = make_ground(), at(a_step(inputs()), 10.0)
    for k in range(24):
        plan_landing(ground, step, forecast(), OMEGA, np.zeros(2), np.zeros(2), np.array([0.1, -0.1 + 0.2 * (k % 2)]))
        stand_on(ground, heights[k % 2], 0.7)
    assert ground.across[0] == 0.0


def test_a_slope_across_hardly_turns_a_robot_that_cannot_turn_itself() -> None:
    """14 s on 8 degrees: it turned by a radian, in long steps downhill and short ones uphill, before it was learnt."""
    simulation = Simulation(
        make_scenario({"terrain": "cross:8", "speed": [0.325, 0.0], "duration": 14.0}), record=False
    )
    simulation.run()
    assert simulation.fall is None
    assert simulation.plant.truth.torso[1] > -0.6
    assert abs(simulation.plant.truth.attitude[2]) < 0.6
