"""The controller as its user sees it: construction, commands, reset, telemetry; bad input is refused in one line."""

from __future__ import annotations

from operator import attrgetter
from typing import Any

import numpy as np
import pytest
from tests.control.walking import ROBOTS, Held, Loop, gait, parameters, robot, view

from gaitsmith.control import Controller, Telemetry
from gaitsmith.control.telemetry import make_telemetry
from gaitsmith.errors import BadInput
from gaitsmith.estimation.measurement import make_measurement
from gaitsmith.robots.parameters import GaitParameters


@pytest.mark.parametrize("name", ROBOTS)
def test_telemetry_columns_match_the_buffer(name: str) -> None:
    """One name per entry, in the order of the fields; the fields are views of the buffer."""
    joints, soles = robot(name).joint_names, tuple(leg.name for leg in robot(name).legs)
    telemetry, buffer, columns = make_telemetry(joints, soles, ("speed_x", "speed_y"))
    assert len(columns) == len(buffer) == len(set(columns))
    buffer[:] = np.arange(len(buffer))
    at = 0
    for field, own_view in zip(Telemetry._fields, telemetry, strict=True):
        own = columns[at : at + len(own_view)]
        assert all(column.split(".")[0] == field for column in own)
        np.testing.assert_array_equal(own_view, np.arange(at, at + len(own_view)))
        if field.startswith(("joint_", "torque")):
            assert [column.split(".", 1)[1] for column in own] == list(joints)
        at += len(own_view)
    assert at == len(buffer)


def test_telemetry_reports_the_tick() -> None:
    """The controller's buffer holds what the groups hold, and the numbers mean what their names say."""
    loop = Loop("thbip_ii")
    loop.run(50)
    loop.controller.command(speed=(0.1, 0.02), yaw_rate=0.2)
    loop.controller.walk()
    loop.run(1500)
    controller, groups = loop.controller, loop.groups
    torque = controller.telemetry.torque
    values = dict(zip(controller.telemetry_columns, controller.telemetry_buffer, strict=True))
    assert values["time"] == pytest.approx(1.55)
    assert values["control_state"] == 3.0
    assert controller.state == "walking"
    assert values["step_count"] == groups.template.step.count[0] >= 2
    assert values["command.height"] == loop.gait.height
    assert (values["command.speed_x"], values["command.speed_y"], values["command.yaw_rate"]) == (0.1, 0.02, 0.2)
    assert values["hip_height"] == pytest.approx(loop.gait.height, abs=0.02)
    for j, joint in enumerate(loop.robot.joint_names):
        assert values[f"torque.{joint}"] == torque[j]
        assert values[f"joint_position.{joint}"] == groups.body.q[7 + j]
    assert values["wrench.left.fz"] == groups.whole_body.solution.wrench[0, 2]
    assert values["foot_actual.right.z"] == groups.body.frames.relative_position[1, 2]
    assert values["yaw_rate"] == groups.body.frames.yaw_rate[0]
    assert values["refused.gyro"] == values["refused_ticks"] == 0.0
    assert np.isfinite(controller.telemetry_buffer).all()


def arrays(group: Any) -> list[Any]:
    """All arrays of a view, however deep."""
    return [group] if isinstance(group, np.ndarray) else [array for part in group for array in arrays(part)]


def test_no_two_fields_share_memory() -> None:
    """But gait inputs and measurements, views of one array each; neither by accident nor after an arena placed them."""
    groups = Held().groups
    template = groups.template
    inputs = {id(array) for group in (template.requested, template.latched) for array in group[:-1]}
    inputs |= {id(array) for group in (groups.measurement, groups.checking.expected) for array in group}
    found = {id(array): array for array in arrays(groups) if id(array) not in inputs}
    kept = list(found.values())
    for k, array in enumerate(kept):
        assert array.flags.c_contiguous
        assert not any(np.shares_memory(array, other) for other in kept[:k])


BAD_COMMANDS: list[dict[str, Any]] = [
    {"height": 5.0},
    {"height": 0.1},
    {"period": 0.01},
    {"period": 100.0},
    {"alpha": 0.99},
    {"lift": 2.0},
    {"width": 1.0},
    {"speed": (9.0, 0.0)},
    {"speed": (0.0, -9.0)},
    {"speed": 0.1},
    {"yaw_rate": 0.1},
    {"colour": 1.0},
]


@pytest.mark.parametrize("command", BAD_COMMANDS, ids=str)
def test_bad_commands_are_refused(command: dict[str, Any]) -> None:
    """The field is named with its range, and nothing has changed."""
    controller = Controller(robot("bhr_b2"))
    control = view(controller).control
    before = control.mailbox.copy(), control.letters.copy()
    with pytest.raises(BadInput) as caught:
        controller.command(**command)
    assert caught.value.field.startswith(next(iter(command)))
    assert "\n" not in str(caught.value)
    assert controller.gait == robot("bhr_b2").card.gait
    np.testing.assert_array_equal(control.mailbox, before[0])
    np.testing.assert_array_equal(control.letters, before[1])


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -0.4, 0.0])
def test_numbers_that_are_none_are_refused(value: float) -> None:
    for field in ("height", "period", "alpha", "lift", "width"):
        with pytest.raises(BadInput, match=field):
            Controller(robot("bhr_b2")).command(**{field: value})


def test_bad_construction_is_refused() -> None:
    with pytest.raises(BadInput, match="default, experiment, paper"):
        Controller(robot("bhr_b2"), "fast")
    with pytest.raises(BadInput, match="true or estimated"):
        Controller(robot("bhr_b2"), state="guessed")  # type: ignore[arg-type]
    with pytest.raises(BadInput, match="height"):
        Controller(robot("bhr_b2"), gait=gait("bhr_b2", height=3.0))


def test_preset_may_be_given_as_parameters() -> None:
    chosen = parameters("bhr_b2", "paper")
    assert Controller(robot("bhr_b2"), chosen).parameters is chosen


def test_command_keeps_what_is_not_named() -> None:
    controller = Controller(robot("bhr_b2"))
    controller.command(speed=(0.3, 0.0))
    controller.command(height=0.66)
    assert controller.gait == GaitParameters(**{**gait("bhr_b2").model_dump(), "speed": (0.3, 0.0), "height": 0.66})
    controller.stand()
    assert controller.gait.speed == (0.0, 0.0)
    assert controller.gait.height == 0.66


def test_a_measurement_may_be_passed() -> None:
    """Its own, or another one, which is copied."""
    held = Held()
    expected = held.tick()
    own = make_measurement(len(held.robot.joint_names))
    for copy, original in zip(own, held.controller.measurement, strict=True):
        copy[...] = original
    other = Held().controller
    np.testing.assert_array_equal(other.tick(own), expected)
    assert not np.shares_memory(other.measurement.joint_position, own.joint_position)


def test_tick_returns_a_view() -> None:
    """The same array every time: nothing is allocated."""
    held = Held()
    held.tick()
    assert held.controller.tick() is held.controller.tick()


@pytest.mark.parametrize("state", ["true", "estimated"])
def test_reset_forgets_everything_but_the_gait(state: str) -> None:
    """After a reset the same measurements give the same torques as a new controller's, to the bit."""
    used = Held(state=state)
    used.controller.walk()
    for tick in range(1000):
        used.tick(10.0, np.nan if tick < 100 else 300.0)
    used.controller.damp()
    used.tick()
    used.controller.command(height=0.66)
    used.controller.reset()
    fresh = Held(state=state)
    fresh.controller.command(height=0.66)
    fresh.controller.reset()
    assert used.controller.gait.height == 0.66
    for _ in range(200):
        np.testing.assert_array_equal(used.tick(), fresh.tick())
    names = (
        "template.step template.latched estimation.state whole_body.solution reference whole_body.contacts telemetry"
    )
    for name in (*names.split(), "control", "body.frames"):
        ours, theirs = attrgetter(name)(used.groups), attrgetter(name)(fresh.groups)
        for field, a, b in zip(ours._fields, ours, theirs, strict=True):
            if field not in ("letters", "read"):
                np.testing.assert_array_equal(a, b, err_msg=f"{name}.{field}")


def test_a_new_controller_needs_no_reset() -> None:
    held, fresh = Held(), Controller(robot("bhr_b2"), parameters("bhr_b2", standing={"weight_shift": False}))
    expected = held.tick()
    np.testing.assert_array_equal(fresh.tick(held.controller.measurement), expected)
