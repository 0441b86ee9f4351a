"""The monitor sees every limit that is hit, under its name, and every way to fall."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.simulation.standing import posture, robot

from gaitsmith.control import Controller
from gaitsmith.simulation import monitor as monitoring
from gaitsmith.simulation.monitor import Monitor
from gaitsmith.simulation.plant import Plant

COMMANDED_HEIGHT = 0.66


@pytest.fixture
def watched():
    """A monitor of a robot that stands, with telemetry that the test may write to."""
    plant, controller = Plant(robot()), Controller(robot())
    plant.reset(posture())
    controller.telemetry_buffer[:] = 0.0
    controller.telemetry.joint_position[:] = posture()[7:]
    controller.telemetry.command[4] = COMMANDED_HEIGHT
    controller.telemetry.stance[0] = 2.0
    return Monitor(robot(), controller, plant, 2.0), controller.telemetry, plant


def _hit(monitor):
    row = monitor.kept.limits[(monitor.ticks - 1) % monitoring.MEMORY]
    return {name for name, flag in zip(monitor.limit_names, row, strict=True) if flag}


def test_nothing_is_hit_while_standing(watched):
    monitor, _, _ = watched
    assert monitor.watch() == monitoring.UPRIGHT
    assert _hit(monitor) == set()


@pytest.mark.parametrize("joint", range(8))
def test_a_torque_at_its_limit_is_counted(watched, joint):
    monitor, telemetry, _ = watched
    telemetry.torque[joint] = -robot().torque_limit[joint]
    monitor.watch()
    telemetry.torque[joint] *= 0.5
    monitor.watch()
    assert monitor.kept.torque_saturated[joint] == 1
    assert monitor.kept.torque_peak[joint] == robot().torque_limit[joint]
    assert np.count_nonzero(monitor.kept.torque_peak) == 1


def test_limits_are_named(watched):
    monitor, telemetry, plant = watched
    telemetry.torque[2] = robot().torque_limit[2]
    telemetry.joint_position[1] = robot().position_high[1]
    telemetry.wrench[2], telemetry.wrench[8] = 300.0, 300.0
    telemetry.zmp[0] = robot().legs[0].sole.toe
    telemetry.wrench[6] = -0.6 * 300.0
    telemetry.qp_infeasible[0] = 1.0
    telemetry.touchdowns_forced[0] = 1.0
    plant.observed[20] = 1.0
    monitor.watch()
    assert _hit(monitor) == {
        f"torque of {robot().joint_names[2]} saturated",
        f"joint limit of {robot().joint_names[1]}",
        "ZMP at the edge of the left sole",
        "friction limit of the right sole",
        "whole-body QP infeasible",
        "step ended by the clock",
        "legs touching each other",
    }
    plant.observed[20] = 0.0
    monitor.watch()
    assert "whole-body QP infeasible" not in _hit(monitor)
    assert "step ended by the clock" not in _hit(monitor)


@pytest.mark.parametrize(
    ("foothold", "name"),
    [((0.4, 0.1), "reach"), ((-0.4, 0.1), "reach"), ((0.1, -0.35), "spread"), ((0.1, 0.05), "separation")],
)
def test_footholds_say_which_bound_they_are_at(watched, foothold, name):
    monitor, telemetry, _ = watched
    telemetry.mode[0] = telemetry.foothold_bound[0] = 1.0
    telemetry.foothold[:] = foothold
    monitor.watch()
    assert _hit(monitor) == {f"foothold at its {name} bound"}


def _tilt(plant):
    plant.q[3:7] = math.cos(math.radians(31)), 0.0, math.sin(math.radians(31)), 0.0


def _sink(plant):
    plant.q[7:] = np.clip(
        posture()[7:] + np.tile([0.0, -1.3, 2.0, -0.9], 2), robot().position_low, robot().position_high
    )
    plant.q[2] += 5.0


def _lie(plant):
    plant.q[2] -= 0.55


def _diverge(plant):
    plant.v[0] = np.nan


@pytest.mark.parametrize(
    ("spoil", "fall"),
    [(_tilt, "TILTED"), (_sink, "SANK"), (_lie, "TOUCHED"), (_diverge, "DIVERGED")],
)
def test_every_way_to_fall_is_told_apart(watched, spoil, fall):
    monitor, _, plant = watched
    spoil(plant)
    plant.refresh()
    assert monitor.watch() == getattr(monitoring, fall)


def test_touchdowns_are_kept_with_their_leg(watched):
    monitor, telemetry, _ = watched
    for tick in range(10):
        telemetry.step_count[0] = tick // 4
        telemetry.stance[0] = (tick // 4) % 2
        monitor.watch()
    assert monitor.touchdowns.tolist() == [[4, 1], [8, 0]]
