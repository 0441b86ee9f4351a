"""A gait input is declared once: whatever names it follows from its field in the gait's parameters."""

from __future__ import annotations

from typing import Any

import pytest

from gaitsmith.errors import BadInput
from gaitsmith.robots import load_robot
from gaitsmith.robots.parameters import GAIT_INPUTS, GaitLimits, GaitParameters, at_rest, check_gait, gait_numbers
from gaitsmith.simulation.scenario import Change, Scenario
from gaitsmith.simulation.summary import StageCommand

GAIT = load_robot("thbip_ii").card.gait.model_dump()
LIMITS = load_robot("thbip_ii").card.gait_limits


def test_every_name_of_an_input_follows_from_its_declaration() -> None:
    numbers = [part for part, _, _ in gait_numbers(GAIT)]
    assert list(GAIT_INPUTS) == list(GaitParameters.model_fields)
    assert list(GaitLimits.model_fields) == numbers
    assert list(StageCommand.model_fields) == [key for key, _, _ in gait_numbers(GAIT, keys=True)]
    for model in (Scenario, Change):
        assert list(model.model_fields)[: len(GAIT_INPUTS)] == list(GAIT_INPUTS)
    assert all(about.meaning and about.metavar for about in GAIT_INPUTS.values())


@pytest.mark.parametrize("part", GaitLimits.model_fields)
def test_every_number_is_checked_against_its_own_limits(part: str) -> None:
    """Both ends are valid, what lies beyond is refused under the input's name."""
    place = next(place for name, place, _ in gait_numbers(GAIT) if name == part)
    name, _, index = place.rstrip("]").partition("[")

    def given(value: float) -> dict[str, Any]:
        return {name: tuple(value if k == int(index) else 0.0 for k in range(2)) if index else value}

    low, high = getattr(LIMITS, part)
    check_gait(given(low), LIMITS)
    check_gait(given(high), LIMITS)
    for value in (low - 1e-9, high + 1e-9, float("nan")):
        with pytest.raises(BadInput) as caught:
            check_gait(given(value), LIMITS, "changes[3].")
        assert caught.value.field == f"changes[3].{place}"


@pytest.mark.parametrize("value", [None, True, "fast", (0.1,), (0.1, 0.2, 0.3), [[0.1, 0.2]], {}])
def test_only_numbers_are_gait_inputs(value: object) -> None:
    for name in GAIT_INPUTS:
        with pytest.raises(BadInput, match=name):
            check_gait({name: value}, LIMITS)
    with pytest.raises(BadInput, match="one of speed"):
        check_gait({"sped": 0.1}, LIMITS)


def test_at_rest_nothing_moves_and_the_rest_stays() -> None:
    moving = {**GAIT, "speed": (0.2, 0.1), "yaw_rate": 0.3, "height": 0.35}
    assert at_rest(moving) == {**moving, "speed": (0.0, 0.0), "yaw_rate": 0.0}


def test_limits_without_yaw_rate_mean_legs_that_cannot_turn() -> None:
    limits = LIMITS.model_dump()
    del limits["yaw_rate"]
    with pytest.raises(BadInput, match="expected 0 only; the legs cannot turn"):
        check_gait({"yaw_rate": 0.1}, GaitLimits(**limits))
