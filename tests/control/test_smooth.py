"""No torque ever jumps: from tick to tick it changes by less than its rate, in every state, and ends at its limit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.control.walking import DT, Held, Loop, parameters

from gaitsmith.simulation.sensors import SensorNoise

ROUNDING = 1e-9  # N·m

names = pytest.mark.parametrize("name", ["bhr_b2", "thbip_ii"])
ACTIONS = ("walk", "stand", "damp", "off", "")


def torque_rows(loop: Loop, ticks: int) -> np.ndarray:
    """Torques of some ticks (ticks, nj)."""
    first = loop.column(f"torque.{loop.robot.joint_names[0]}")
    return loop.run(ticks)[:, first : first + len(loop.robot.joint_names)]


def assert_smooth(torques: np.ndarray, loop: Any) -> None:
    """Inside the limits, numbers, and no change beyond the rate."""
    step = loop.controller.parameters.joints.torque_rate * DT
    assert np.isfinite(torques).all()
    assert (np.abs(torques) <= loop.robot.torque_limit).all()
    assert np.max(np.abs(np.diff(torques, axis=0))) <= step + ROUNDING


@names
@pytest.mark.parametrize("state", ["true", "estimated"])
def test_a_walk_with_pushes_is_smooth(name: str, state: str) -> None:
    """Switches of the legs, touchdowns on joints with friction, pushes, a change of every input, and a stop."""
    noise = SensorNoise() if state == "estimated" else None
    friction = 0.01 * float(np.min(Loop(name).robot.torque_limit))
    loop = Loop(name, state=state, plant={"sensors": noise, "joint_friction": friction})
    scale = loop.controller.scale
    torques = [torque_rows(loop, 100)]
    loop.controller.walk()
    torques.append(torque_rows(loop, 900))
    loop.controller.command(speed=(0.15 * scale.speed, 0.0), height=0.97 * loop.gait.height)
    torques.append(torque_rows(loop, 900))
    loop.plant.push((0.0, 0.06 * scale.mass * scale.speed / 0.1, 0.0))
    torques.append(torque_rows(loop, 100))
    loop.plant.push((0.0, 0.0, 0.0))
    torques.append(torque_rows(loop, 900))
    loop.controller.stand()
    torques.append(torque_rows(loop, 1500))
    assert_smooth(np.concatenate(torques), loop)
    assert loop.groups.template.step.count[0] > 6
    assert np.max(np.abs(loop.controller.telemetry.tilt[:2])) < 0.1


@names
def test_an_undisturbed_walk_saturates_nothing(name: str) -> None:
    """No torque at its limit, no joint at its stop, no fallback, no step ended by the clock."""
    loop = Loop(name)
    loop.run(100)
    loop.controller.command(speed=(0.15 * loop.controller.scale.speed, 0.0))
    loop.controller.walk()
    torques = torque_rows(loop, 4000)
    assert np.max(np.abs(torques) / loop.robot.torque_limit) < 0.99
    body, step = loop.groups.whole_body.solution, loop.groups.template.step
    assert (body.fallbacks[0], body.infeasible[0], body.stops_dropped[0], step.inverse_fallbacks[0]) == (0, 0, 0, 0)
    assert step.forced[0] == 0


@names
@pytest.mark.parametrize("state", ["true", "estimated"])
def test_a_walk_from_the_first_tick_saturates_nothing(name: str, state: str) -> None:
    """The first tick stands, whatever was commanded before it; every later change of torque is bounded."""
    loop = Loop(name, state=state)
    loop.controller.command(speed=(0.15 * loop.controller.scale.speed, 0.0))
    loop.controller.walk()
    torques = torque_rows(loop, 300)
    assert_smooth(torques, loop)
    assert np.max(np.abs(torques) / loop.robot.torque_limit) < 0.99


def test_switches_of_bhr_are_blended() -> None:
    """At most 15 N·m in 1 ms in steady walking; without the blend a switch jumps by more than 50."""
    loop = Loop("bhr_b2")
    loop.controller.command(speed=(0.4, 0.0))
    loop.controller.walk()
    loop.run(2000)
    assert np.max(np.abs(np.diff(torque_rows(loop, 2000), axis=0))) <= 15.0
    jumping = Loop("bhr_b2", parameters("bhr_b2", joints={"torque_rate": 1e9}))
    jumping.controller.command(speed=(0.4, 0.0))
    jumping.controller.walk()
    jumping.run(2000)
    assert np.max(np.abs(np.diff(torque_rows(jumping, 2000), axis=0))) > 25.0


HELD = {name: Held(name) for name in ("bhr_b2", "thbip_ii")}


@names
@settings(max_examples=20)
@given(seed=st.integers(0, 2**31))
def test_whatever_happens_is_smooth(name: str, seed: int) -> None:
    """Commands, states, broken sensors and states of motion at random, all in a row."""
    held, rng = HELD[name], np.random.default_rng(seed)
    held.controller.reset()
    standing = held.q.copy()
    torques = []
    for tick in range(200):
        if tick % 20 == 0:
            action = ACTIONS[rng.integers(len(ACTIONS))]
            if action:
                getattr(held.controller, action)()
            held.q[7:] = standing[7:] + rng.normal(scale=0.05, size=held.q.size - 7)
            held.v[:] = rng.normal(scale=rng.choice([0.1, 3.0]), size=held.v.size)
        broken = rng.random() < 0.05
        forces = rng.uniform(0.0, 300.0, 2) * rng.integers(0, 2, 2)
        torques.append(held.tick(float(forces[0]), np.nan if broken else float(forces[1])))
    held.q[:], held.v[:] = standing, 0.0
    assert_smooth(np.array(torques), held)
