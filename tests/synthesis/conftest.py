"""One planner and the paper's two cyclic gaits, solved once for all tests."""

import pytest

from gaitsmith.robots import load_robot
from gaitsmith.synthesis import Planner, Request, StepParameters, answer
from gaitsmith.synthesis.files.motion_file import read_motion


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


@pytest.fixture(scope="session")
def suited_planner(planner):
    """A planner, not compiled, for the kind of motion that a file holds."""

    def made(path):
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("GAITSMITH_CC", "none")  # a compiler takes longer than it saves here
            found = Planner(planner.biped.robot).suited(read_motion(path, planner.biped)[0])
            assert found.functions.compiled is False
            return found

    return made
