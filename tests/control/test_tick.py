"""The compiled tick and its NumPy version agree, tick by tick, over everything a walk does."""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest
from tests.control.walking import DURATION, PUSH, ROBOTS, SPEED, Loop, busy_plan, gait, parameters
from tests.reference.memory import differences, read_memory, requested_gait
from tests.reference.numpy_tick import NumpyTick

from gaitsmith.control import Controller, Measurement
from gaitsmith.qp.quadratic_program import QuadraticProgram
from gaitsmith.robots.presets import ControlParameters

AGREEMENT = 1e-8  # of the largest torque limit; the QP magnifies rounding (1e-16) up to 1e8 times
OWN = 1e-7  # of the tick's own largest torque or acceleration, which may be small beside the limits
SIGN = 1e-13  # of the QP's scale: a multiplier so small has no sign, only rounding
SAMPLES = 13  # ticks from one comparison to the next
AROUND = 3  # ticks after a switch that are all compared

PARTLY = {"deadbeat": 0.5, "prediction": 0.7, "mean_speed": 0.6, "acceleration_gain": 0.01}  # no preset has these


class Case(NamedTuple):
    """A robot, its parameters, and whether the state is estimated."""

    robot: str
    chosen: ControlParameters
    state: str = "true"


CASES = {
    "bhr_b2": Case("bhr_b2", parameters("bhr_b2")),
    "paper": Case("bhr_b2", parameters("bhr_b2", "paper", weights={"torque_change": 1e-3})),
    "partly": Case("bhr_b2", parameters("bhr_b2", foothold=PARTLY)),
    "estimated": Case("bhr_b2", parameters("bhr_b2"), "estimated"),
    "six_joint_legs": Case("six_joint_legs", parameters("six_joint_legs")),
    "with_arms": Case("with_arms", parameters("with_arms")),
}
cases = pytest.mark.parametrize("case", CASES)


class Comparison(NamedTuple):
    """One tick of both: torque difference (N·m), differences of the memory, and the worst wrong-signed multiplier."""

    tick: int
    torque: float
    memory: dict[str, float]
    wrong_sign: float


def seen(controller: Controller) -> Measurement:
    """The measurement with the state that the controller made of it."""
    control, given = controller._groups.control, controller.measurement
    if not control.estimated[0]:
        return given
    q, v = control.q, control.v
    return given._replace(
        base_position=q[:3], base_quaternion=q[3:7], joint_position=q[7:], base_velocity=v[:6], joint_velocity=v[6:]
    )


def wrong_sign(program: QuadraticProgram) -> float:
    """Largest multiplier that pulls the solution towards the side it is held from, in the solver's scaled units."""
    n, m, base = int(program.size[0]), int(program.size[1]), len(program.gradient)
    unit = np.sqrt(np.diag(program.hessian)[:n])
    size = max(np.max(np.abs(program.gradient[:n]) / unit), np.max(np.abs(program.solution[:n]) * unit))
    normals = np.vstack([np.eye(n), program.rows[:m, :n]]) / unit
    index = [*range(n), *range(base, base + m)]
    pull = program.active[index] * program.multipliers[index] * np.linalg.norm(normals, axis=1)
    return float(np.max(pull) / size)


@cache
def compared(name: str) -> tuple[list[Comparison], dict[str, Any]]:
    """The busy walk of a case, with the reference beside it."""
    case = CASES[name]
    loop = Loop(case.robot, case.chosen, case.state)
    controller, step = loop.controller, loop.controller._groups.step
    estimated = case.state == "estimated"
    gains = case.chosen.joint_gains_estimated if estimated else case.chosen.joint_gains
    reference = NumpyTick(loop.robot, case.chosen, gains)
    plan = busy_plan(case.robot, SPEED[case.robot], PUSH[case.robot])
    found, switch = [], -AROUND
    for tick in range(DURATION):
        if tick in plan:
            plan[tick](loop)
        loop.plant.measure(controller.measurement)
        before = read_memory(controller)
        torque = controller.tick()
        if step.count[0] != before.step_count:
            switch = tick
        if tick % SAMPLES == 0 or tick - switch < AROUND:
            reference.memory = before
            expected = reference.tick(seen(controller), requested_gait(controller))
            difference = float(np.max(np.abs(torque - expected)))
            memory = differences(reference.memory, read_memory(controller))
            found.append(Comparison(tick, difference, memory, wrong_sign(controller._groups.program)))
        loop.plant.step(torque)
    end = {
        "steps": int(step.count[0]),
        "standing": step.mode[0] == 0,
        "bad": int(controller._groups.control.counts[:2].sum()),
        "fallbacks": int(controller._groups.whole_body.counts[1]),
    }
    return found, end


def decided(name: str) -> list[Comparison]:
    """Ticks whose QP ended at its optimum, not next to it."""
    return [comparison for comparison in compared(name)[0] if comparison.wrong_sign <= SIGN]


@cases
def test_the_walk_covers_what_it_should(case: str) -> None:
    """Standing, many steps, nothing given up; the default preset ends at rest."""
    found, end = compared(case)
    assert end["steps"] >= 6
    assert end["bad"] == 0
    assert end["fallbacks"] == 0
    assert end["standing"] or case != "bhr_b2"
    assert len(found) >= 250
    assert len(decided(case)) >= 0.95 * len(found)


@cases
def test_torques_agree(case: str) -> None:
    limit = float(np.max(Loop(CASES[case].robot).robot.torque_limit))
    worst = max(decided(case), key=lambda comparison: comparison.torque)
    assert worst.torque <= AGREEMENT * limit, f"tick {worst.tick}"


@cases
def test_what_is_remembered_agrees(case: str) -> None:
    """Phase, template, and references; torques and accelerations by their own size."""
    for comparison in decided(case):
        for name, difference in comparison.memory.items():
            bound = OWN if name in ("torque", "feedforward", "acceleration") else AGREEMENT
            assert difference <= bound, f"{name} at tick {comparison.tick}"


@cases
def test_no_bound_is_held_against_its_multiplier(case: str) -> None:
    """A bound that pushes the wrong way must be let go: next to it the torques can be percents off."""
    assert max(comparison.wrong_sign for comparison in compared(case)[0]) <= SIGN


def test_reference_is_not_the_compiled_code() -> None:
    """The NumPy version calls no kernel: it would agree with anything."""
    from tests.reference import memory, numpy_tick, quadratic_program, rigid_body, whole_body

    from gaitsmith.compiled.cache import Kernel

    for module in (memory, numpy_tick, quadratic_program, rigid_body, whole_body):
        assert not [name for name, value in vars(module).items() if isinstance(value, Kernel)]


def test_gait_of_the_small_robots_is_within_their_limits() -> None:
    for name in ROBOTS:
        Controller(Loop(name).robot, gait=gait(name))
