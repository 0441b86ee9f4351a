"""From a neighbour, else from nothing: said which, and nothing that was spent is lost."""

from dataclasses import replace

import numpy as np
import pytest

from gaitsmith.synthesis.requests.nearby import plan_nearby
from gaitsmith.synthesis.solution.plan import PlanResult

SOLVED = PlanResult("solved", "", 0, {}, gait=object(), iterations=5)
FAILED = PlanResult("not solved", "no solution", 0, {}, iterations=7, fallbacks=2)


class Answers:
    """A planner that says what it is told to say."""

    def __init__(self, near, cold):
        self.near, self.cold, self.asked = near, cold, []

    def plan(self, motion, settings, neighbour=None):
        self.asked.append(neighbour)
        return self.cold if neighbour is None else self.near


def test_a_neighbour_with_another_number_of_unknowns_gives_no_start_and_is_not_named_as_one():
    planner = Answers(replace(SOLVED, variables=12), FAILED)
    found, came = plan_nearby(planner, None, None, replace(SOLVED, gait=None, x=np.zeros(10)))
    assert (found.gait is not None, came, len(planner.asked)) == (True, False, 1)


@pytest.mark.parametrize(
    ("near", "cold", "neighbour", "asked", "spent"),
    [
        (SOLVED, FAILED, SOLVED, 1, (True, True, 5, 0)),
        (FAILED, SOLVED, SOLVED, 2, (True, False, 12, 3)),
        (FAILED, FAILED, SOLVED, 2, (False, False, 14, 5)),
        (SOLVED, FAILED, None, 1, (False, False, 7, 2)),
    ],
)
def test_a_neighbour_that_leads_nowhere_is_followed_by_a_plan_from_nothing(near, cold, neighbour, asked, spent):
    planner = Answers(near, cold)
    found, came = plan_nearby(planner, None, None, neighbour)
    assert (found.gait is not None, came, found.iterations, found.fallbacks) == spent
    assert len(planner.asked) == asked
