"""The monitor sees every limit that is hit, under its name, and every way to fall; its memory is bounded."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.simulation.standing import posture, robot

from gaitsmith.control import Controller
from gaitsmith.log.columns import Columns
from gaitsmith.simulation import monitor as monitoring
from gaitsmith.simulation.belief import Belief
from gaitsmith.simulation.limits import MISTAKEN
from gaitsmith.simulation.monitor import Monitor
from gaitsmith.simulation.plant import Plant

COMMANDED_HEIGHT = 0.66


def _monitor(controller: Controller, names: list[str], buffer: np.ndarray) -> Monitor:
    columns = Columns((controller.telemetry_columns, controller.telemetry_buffer), (names, buffer))
    return Monitor(robot(), controller.parameters, columns, 1e-3, robot().card.gait.model_dump())


@pytest.fixture
def watched():
    """A monitor of a robot that stands, with telemetry that the test may write to."""
    plant, controller = Plant(robot()), Controller(robot())
    plant.reset(posture())
    controller.telemetry_buffer[:] = 0.0
    controller.telemetry.joint_position[:] = posture()[7:]
    controller.telemetry_buffer[controller.telemetry_columns.index("command.height")] = COMMANDED_HEIGHT
    controller.telemetry.stance[0] = 2.0
    monitor = _monitor(controller, [f"true.{name}" for name in plant.truth_columns], plant.truth_buffer)
    return monitor, controller.telemetry, plant


def _hit(monitor):
    return {name for name, flag in zip(monitor.limit_names, monitor.kept.hits.now, strict=True) if flag}


def test_nothing_is_hit_while_standing(watched):
    monitor, _, _ = watched
    assert not monitor.observe(0)
    assert _hit(monitor) == set()


@pytest.mark.parametrize("joint", range(8))
def test_a_torque_at_its_limit_is_counted(watched, joint):
    monitor, telemetry, _ = watched
    telemetry.torque[joint] = -robot().torque_limit[joint]
    monitor.observe(0)
    telemetry.torque[joint] *= 0.5
    monitor.observe(1)
    joints = monitor.kept.joints
    assert joints.torque_saturated[joint] == 1
    assert joints.torque_peak[joint] == robot().torque_limit[joint]
    assert np.count_nonzero(joints.torque_peak) == 1


def test_a_joint_beyond_its_speed_is_counted(watched):
    monitor, telemetry, _ = watched
    for speed in (0.9, -1.1, 1.2, 0.0):
        telemetry.joint_velocity[3] = speed * robot().velocity_limit[3]
        monitor.observe(0)
    joints = monitor.kept.joints
    assert joints.velocity_over.tolist() == [0, 0, 0, 2, 0, 0, 0, 0]
    assert joints.velocity_peak[3] == 1.2 * robot().velocity_limit[3]


def test_torque_steps_count_while_walking_undisturbed(watched):
    monitor, telemetry, _ = watched
    monitor.hear({"time": 0.0, "action": "walk"})
    telemetry.mode[0] = 1.0
    jumps = {500: 40.0, 1600: 7.0, 2100: 30.0, 2700: 20.0, 3200: 9.0}  # the last but two while it is pushed
    for tick in range(3500):
        if tick == 2000:
            monitor.hear({"time": 2.0, "push": 0})
        if tick == 2200:
            monitor.hear({"time": 2.2, "push": 0, "over": True})
        if tick == 3000:
            telemetry.mode[0] = 0.0
        telemetry.torque[1] += jumps.get(tick, 0.0)
        monitor.observe(tick)
    assert monitor.kept.joints.torque_step.tolist() == [0.0, 7.0, 0, 0, 0, 0, 0, 0]


def test_limits_are_named(watched):
    monitor, telemetry, plant = watched
    telemetry.torque[2] = robot().torque_limit[2]
    telemetry.joint_position[1] = robot().position_high[1]
    telemetry.wrench[2], telemetry.wrench[8] = 300.0, 300.0
    telemetry.zmp[0] = robot().legs[0].sole.toe
    telemetry.wrench[6] = -0.6 * 300.0
    telemetry.qp_infeasible[0] = 1.0
    telemetry.touchdowns_forced[0] = 1.0
    telemetry.com_velocity[1] = plant.truth.com_velocity[1] + 0.07 * np.sqrt(9.81 * robot().card.gait.height)
    plant.truth.leg_contact[0] = 1.0
    monitor.observe(0)
    assert _hit(monitor) == {
        f"torque of {robot().joint_names[2]} saturated",
        f"joint limit of {robot().joint_names[1]}",
        "ZMP at the edge of the left sole",
        "friction limit of the right sole",
        "whole-body QP infeasible",
        "step ended by the clock",
        "legs touching each other",
        MISTAKEN,
    }
    plant.truth.leg_contact[0] = 0.0
    monitor.observe(1)
    assert "whole-body QP infeasible" not in _hit(monitor)
    assert "step ended by the clock" not in _hit(monitor)
    assert monitor.hits()[0] == ("legs touching each other", 0)


@pytest.mark.parametrize(
    ("foothold", "name"),
    [((0.4, 0.1), "reach"), ((-0.4, 0.1), "reach"), ((0.1, -0.35), "spread"), ((0.1, 0.05), "separation")],
)
def test_footholds_say_which_bound_they_are_at(watched, foothold, name):
    monitor, telemetry, _ = watched
    telemetry.mode[0] = telemetry.foothold_bound[0] = 1.0
    telemetry.foothold[:] = foothold
    monitor.observe(0)
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
    assert monitor.observe(0)
    assert monitor.state == getattr(monitoring, fall)


def test_touchdowns_are_kept_with_their_leg(watched):
    monitor, telemetry, _ = watched
    for tick in range(10):
        telemetry.step_count[0] = tick // 4
        telemetry.stance[0] = (tick // 4) % 2
        monitor.observe(tick)
    assert monitor.touchdowns().tolist() == [[4, 1], [8, 0]]


def test_the_heading_goes_on_where_the_yaw_turns_over(watched):
    monitor, _, plant = watched
    for tick in range(9000):
        heading = 3.0 + 1e-3 * tick
        plant.truth.attitude[2] = (heading + math.pi) % (2 * math.pi) - math.pi
        monitor.observe(tick)
    stage = monitor.stages()[0]
    assert monitor.kept.headings.high[0] == pytest.approx(3.0 + 8.999)
    assert monitor.kept.yaws.high[0] <= math.pi
    assert stage.yaw_rate_mean == pytest.approx(1.0)
    assert stage.heading_drift_deg == pytest.approx(math.degrees(8.999))


def test_stages_follow_what_is_heard(watched):
    monitor, _, _ = watched
    told = {2: {"command": {"period": 0.3}}, 5: {"action": "walk"}, 8: {"command": {"speed": (0.2, 0.1)}}}
    told[8]["action"] = "walk"
    told[11] = {"action": "stand"}
    for tick in range(14):
        if tick in told:
            monitor.hear({"time": 1e-3 * tick, **told[tick]})
            monitor.hear({"time": 1e-3 * tick, "push": 3})  # no stage of its own
        monitor.observe(tick)
    seen = [(round(1e3 * stage.t0), round(1e3 * stage.t1), stage.rest, stage.command.vx) for stage in monitor.stages()]
    assert seen == [(0, 2, True, 0), (2, 5, True, 0), (5, 8, False, 0), (8, 11, False, 0.2), (11, 14, True, 0)]
    assert [stage.command.period for stage in monitor.stages()][1:] == [0.3] * 4


def test_what_is_believed_stands_in_for_the_truth():
    controller = Controller(robot())
    told = controller.telemetry
    belief = Belief(told, ("left", "right"), 1e-3)
    monitor = _monitor(controller, [f"believed.{name}" for name in belief.columns], belief.buffer)
    told.com_velocity[:2], told.yaw[0], told.hip_height[0] = (0.5, 0.0), math.pi / 2, 0.7
    told.foot_actual[:] = (0, 0.1, -0.7, 0, -0.1, -0.7)
    for tick in range(1000):
        assert not belief.observe(tick)
        assert not monitor.observe(tick)
        if tick == 499:
            for observer in (belief, monitor):
                observer.hear({"time": 0.5, "action": "walk"})
    assert belief.truth.torso[:2] == pytest.approx((0.0, 0.5))
    assert belief.truth.excursion[0] == pytest.approx(0.25)
    assert monitor.distance == pytest.approx(0.25)
    assert belief.truth.least_separation[0] == pytest.approx(0.2)
