"""Control states: what leads from one to another, and what each does with the joints."""

from __future__ import annotations

import numpy as np
import pytest
from tests.control.walking import DT, Held, Loop, view

from gaitsmith.control import Controller, Measurement
from gaitsmith.robots import load_robot
from gaitsmith.template.step import STAND, WALK

names = pytest.mark.parametrize("name", ["bhr_b2", "thbip_ii"])


def ticks(held: Held, count: int, *forces: float) -> np.ndarray:
    """Torques of some ticks."""
    return np.array([held.tick(*forces) for _ in range(count)])


@names
def test_standing_walking_standing(name: str) -> None:
    """A walk begins when asked for and ends in standing, with the soles side by side."""
    loop = Loop(name)
    assert loop.controller.state == "standing"
    loop.run(100)
    assert loop.controller.state == "standing"
    loop.controller.walk()
    loop.run(1500)
    assert loop.controller.state == "walking"
    loop.controller.stand()
    loop.run(2500)
    assert loop.controller.state == "standing"
    count = loop.groups.template.step.count[0]
    loop.run(500)
    assert loop.groups.template.step.count[0] == count
    assert np.max(np.abs(loop.controller.telemetry.tilt[:2])) < 0.02


def test_off_takes_the_torque_away() -> None:
    """At the rate at which torques may change, and for good."""
    held = Held()
    ticks(held, 20)
    held.controller.off()
    torques = ticks(held, 60)
    assert held.controller.state == "off"
    assert not np.any(torques[-1])
    assert (np.diff(np.abs(torques), axis=0) <= 0.0).all()
    held.controller.stand()
    held.tick()
    assert held.controller.state == "standing"


def test_damping_brakes_every_joint() -> None:
    """Against its speed, and nothing else: no torque at rest."""
    held = Held("thbip_ii")
    ticks(held, 20)
    held.controller.damp()
    assert not np.any(ticks(held, 60)[-1])
    assert held.controller.state == "damping"
    held.v[6:] = np.linspace(-3.0, 3.0, 12)
    torque = ticks(held, 200)[-1]
    assert (torque * held.v[6:] < 0.0).all()
    np.testing.assert_allclose(torque / held.v[6:], torque[0] / held.v[6])


def test_a_walk_may_follow_on_any_state() -> None:
    """After a tick on both feet, from whose torques it begins."""
    held = Held()
    for leave in (held.controller.off, held.controller.damp):
        leave()
        held.tick()
        held.controller.walk()
        for state in ("standing", "walking"):
            held.stance_only()
            assert held.controller.state == state


@pytest.mark.parametrize("state", ["true", "estimated"])
@pytest.mark.parametrize("field", Measurement._fields)
def test_replaced_readings_are_counted_by_sensor(state: str, field: str) -> None:
    """A lost reading is replaced and counted, and nothing stops; sensors that are not read cannot be lost."""
    held = Held(state=state)
    ticks(held, 20)
    unread = {"true": ("accelerometer", "gyro"), "estimated": ("base_position", "base_velocity", "joint_velocity")}
    held.tick()
    good = held.controller.telemetry.torque.copy()
    for _ in range(5):
        getattr(held.controller.measurement, field)[0] = np.nan
        torque = held.controller.tick().copy()
    telemetry = held.controller.telemetry
    counted = dict(zip(Measurement._fields, telemetry.refused, strict=True))
    if field in unread[state]:
        assert held.controller.state == "standing"
        assert not any(counted.values())
        return
    assert held.controller.state == "standing"
    assert {name: count for name, count in counted.items() if count} == {field: 5}
    assert telemetry.refused_ticks[0] == 5
    np.testing.assert_allclose(torque, good, atol=1.0)
    held.tick()
    assert telemetry.refused_ticks[0] == 5


def test_two_bad_sensors_make_one_bad_tick() -> None:
    held = Held()
    held.tick()
    held.controller.measurement.base_velocity[1] = np.inf
    held.controller.measurement.joint_position[1] = np.nan
    held.controller.tick()
    assert held.groups.control.refused.sum() == 2
    assert held.groups.control.refused_ticks[0] == 1


def test_lifted_clear_of_the_ground_the_legs_are_still() -> None:
    """After a step's time without load: no steps are counted, the joints go back to where the robot last stood."""
    held = Held("thbip_ii")
    held.controller.walk()
    held.stance_only()
    step, patience = held.groups.template.step, int(held.gait.period / DT)
    ticks(held, patience - 2, 0.0, 0.0)
    assert (held.controller.state, step.mode[0]) == ("walking", WALK)
    ticks(held, 5, 0.0, 0.0)
    count = int(step.count[0])
    assert (held.controller.state, step.mode[0]) == ("airborne", STAND)
    assert not np.any(ticks(held, 2000, 0.0, 0.0)[-1])
    assert step.count[0] == count
    moved = np.linspace(-0.1, 0.1, 12)
    held.q[7:] += moved
    torque = ticks(held, 300, 0.0, 0.0)[-1]
    assert (torque * moved < 0.0).all()


def test_a_short_flight_is_none() -> None:
    """A quarter of a step's time for a robot that stood; the time begins anew with every contact."""
    held = Held()
    patience = int(0.25 * held.gait.period / DT)
    for _ in range(4):
        ticks(held, patience - 2, 0.0, 0.0)
        assert held.controller.state == "standing"
        held.tick()
    ticks(held, patience + 2, 0.0, 0.0)
    assert held.controller.state == "airborne"


@names
@pytest.mark.parametrize("walking", [True, False])
def test_lifted_and_put_down_again(name: str, walking: bool) -> None:
    """In the plant: held by its torso the robot is lifted, hangs still, is put down, and goes on as it was told."""
    loop = Loop(name)
    loop.run(100)
    if walking:
        loop.controller.walk()
        loop.run(1500)
    base, lowest = loop.plant.q[:7].copy(), loop.gait.height - float(loop.robot.hip_midpoint[2])
    lift, counts = 0.3 * loop.gait.height, []
    for tick in range(2000):
        raised = lift * min(1.0, tick / 300.0, (2000 - tick) / 600.0)
        loop.plant.q[:7], loop.plant.v[:6] = [*base[:2], lowest + raised, 1.0, 0.0, 0.0, 0.0], 0.0
        loop.plant.refresh()
        loop.step()
        counts.append(int(loop.groups.template.step.count[0]))
        if 1000 <= tick < 1500:
            assert loop.controller.state == "airborne"
    assert counts[1000] == counts[1499]
    loop.run(3000)
    assert loop.controller.state == ("walking" if walking else "standing")
    assert (loop.groups.template.step.count[0] > counts[-1] + 3) == walking
    assert np.max(np.abs(loop.controller.telemetry.tilt[:2])) < 0.05


def test_a_letter_that_is_half_written_is_not_read() -> None:
    """Gait inputs come over all at once, when the number of letters is even again."""
    controller = Controller(load_robot("bhr_b2"))
    control, requested = view(controller).control, view(controller).template.requested
    before = requested.values.copy()
    control.letters[0] += 1
    control.mailbox[:] = 0.5
    controller.tick()
    np.testing.assert_array_equal(requested.values, before)
    control.letters[0] += 1
    controller.tick()
    np.testing.assert_array_equal(requested.values, 0.5)
    control.mailbox[:] = 0.7
    controller.tick()
    np.testing.assert_array_equal(requested.values, 0.5)


def test_commands_wait_for_the_switch() -> None:
    """Section 2.3: whatever is asked for in mid-step, the step is finished as it began; then all changes at once."""
    held = Held("thbip_ii")
    held.tick()
    held.controller.command(speed=(0.1, 0.0))
    held.controller.walk()
    held.stance_only()
    before = held.groups.template.latched.values.copy()
    wanted = {"speed": (0.3, -0.1), "period": 0.3, "alpha": 0.4, "height": 0.34, "lift": 0.05, "width": 0.07}
    held.controller.command(**wanted, yaw_rate=0.3)
    for _ in range(100):
        held.stance_only()
        np.testing.assert_array_equal(held.groups.template.latched.values, before)
    while held.groups.template.step.count[0] == 1:
        held.stance_only(swing=500.0)
    np.testing.assert_array_equal(held.controller.telemetry.command, [0.3, -0.1, 0.3, 0.4, 0.34, 0.05, 0.07, 0.3])
