"""A planned gait in closed loop with physics: speed, balance, events, and what is refused meanwhile."""

import sys

import numpy as np
import pytest
from numba.core.runtime import _nrt_python, rtsys

from gaitsmith.control import Controller
from gaitsmith.errors import BadInput
from gaitsmith.simulation import Simulation, run_episode
from gaitsmith.simulation.planned_run import Tracked, completed
from gaitsmith.simulation.plant import Plant
from gaitsmith.simulation.scenario import make_scenario
from gaitsmith.synthesis.files.gait_file import write_gait
from gaitsmith.synthesis.gaits.walkable import walkable
from gaitsmith.whole_body.reference import NONE

UPRIGHT = 0.9  # cosine of the torso's tilt


@pytest.fixture(scope="module")
def controller(robot):
    return Controller(robot)


@pytest.fixture(scope="module")
def plan(dynamic, robot):
    return walkable([dynamic.gait], robot)


def run(controller, plan, duration, push=None, tracking="whole-body", **conditions):
    """Least cosine of the tilt, forward distance, and the controller."""
    plant = Plant(controller.robot, **conditions)
    plant.reset(*plan.start)
    controller.reset()
    controller.load(plan, tracking)
    controller.follow()
    begin, least = float(plant.q[0]), 1.0
    for tick in range(round(duration / plant.control_step)):
        plant.measure(controller.measurement)
        torque = controller.tick()
        if push is not None:
            time, impulse = push
            plant.push(np.array(impulse) / 0.1 if time <= tick * plant.control_step < time + 0.1 else np.zeros(3))
        plant.step(torque)
        x, y = plant.q[4:6]
        least = min(least, 1.0 - 2.0 * (x * x + y * y))
        if least < UPRIGHT:
            break
    return least, float(plant.q[0]) - begin


def test_the_planned_gait_walks_as_fast_as_planned_and_the_events_are_counted(controller, plan):
    least, distance = run(controller, plan, 6.0)
    assert least > UPRIGHT
    assert distance == pytest.approx(6.0 * plan.speed, rel=0.02)
    assert controller.telemetry.step_count[0] == pytest.approx(12, abs=1)
    assert controller.state == "following"


def test_the_stage_of_a_planned_walk_is_measured_over_whole_strides(dynamic, robot, controller, tmp_path):
    write_gait(tmp_path / "gait.json", dynamic.gait)
    scenario = make_scenario(completed({"gait": [str(tmp_path / "gait.json")], "duration": 5.3}))
    stage = run_episode(scenario, robot=robot, controller=controller, record=False).summary.stages[-1]
    assert stage.scored[1] - stage.scored[0] == pytest.approx(4 * 2 * 0.5, abs=5e-3)  # an even number of strides
    assert stage.vx_mean == pytest.approx(0.4, rel=0.01)


def test_what_watches_a_plan_leaves_the_caches_to_the_tick(dynamic, robot, controller, tmp_path):
    """While all soles bear, an observer of a plan calls one kernel: array work in Python made ticks a fifth longer."""
    write_gait(tmp_path / "gait.json", dynamic.gait)
    scenario = make_scenario(completed({"gait": [str(tmp_path / "gait.json")], "duration": 5.0}))
    simulation, calls = Simulation(scenario, robot=robot, controller=controller, record=False), []
    (watch,) = [observer for observer in simulation.loop.observers if isinstance(observer, Tracked)]
    while len(calls) < 20:
        assert simulation.step()
        if NONE not in controller.reference.contact:
            calls.append([])
            sys.setprofile(lambda frame, event, what, seen=calls[-1]: seen.append(event))
            try:
                watch.observe(1)
            finally:
                sys.setprofile(None)
    assert max(sum(event in ("call", "c_call") for event in one) for one in calls) <= 8


def test_other_masses_than_planned_do_not_change_the_speed(controller, plan):
    least, distance = run(controller, plan, 8.0, mass_factor=1.1)
    assert least > UPRIGHT
    assert distance == pytest.approx(8.0 * plan.speed, rel=0.02)


def test_delay_and_pushes_that_the_replay_falls_over(controller, plan):
    assert run(controller, plan, 4.0, torque_delay=0.005)[0] > UPRIGHT
    assert run(controller, plan, 6.0, torque_delay=0.005, tracking="replay")[0] < UPRIGHT
    for impulse in ((3.0, 0.0, 0.0), (-3.0, 0.0, 0.0), (0.0, 3.0, 0.0), (0.0, -3.0, 0.0)):
        assert run(controller, plan, 4.5, push=(1.6, impulse))[0] > UPRIGHT


def test_the_replay_walks_undisturbed(controller, plan):
    least, distance = run(controller, plan, 3.0, tracking="replay")
    assert least > UPRIGHT
    assert distance == pytest.approx(3.0 * plan.speed, rel=0.05)


def test_while_a_plan_runs_other_motions_are_refused_and_damping_is_not(controller, dynamic, robot):
    step = walkable([dynamic.gait], robot, 1)
    controller.reset()
    controller.load(step)
    controller.follow()
    for order in (lambda: controller.command(speed=(0.1, 0.0)), controller.walk, controller.stand):
        with pytest.raises(BadInput, match=f"nothing while {step.name} runs"):
            order()
    with pytest.raises(BadInput, match="tracking: got 'other'"):
        controller.load(step, "other")
    controller.damp()
    controller.command(speed=(0.1, 0.0))
    controller.follow()
    assert controller.follows
    controller.reset()
    assert not controller.follows


def test_ticks_of_a_plan_allocate_nothing(controller, plan):
    _nrt_python.memsys_enable_stats()
    run(controller, plan, 0.01)
    plant = Plant(controller.robot)
    plant.reset(*plan.start)
    controller.reset()
    controller.follow()
    plant.measure(controller.measurement)
    before = rtsys.get_allocation_stats()
    for _ in range(1000):
        plant.measure(controller.measurement)
        plant.step(controller.tick())
    assert rtsys.get_allocation_stats() == before
    assert controller.telemetry.step_count[0] > 1
