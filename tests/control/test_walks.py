"""Closed loop: what the robots are said to do they do, in the engine, with collisions on."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from benchmarks.scaled import write_scaled
from tests.control.walking import Loop

from gaitsmith.control import Controller
from gaitsmith.kinematics.posture import standing_posture
from gaitsmith.robots import load_robot
from gaitsmith.simulation import Plant

SPEED, RATE, DRIFT = 5e-3, 0.02, 0.05  # m/s, rad/s, m
HEADING, TILT = np.radians(0.5), np.radians(3.0)


def settled(loop: Loop, ticks: int, **command: Any) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """True mean velocity in the heading frame (2,) of the second half of a walk, and telemetry by column."""
    loop.controller.command(**command)
    loop.run(ticks // 2)
    start, yaw = loop.plant.q[:2].copy(), loop.controller.telemetry.yaw[0]
    rows = loop.run(ticks // 2)
    away = (loop.plant.q[:2] - start) / (1e-3 * len(rows))
    c, s = np.cos(yaw), np.sin(yaw)
    columns = {name: rows[:, loop.column(name)] for name in ("yaw", "yaw_rate", "tilt.roll", "tilt.pitch")}
    return np.array([c * away[0] + s * away[1], c * away[1] - s * away[0]]), columns


@pytest.fixture(scope="module")
def small() -> Loop:
    return Loop("thbip_ii")


def start(loop: Loop) -> Loop:
    """From rest, walking."""
    loop.restart()
    loop.run(200)
    loop.controller.walk()
    return loop


def upright(columns: dict[str, np.ndarray]) -> bool:
    return bool(max(np.max(np.abs(columns[f"tilt.{axis}"])) for axis in ("roll", "pitch")) < TILT)


def test_standing_holds_place_and_heading(small: Loop) -> None:
    """10 s: THBIP-II twisted by 38 degrees when its yaw was nobody's task."""
    small.restart()
    yaw = small.run(10_000)[:, small.column("yaw")]
    assert np.max(np.abs(yaw)) < HEADING
    assert np.linalg.norm(small.plant.q[:2] - small.start[:2]) < 0.01


def test_walking_in_place_stays_in_place(small: Loop) -> None:
    """10 s: heading within half a degree, place within 5 cm."""
    start(small)
    _, columns = settled(small, 10_000)
    assert np.max(np.abs(columns["yaw"])) < HEADING
    assert np.linalg.norm(small.plant.q[:2] - small.start[:2]) < DRIFT
    assert upright(columns)


@pytest.mark.parametrize("speed", [(0.2, 0.0), (0.4, 0.0), (0.0, 0.1), (0.0, -0.1), (0.0, 0.3)])
def test_the_commanded_speed_is_walked(small: Loop, speed: tuple[float, float]) -> None:
    """16 s: to 5 mm/s."""
    start(small)
    velocity, columns = settled(small, 16_000, speed=speed)
    np.testing.assert_allclose(velocity, speed, rtol=0.0, atol=SPEED)
    assert np.max(np.abs(columns["yaw"])) < 2.0 * HEADING
    assert upright(columns)


@pytest.mark.parametrize("rate", [-0.3, 0.3])
@pytest.mark.parametrize("speed", [0.0, 0.2])
def test_the_commanded_turn_is_walked(small: Loop, rate: float, speed: float) -> None:
    """10 s: to .02 rad/s."""
    start(small)
    _, columns = settled(small, 10_000, speed=(speed, 0.0), yaw_rate=rate)
    turned = np.unwrap(columns["yaw"])
    assert (turned[-1] - turned[0]) / (1e-3 * len(turned)) == pytest.approx(rate, abs=RATE)
    assert upright(columns)


@pytest.mark.parametrize("speed", [0.0, 0.4])
def test_bhr_walks_at_the_commanded_speed(speed: float) -> None:
    loop = start(Loop("bhr_b2"))
    velocity, columns = settled(loop, 12_000, speed=(speed, 0.0))
    assert velocity[0] == pytest.approx(speed, abs=0.01)
    assert upright(columns)


@pytest.mark.parametrize("way", range(8))
def test_pushes_of_thbip_are_caught(small: Loop, way: int) -> None:
    """3 N·s from eight sides while it walks in place, each at another phase of the step."""
    start(small)
    small.run(1500 + 43 * way)
    angle = np.pi * way / 4.0
    small.plant.push((30.0 * np.cos(angle), 30.0 * np.sin(angle), 0.0))
    small.run(100)
    small.plant.push((0.0, 0.0, 0.0))
    small.run(3000)
    assert small.controller.state == "walking"
    assert np.max(np.abs(small.controller.telemetry.tilt[:2])) < TILT


def test_a_scaled_robot_walks_the_same(tmp_path: Path) -> None:
    """Twice as long, eight times as heavy: in its own units of length and time, it walks the same way.

    The ticks are as long as before, and contacts as stiff, so it is the same walk and not the same numbers.
    """
    paths = []
    for factor in (1.0, 2.0):
        robot = load_robot(str(write_scaled("thbip_ii", factor, tmp_path / f"{factor:g}")))
        controller, plant = Controller(robot), Plant(robot)
        scale = controller.scale
        gait = robot.card.gait
        plant.reset(standing_posture(robot, gait.height, gait.width))
        controller.command(speed=(0.1 * scale.speed, 0.0))
        path = []
        for tick in range(round(50.0 / scale.rate / 1e-3)):
            if tick == 200:
                controller.walk()
            plant.measure(controller.measurement)
            plant.step(controller.tick())
            path.append(plant.q[:2] / scale.height)
        assert np.max(np.abs(controller.telemetry.tilt[:2])) < TILT
        half = len(path) // 2
        paths.append((path[-1] - path[half]) / ((len(path) - half) * 1e-3 * scale.rate))
    np.testing.assert_allclose(paths[1], paths[0], atol=3e-3)
    assert paths[0][0] == pytest.approx(0.1, abs=3e-3)
