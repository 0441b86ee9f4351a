"""Plans of the paper's cyclic gaits: certified, confirmed by MuJoCo, explained when they fail."""

import numpy as np
import pytest

from gaitsmith.errors import BadInput
from gaitsmith.synthesis import Bounds, Request, Settings, StepParameters, answer, verify
from gaitsmith.synthesis.motions.biped import standing
from gaitsmith.synthesis.motions.catalogue import cyclic, kick
from gaitsmith.synthesis.motions.motion import At, Motion, Phase
from gaitsmith.synthesis.motions.parameters import KickParameters
from gaitsmith.synthesis.program.guess import default_start
from gaitsmith.synthesis.program.program import make_program
from gaitsmith.synthesis.program.transcription import Transcription
from gaitsmith.synthesis.solution.ipopt import Progress, Solution
from gaitsmith.synthesis.solution.sqp import solve_sqp

ALLOWED = 1e-3  # share of a bound's range, between the points too
SAME_OPTIMUM = 1e-3


@pytest.mark.parametrize("name", ["static", "dynamic"])
def test_cyclic_gaits_are_certified_and_physics_agrees(name, request, robot):
    found = request.getfixturevalue(name)
    assert found.gait is not None, found.main.reason
    assert found.main.worst[0].violation <= ALLOWED
    verdict = verify(found.gait, robot)
    assert verdict.ok, verdict.problems
    # A tenth of what is allowed is the goal of the closure.
    assert verdict.closure["position_mm"] < 0.01
    assert verdict.closure["velocity"] < 0.0005
    assert verdict.closure["acceleration"] < 0.05
    assert verdict.torque_jump < 0.01
    assert verdict.dynamics_residual < 1e-6
    assert verdict.zmp_margin > 20.0


def test_the_planners_certificate_is_the_verifiers(dynamic, robot):
    verdict = verify(dynamic.gait, robot, dense=dynamic.gait.certificate["dense_points"])
    for item in dynamic.main.worst:
        assert abs(item.violation - verdict.worst[item.constraint].violation) < 1e-6


def test_neighbours_start_warm(planner, dynamic):
    motion = cyclic(planner.biped, StepParameters(0.205, 0.5))
    warm = planner.plan(motion, neighbour=dynamic.main)
    cold = planner.plan(motion)
    assert warm.solved
    assert warm.iterations < cold.iterations
    assert abs(warm.objective - cold.objective) < SAME_OPTIMUM * cold.objective


@pytest.mark.parametrize("seed", [1, 2])
def test_random_starts_find_the_same_optimum(planner, static, seed):
    motion, settings = cyclic(planner.biped, StepParameters(0.15, 1.0)), Settings().sized(planner.biped, 0.3)
    trans = Transcription(planner.biped, motion, settings)
    start, moved = default_start(trans), planner.biped.joints * trans.spline.size
    start[:moved] += np.random.default_rng(seed).uniform(-0.1, 0.1, moved)
    found = planner.plan(motion, settings, start=start)
    assert found.solved, found.reason
    assert abs(found.objective - static.main.objective) < SAME_OPTIMUM * static.main.objective


def test_the_papers_quartic_solves_and_its_torque_jumps(planner, robot, dynamic):
    found = answer(planner, Request("cyclic", StepParameters(0.20, 0.5), settings=Settings(order=4)))
    assert found.gait is not None, found.main.reason
    verdict = verify(found.gait, robot)
    assert verdict.dynamics_residual < 1e-6
    assert verdict.torque_jump > 100.0 * verify(dynamic.gait, robot).torque_jump


def test_the_working_folder_has_no_say(planner, static, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ipopt.opt").write_text("max_cpu_time 1e-3\n")
    start = 0.5 * static.main.x  # from a start that is given IPOPT comes first
    found = planner.plan(static.main.gait.motion, start=start)
    assert found.status == "solved", found.reason


@pytest.mark.parametrize("given", [False, True])
def test_a_slower_method_counts_from_the_first_step_on_unless_it_was_asked_for(planner, static, monkeypatch, given):
    calls = []

    def failing(program, start, last, *more):
        calls.append(program)
        if not given and len(calls) == 1:
            return Solution(start, False, "Quadratic_Program_Failed", 0, 0.0, np.zeros(program.rows))
        return solve_sqp(program, start, last, *more)

    monkeypatch.setattr("gaitsmith.synthesis.solution.plan.solve_sqp", failing)
    found = planner.plan(static.main.gait.motion, start=static.main.x if given else None)
    assert found.solved, found.reason
    assert static.main.fallbacks == 0
    assert found.fallbacks == (0 if given else 1)


def test_a_budget_that_is_spent_decides_nothing(planner):
    found = planner.plan(cyclic(planner.biped, StepParameters(0.15, 1.0)), Settings(max_iterations=6))
    assert found.status == "not decided"
    assert found.gait is None
    assert "not decided after 6 iterations" in found.reason
    assert found.iterations <= 6


@pytest.mark.parametrize("step", [StepParameters(0.8, 1.0)])
def test_steps_that_no_leg_reaches_are_refused_unsolved(planner, step):
    found = planner.plan(cyclic(planner.biped, step))
    assert (found.status, found.iterations) == ("not solved", 0)
    assert "the legs reach" in found.reason


@pytest.mark.parametrize("ball", [(-0.019, 0.065), (0.15, 0.065)])
def test_balls_where_no_kick_can_meet_them_are_refused_unsolved(planner, ball):
    motion = kick(planner.biped, KickParameters(ball=ball), standing(planner.biped))
    found = planner.plan(motion)
    assert (found.status, found.iterations) == ("not solved", 0)
    assert "ankle_x" in found.reason


def _stand(planner, *conditions):
    half = planner.biped.width / 2.0
    return Motion("stand", (Phase("stand", 0.6, "right", "flat", (0.0, -half), (0.0, half), 2),), conditions)


def test_a_period_too_short_names_torques_and_velocities(planner):
    found = planner.plan(cyclic(planner.biped, StepParameters(0.1, 0.1)), Settings())
    assert not found.solved
    assert "it would take" in found.reason
    assert " torque " in found.reason or " velocity " in found.reason


def test_margins_wider_than_the_sole_are_refused(planner):
    with pytest.raises(BadInput, match="half of this robot's sole"):
        planner.plan(cyclic(planner.biped, StepParameters(0.15, 1.0)), Settings(bounds=Bounds(zmp_margin=0.045)))


def test_conditions_that_contradict_each_other_are_named(planner):
    found = planner.plan(_stand(planner, At(0, "hip_height", 0.35), At(0, "hip_height", 0.36)))
    assert not found.solved
    assert "do not hold together" in found.reason
    assert "hip_height" in found.reason


def test_progress_is_told_and_an_interrupt_ends_the_solve(planner):
    seen: list[Progress] = []

    def stop(_: int, progress: Progress) -> None:
        seen.append(progress)
        if len(seen) == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        planner.plan(cyclic(planner.biped, StepParameters(0.15, 1.0)), report=stop)
    assert len(seen) == 3
    assert seen[0].constraint


def test_rows_have_the_derivatives_that_the_solver_is_given(planner):
    from gaitsmith.synthesis.program.derivatives import Derivatives

    trans = Transcription(planner.biped, cyclic(planner.biped, StepParameters(0.15, 1.0)), Settings())
    program = make_program(trans, planner.functions, trans.points())
    x = default_start(trans) + 0.05 * np.random.default_rng(0).normal(size=trans.size)
    gradient, _, jacobian = Derivatives(program).first_order(x)
    direction = np.random.default_rng(1).normal(size=trans.size)
    h, values = 1e-6, []
    for sign in (1.0, -1.0):
        z, o = program.evaluate(x + sign * h * direction)
        values.append((program.cost(z, o), program.constraint(x + sign * h * direction, o)))
    slope = (values[0][1] - values[1][1]) / (2 * h)
    assert np.abs(slope - jacobian @ direction).max() < 1e-4 * max(1.0, np.abs(slope).max())
    change = program.scale * (values[0][0] - values[1][0]) / (2 * h)
    assert abs(change - gradient @ direction) < 1e-4 * abs(change)


def test_feet_further_apart_than_the_legs_reach_are_refused_before_solving(planner):
    found = planner.plan(cyclic(planner.biped, StepParameters(0.9, 1.0)))
    assert found.status == "not solved"
    assert found.iterations == 0
    assert "the legs reach" in found.reason
