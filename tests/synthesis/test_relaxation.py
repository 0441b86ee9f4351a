"""The default bound of torque rates: relaxed where it leaves no gait, and said; a user's bound is kept."""

import pytest

from gaitsmith.synthesis import Request, Settings, StepParameters, answer
from gaitsmith.synthesis.motions.catalogue import cyclic
from gaitsmith.synthesis.motions.settings import Bounds
from gaitsmith.synthesis.program.transcription import Transcription
from gaitsmith.synthesis.requests.summary import largest_torque_rate, plan_document
from gaitsmith.synthesis.solution import plan
from gaitsmith.synthesis.solution.relaxation import Before, Relaxation


@pytest.fixture
def relaxation(planner):
    def made(bounds):
        motion = cyclic(planner.biped, StepParameters(0.15, 1.0))
        found = Relaxation(
            Transcription(planner.biped, motion, Settings(bounds=bounds).sized(planner.biped, motion.transfer))
        )
        found.before = Before([], None, None)
        return found

    return made


def test_a_default_grows_step_by_step_and_is_still_a_default_then(relaxation):
    found = relaxation(Bounds())
    bounds = [found.default]
    for _ in range(3):
        assert found.restart() is not None
        bounds.append(found.trans.settings.bounds.torque_rate)
        found.before = Before([], None, None)
    assert bounds == sorted(set(bounds))
    assert found.allowed
    assert found.relaxed


def test_a_users_bound_is_never_relaxed(relaxation):
    found = relaxation(Bounds(torque_rate=150.0))
    assert found.restart() is None
    assert not any(found.accepts(160.0, True) for _ in range(20))
    assert found.trans.settings.bounds.torque_rate == 150.0
    assert not found.relaxed


def test_rates_that_stay_beyond_the_default_move_it_to_what_they_reach(relaxation):
    found = relaxation(Bounds())
    largest = 1.3 * found.default
    tries = [found.accepts(largest, False) for _ in range(6)]
    assert not tries[0]
    assert True in tries
    assert largest <= found.trans.settings.bounds.torque_rate < 1.5 * largest


def test_a_step_without_a_gait_within_the_default_is_planned_and_told(planner):
    found = answer(planner, Request("cyclic", StepParameters(0.202, 1.159, 0.064, 0.533)))
    document = plan_document(found, "cyclic", planner.biped, None)
    assert document["verified"]
    assert document["torque_rate_bound"] > found.main.default_rate
    assert largest_torque_rate(found.gait) <= document["torque_rate_bound"]
    assert "torque rates of cyclic" in document["warnings"][0]


@pytest.mark.parametrize("given", [False, True])
def test_a_default_within_which_no_round_certifies_is_relaxed_too(planner, monkeypatch, given):
    """As long as the first bound of torque rates is in use, another bound is exceeded between the points."""
    restart, excess, relaxed = Relaxation.restart, plan.worst_excess, []

    def noted(self):
        found = restart(self)
        relaxed.extend([] if found is None else [self.trans.settings.bounds.torque_rate])
        return found

    monkeypatch.setattr(Relaxation, "restart", noted)
    monkeypatch.setattr(plan, "worst_excess", lambda checks: excess(checks) if relaxed else max(excess(checks), 0.01))
    motion, bounds = cyclic(planner.biped, StepParameters(0.20, 0.5)), Bounds(torque_rate=600.0) if given else Bounds()
    found = planner.plan(motion, Settings(refinements=2, bounds=bounds))
    assert found.status == ("not certified" if given else "solved"), found.reason
    assert bool(relaxed) != given
    if not given:
        assert found.default_rate < relaxed[0] <= found.gait.bounds["torque_rate"]


def test_a_relaxed_bound_goes_with_rates_that_no_round_had_looked_at(relaxation, planner, dynamic):
    made, found = dynamic.main.gait, relaxation(Bounds())
    largest = largest_torque_rate(made)
    found.default = 0.1 * largest
    assert found.accepts(0.9 * largest, True)
    gait, steep = found.settled(made, planner.biped.names, 241)
    assert gait.bounds["torque_rate"] == found.trans.settings.bounds.torque_rate >= largest
    assert max(item.violation for item in steep.values()) < 0.0
    strict = relaxation(Bounds(torque_rate=0.9 * largest))
    kept, steep = strict.settled(made, planner.biped.names, 241)
    assert kept is made, "a user's bound stays"
    assert max(item.violation for item in steep.values()) > 0.0
