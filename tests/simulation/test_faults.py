"""Faults are data: named by the robot's own components, injected alike every time, told with what was done."""

from __future__ import annotations

import numpy as np
import pytest

from gaitsmith.errors import BadInput
from gaitsmith.robots import load_robot
from gaitsmith.simulation import Scenario, Simulation
from gaitsmith.simulation.faults import Fault, groups, members, motors, sensors
from gaitsmith.simulation.reactions import BRAKED, DRIVES, UNNOTICED, Reaction, ended_braked, with_unnoticed
from gaitsmith.simulation.scenario import check_scenario, make_scenario

ROBOT = load_robot("bhr_b2")


def fault(text: str) -> Fault:
    return Fault.model_validate(text)


def ran(*faults: str, duration: float = 2.6, **fields):
    """A walk with faults, and all its torques."""
    scenario = Scenario(duration=duration, speed=(0.3, 0.0), faults=faults, **fields)
    run, torques = Simulation(scenario, robot=ROBOT, record=False), []
    while run.step():
        torques.append(run.controller.telemetry.torque.copy())
    return run, np.array(torques)


def test_the_short_form_is_the_table():
    assert fault("imu:stuck@3s,500ms") == Fault(component="imu", type="stuck", time=3.0, duration=0.5)
    assert fault(str(fault("left_knee.angle:nan@1.5,0.1s"))) == fault("left_knee.angle:nan@1.5,0.1s")


@pytest.mark.parametrize(
    "text", ["imu", "imu:stuck", "imu:stuck@3s", "imu:stuck@x,1s", "imu:odd@3s,1s", "imu:nan@3s,0s"]
)
def test_what_is_no_fault_is_one_line(text):
    with pytest.raises(BadInput) as caught:
        make_scenario({"faults": [text]})
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "valid"),
    [
        ("nose:nan@1s,1s", "gyro"),
        ("ticks:nan@1s,1s", "dead"),
        ("gyro:dead@1s,1s", "stuck"),
        ("imu:weak@1s,1s", "offset"),
    ],
)
def test_what_the_robot_does_not_have_is_refused_with_the_list(text, valid):
    with pytest.raises(BadInput, match=valid) as caught:
        check_scenario(Scenario(faults=(text,)), ROBOT)
    assert caught.value.field.startswith("faults[0]")


def test_every_component_has_a_name_of_the_robot():
    assert members(fault("left_knee.motor:dead@0s,1s"), ROBOT) == ("left_knee.motor",)
    assert members(fault("soles:nan@0s,1s"), ROBOT) == ("left.force", "right.force")
    assert len(sensors(ROBOT)) == 3 + 16 + 2 + 2
    assert groups(ROBOT)["motors"] == motors(ROBOT)


def test_the_same_faults_give_the_same_torques():
    faults = ("left_knee.angle:offset@1.6s,0.2s", "imu:delayed@1.9s,0.1s", "ticks:delayed@2.1s,0.05s")
    (_, first), (_, second) = ran(*faults), ran(*faults)
    np.testing.assert_array_equal(first, second)
    assert not np.array_equal(first, ran(duration=2.6)[1])


def test_reactions_are_told_in_the_summary():
    run, _ = ran("right.force:nan@1.6s,0.3s", "left_ankle.motor:weak@2.2s,0.01s")
    first, second = run.summary().faults
    assert (first.component, first.type) == ("right.force", "not a number")
    assert first.time == pytest.approx(1.6, abs=2e-3)
    assert "clock" in first.reaction
    assert (second.component, second.reaction) == ("left_ankle.motor", UNNOTICED)
    assert run.fall is None


def test_what_cannot_be_survived_ends_braked_and_named():
    run, torques = ran("angles:nan@1.6s,2s", "rates:nan@1.6s,2s", duration=4.0)
    summary = run.summary()
    assert summary.fell
    assert BRAKED in {entry.reaction for entry in summary.faults} or summary.fall.time < 2.7
    assert "fail" in summary.fall.cause.what or "nan" in summary.fall.cause.what
    assert np.isfinite(torques).all()
    assert (np.abs(torques) <= ROBOT.torque_limit).all()


def test_a_controller_that_is_late_goes_on():
    run, _ = ran("ticks:dead@1.7s,0.05s")
    assert run.fall is None
    assert run.controller.telemetry.missed_ticks[0] == 50
    first = run.summary().faults[0]
    assert (first.component, first.type) == ("ticks", "late")


@pytest.mark.parametrize(
    ("text", "state"),
    [("ticks:delayed@1.7s,1s", "true"), ("ticks:delayed@1.9s,1s", "estimated"), ("imu:offset@1.8s,1s", "estimated")],
)
def test_a_second_is_survived_where_the_rest_suffices(text, state):
    """One tick in ten, each worth ten; and an IMU that is turned on its mount, with its gyro and accelerometer off."""
    run, _ = ran(text, duration=4.5, state=state)
    assert run.fall is None
    assert run.controller.state == "walking"
    assert {entry.component for entry in run.summary().faults} >= (
        {"ticks"} if text.startswith("ticks") else {"attitude", "gyro", "accelerometer"}
    )


@pytest.mark.parametrize(
    "text", ["left_hip_pitch.motor:stuck@3.6s,1s", "left_knee.motor:dead@2.2s,1s", "ticks:dead@2s,1s"]
)
def test_what_a_motor_or_a_clock_takes_away_ends_braked_before_the_fall(text):
    run, _ = ran(text, duration=5.0)
    summary = run.summary()
    assert summary.fell
    assert ended_braked(summary.faults, summary.fall.time)
    told = {(entry.component, entry.reaction) for entry in summary.faults}
    if "hip" in text:
        assert ("left_hip_pitch.motor", BRAKED) in told
    if "ticks" in text:
        assert ("ticks", DRIVES) in told


def test_what_is_said_of_another_joint_is_not_about_this_one():
    """A motor that nobody names went unnoticed, whatever else was seen meanwhile; one that is named did not."""
    faults = (fault("left_knee.motor:dead@1s,0.5s"), fault("imu:nan@2s,0.5s"))
    found = [
        Reaction(time=1.1, component="right_knee.angle", type="stuck", reaction="replaced"),
        Reaction(time=2.1, component="gyro", type="not a number", reaction="replaced"),
    ]
    silent = [e for e in with_unnoticed(tuple(found), faults, 4.0) if e.reaction == UNNOTICED]
    assert [e.component for e in silent] == ["left_knee.motor"]
    found.append(Reaction(time=1.2, component="left_knee.motor", type="weak", reaction="told"))
    assert not [e for e in with_unnoticed(tuple(found), faults, 4.0) if e.reaction == UNNOTICED]
