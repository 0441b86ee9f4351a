"""Start, stop, whole walk and kick: solved from the default start and confirmed by MuJoCo."""

import numpy as np
import pytest

from gaitsmith.synthesis import Bounds, Request, Settings, StepParameters, answer, verify
from gaitsmith.synthesis.proof.replay import ReplaySettings, replay
from gaitsmith.synthesis.requests.request import KICK_FRICTION

DISTANCE = 0.03  # m from the plan
STEP = StepParameters(0.15, 1.0)


@pytest.fixture(scope="module")
def walk(planner):
    return answer(planner, Request("walk", STEP, cycles=3))


@pytest.fixture(scope="module")
def kick(planner):
    return answer(planner, Request("kick", settings=Settings(bounds=Bounds(friction=KICK_FRICTION))))


def test_walk_is_continuous_and_confirmed(walk, robot):
    assert walk.gait is not None, walk.main.reason
    assert set(walk.results) == {"cyclic", "start", "stop"}
    verdict = verify(walk.gait, robot, 100)
    assert verdict.ok, verdict.problems
    assert verdict.zmp_margin > 20.0


def test_walk_begins_and_ends_at_rest(walk):
    gait = walk.gait
    ends = [gait.joints(0, np.array([0.0])), gait.joints(len(gait.pieces) - 1, np.array([gait.duration]))]
    assert np.abs(ends[0][0] - ends[1][0]).max() < 1e-6
    for _, velocity, _ in ends:
        assert np.abs(velocity).max() < 1e-6


def test_walk_stands_in_physics(walk, robot):
    found = replay(walk.gait, robot)
    assert found.stood, found.fall
    assert abs(found.distance - found.planned_distance) < DISTANCE


def test_kick_meets_the_ball_as_planned(kick, robot):
    assert kick.gait is not None, kick.main.reason
    verdict = verify(kick.gait, robot, 200)
    assert verdict.ok, verdict.problems
    assert verdict.zmp_margin > 15.0
    found = {name: value for name, wanted, value in verdict.conditions if name == "ankle_vx" and wanted}
    assert abs(found["ankle_vx"] - 2.0) < 1e-5
    assert verdict.worst["ankle_x"].value < 0.141


@pytest.mark.parametrize(
    "change",
    [{}, {"mass_scale": 1.05}, {"mass_scale": 0.95}, {"friction": 0.5}, {"friction": 1.0}, {"gain_scale": 0.9}],
)
def test_kick_stands_in_physics(kick, robot, change):
    found = replay(kick.gait, robot, ReplaySettings(**change))
    assert found.stood, found.fall
    assert found.ball is not None
    assert found.ball["speed"] > 1.5


def test_cyclic_gait_walks_in_physics(dynamic, robot):
    found = replay(dynamic.gait, robot, steps=20)
    assert found.stood, found.fall
    assert abs(found.distance - found.planned_distance) < DISTANCE
