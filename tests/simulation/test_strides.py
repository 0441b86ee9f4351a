"""Steps are timed as they were taken, and a push is recovered from once every stride that follows is calm."""

from __future__ import annotations

import numpy as np
import pytest
from tests.experiments.made_up import made_up_summary
from tests.simulation.standing import robot

from gaitsmith.log.columns import Columns
from gaitsmith.simulation.scenario import Scenario, make_scenario
from gaitsmith.simulation.stage_table import stride_lines
from gaitsmith.simulation.stages import ENTERED, LEFT
from gaitsmith.simulation.strides import CALM, Strides
from gaitsmith.simulation.summary import StepTimes

DT, STEP, HEIGHT = 1e-2, 40, 0.7
NAMES = ["mode", "step_count", "command.height", "command.speed_x", "command.speed_y"]
PUSHES = [{"time": 1.0, "impulse": [10.0, 0.0, 0.0]}, {"time": 4.0, "impulse": [10.0, 0.0, 0.0]}]
LIMIT = CALM * np.sqrt(9.81 * HEIGHT)


def _walk(
    speeds: list[float], pushed: dict[int, int], scenario: Scenario, told_of_plan: dict[int, str] | None = None
) -> Strides:
    """A walk at 0.3 m/s of whole steps, each with a mean error of speed, m/s; pushes begin with some of them."""
    told, true = np.array([1.0, 0.0, HEIGHT, 0.3, 0.0]), np.zeros(3)
    columns = Columns((NAMES, told), ([f"true.com_velocity_{axis}" for axis in "xyz"], true))
    strides = Strides(columns, "true.", scenario, DT, robot(), {"speed": (0.3, 0.0)})
    if scenario.gait:
        told[3] = 0.0  # what is latched is no plan's
    for count, error in enumerate([*speeds, 0.0]):
        told[1] = count
        for tick in range(STEP + 5 * (count == 2)):
            true[:2] = 0.3 + error + 0.2 * np.cos(2.0 * np.pi * tick / STEP), 0.0
            strides.observe(tick)
            if tick == 0 and told_of_plan and count in told_of_plan:
                strides.hear({"time": 0.0, "plan": told_of_plan[count]})
            if tick == 0 and count in pushed:
                strides.hear({"time": 0.0, "push": pushed[count]})
    return strides


def test_steps_are_timed():
    times = _walk([0.0] * 6, {}, make_scenario({})).report(False)["step_time"]
    assert (times.min, times.max) == (pytest.approx(0.40), pytest.approx(0.45))
    assert times.mean == pytest.approx((5 * 0.40 + 0.45) / 6)


def test_a_push_is_over_with_the_first_calm_stride_that_no_other_follows():
    speeds = [0.0, 0.0, 0.0, 3.0 * LIMIT, 3.0 * LIMIT, -3.0 * LIMIT, 0.5 * LIMIT, 0.0, 0.0, 4.0 * LIMIT, 4.0 * LIMIT]
    strides = _walk(speeds, {3: 0, 9: 1}, make_scenario({"pushes": PUSHES}))
    first, second = strides.report(False)["recovered"]
    # the stride of 3 and −3 is calm by chance, that of −3 and 0.5 is not: calm since the one that ends with step 7
    assert first == pytest.approx(5 * 0.40, abs=0.02)
    assert second is None
    assert strides.report(True)["recovered"] == (first, None)


def test_lines_say_what_became_of_every_push():
    times = StepTimes(mean=0.36, min=0.2, max=0.4)
    summary = made_up_summary(pushes=(1.0, 4.0, None), recovered=(0.5, None, None), step_time=times)
    assert stride_lines(summary) == [
        "steps of 0.360 s, from 0.200 to 0.400 s",
        "push 1 at 1.00 s, recovered from after 0.50 s",
        "push 2 at 4.00 s, not recovered from",
        "push 3 never began",
    ]
    assert stride_lines(made_up_summary()) == []


def test_a_fall_is_no_recovery_and_a_plan_without_a_loop_has_no_strides():
    scenario = make_scenario({"pushes": PUSHES[:1]})
    assert _walk([0.0] * 8, {3: 0}, scenario).report(True)["recovered"] == (None,)
    planned = _walk([0.0] * 8, {}, Scenario(gait=("made_up.json",)), {7: LEFT})
    assert planned.report(False) == {"recovered": (), "step_time": None}


def test_strides_of_a_plan_are_those_of_its_loop():
    """Slow ones in front of it and behind it are as they should be; in it the plan's speed is what counts."""
    scenario = Scenario(gait=("made_up.json",), pushes=make_scenario({"pushes": PUSHES[:1]}).pushes)
    slow = [-0.2, -0.1]
    speeds = [*slow, 0.0, 0.0, 0.0, 3.0 * LIMIT, 3.0 * LIMIT, 0.0, 0.0, 0.0, 0.0, *reversed(slow)]
    found = _walk(speeds, {5: 0}, scenario, {2: ENTERED, 11: LEFT}).report(False)
    assert found["recovered"] == (pytest.approx(4 * 0.40, abs=0.02),)
    assert found["step_time"].min == pytest.approx(0.40)
    never = _walk([0.0] * 4 + [3.0 * LIMIT] * 6, {3: 0}, scenario, {1: ENTERED})
    assert never.report(False)["recovered"] == (None,)
