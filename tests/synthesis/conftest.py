"""One planner and the paper's two cyclic gaits, solved once for all tests."""

import pytest

from gaitsmith.robots import load_robot
from gaitsmith.synthesis import Planner, Request, StepParameters, answer


@pytest.fixture(scope="session")
def robot():
    return load_robot("thbip_ii")


@pytest.fixture(scope="session")
def planner(robot):
    return Planner(robot)


@pytest.fixture(scope="session")
def static(planner):
    return answer(planner, Request("cyclic", StepParameters(0.15, 1.0)))


@pytest.fixture(scope="session")
def dynamic(planner):
    return answer(planner, Request("cyclic", StepParameters(0.20, 0.5)))
