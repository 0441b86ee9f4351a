"""Start, stop, whole walk and kick: solved by quadratic programs alone and confirmed by MuJoCo."""

import numpy as np
import pytest

from gaitsmith.simulation import Scenario
from gaitsmith.simulation.episode import Simulation
from gaitsmith.simulation.reactions import ended_braked
from gaitsmith.synthesis import Bounds, Request, Settings, StepParameters, answer, verify
from gaitsmith.synthesis.files.gait_file import write_gait
from gaitsmith.synthesis.motions.settings import LEG
from gaitsmith.synthesis.requests.asked import KICK_FRICTION

DISTANCE = 0.03  # m from the plan
STEP = StepParameters(0.15, 1.0)


def run(gait, robot, folder, **fields):
    """Summary of a run that follows a gait."""
    path = folder / "gait.json"
    write_gait(path, gait)
    scenario = Scenario(robot="thbip_ii", gait=(str(path),), **{"duration": gait.duration + 1.0, **fields})
    return Simulation(scenario, robot=robot, record=False).run().summary


@pytest.fixture(scope="module")
def walk(planner):
    return answer(planner, Request("walk", STEP, cycles=3))


@pytest.fixture(scope="module")
def kick(planner):
    return answer(planner, Request("kick", settings=Settings(bounds=Bounds(friction=KICK_FRICTION))))


def test_walk_is_continuous_and_confirmed(walk, robot):
    assert walk.gait is not None, walk.main.reason
    assert set(walk.results) == {"cyclic", "start", "stop"}
    assert not any(found.fallbacks for found in walk.results.values())
    verdict = verify(walk.gait, robot, 100)
    assert verdict.ok, verdict.problems
    assert verdict.zmp_margin > 20.0


def test_walk_begins_and_ends_at_rest(walk):
    gait = walk.gait
    ends = [gait.joints(0, np.array([0.0])), gait.joints(len(gait.pieces) - 1, np.array([gait.duration]))]
    assert np.abs(ends[0][0] - ends[1][0]).max() < 1e-6
    for _, velocity, _ in ends:
        assert np.abs(velocity).max() < 1e-6


def test_walk_stands_in_physics(walk, robot, tmp_path):
    found = run(walk.gait, robot, tmp_path)
    assert not found.fell, found.fall
    tracking = found.tracking
    assert abs(tracking.distance - tracking.planned_distance) < DISTANCE
    assert max(tracking.tilt_deg.values()) < 3.0
    assert tracking.zmp_rms_mm < 15.0
    pitch = tracking.foot_pitch_deg
    assert pitch.strike == pytest.approx(pitch.planned_strike, rel=0.3)
    assert pitch.off == pytest.approx(pitch.planned_off, rel=0.3)


def test_kick_meets_the_ball_as_planned(kick, robot):
    assert kick.gait is not None, kick.main.reason
    verdict = verify(kick.gait, robot, 200)
    assert verdict.ok, verdict.problems
    assert verdict.zmp_margin > 15.0
    found = {name: value for name, wanted, value, _ in verdict.conditions if name == "ankle_vx" and wanted}
    assert abs(found["ankle_vx"] - 2.0) < 1e-5
    assert verdict.worst["ankle_x"].value < 0.141


@pytest.mark.parametrize(
    "change",
    [{}, {"mass_factor": 1.1}, {"mass_factor": 0.95}, {"friction": 0.5}, {"tracking": "replay"}],
)
def test_kick_stands_in_physics(kick, robot, tmp_path, change):
    found = run(kick.gait, robot, tmp_path, **change)
    assert not found.fell, found.fall
    ball = found.tracking.ball
    assert ball.speed == pytest.approx(ball.planned_speed, rel=0.25)


def test_replay_walks_in_physics(dynamic, robot, tmp_path):
    found = run(dynamic.gait, robot, tmp_path, cycles=20, duration=10.0, tracking="replay")
    assert not found.fell, found.fall
    assert abs(found.tracking.distance - found.tracking.planned_distance) < 4.0 * DISTANCE


def test_a_walk_s_swing_sole_keeps_clear_by_half_of_the_lift(walk, kick, planner):
    """Otherwise small errors of tracking make it land early, at another pitch than the plan's."""
    assert walk.gait.bounds["clearance"] == pytest.approx(0.5 * STEP.height)
    assert kick.gait.bounds["clearance"] == pytest.approx(Bounds().clearance * planner.biped.height / LEG)
    low = Settings(bounds=Bounds(clearance=0.001)).sized(planner.biped, 0.3, 0.04)
    assert low.bounds.clearance == 0.001


@pytest.mark.parametrize(("fault", "stands"), [("ticks:delayed@2s,1s", True), ("left_knee.motor:dead@2s,1s", False)])
def test_a_plan_goes_on_by_late_ticks_and_ends_braked_when_it_sinks(dynamic, robot, tmp_path, fault, stands):
    """A late tick moves the plan's clock by all of its time; what a motor takes away is named before the fall."""
    found = run(dynamic.gait, robot, tmp_path, cycles=20, duration=4.0, faults=(fault,))
    assert found.fell is not stands
    assert stands or ended_braked(found.faults, found.fall.time)
