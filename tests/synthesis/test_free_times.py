"""The search over phase times: it only goes downhill, stays in its ranges, and passes over what has no plan."""

from types import SimpleNamespace
from typing import Any

from gaitsmith.synthesis.motions.catalogue import StepParameters
from gaitsmith.synthesis.requests.free_times import freed


def _planner(cost, missing=lambda step: False):
    asked: list[StepParameters] = []

    def plan(step: StepParameters, neighbour: Any) -> Any:
        asked.append(step)
        assert neighbour.gait is not None
        gait = None if missing(step) else object()
        return SimpleNamespace(objective=cost(step), gait=gait)

    return plan, asked


def _cost(step):
    return 100.0 + 50.0 * (step.swing_split - 0.62) ** 2 + 30.0 * (step.toe_share - 0.45) ** 2 - 5.0 * step.toe_off


def _search(missing=lambda step: False):
    plan, asked = _planner(_cost, missing)
    first = SimpleNamespace(objective=_cost(StepParameters(0.2, 0.5)), gait=object())
    return *freed(StepParameters(0.2, 0.5), first, plan), asked


def test_the_search_nears_the_least_cost_within_its_ranges():
    step, found, asked = _search()
    assert abs(step.swing_split - 0.62) < 0.03
    assert abs(step.toe_share - 0.45) < 0.05
    assert step.toe_off == 0.5  # the end of its range
    assert found.objective == _cost(step)
    assert all(tried.heel_share + tried.toe_share < 0.9 and tried.toe_off <= 0.5 for tried in asked)
    assert len(asked) < 60


def test_steps_without_a_plan_are_passed_over():
    step, _, _ = _search(missing=lambda tried: tried.swing_split > 0.55)
    assert step.swing_split <= 0.55
    assert abs(step.toe_share - 0.45) < 0.05
