"""Standing, stepping, switching, and coming to rest, on a robot held still whose sole forces the test decides."""

from __future__ import annotations

import numpy as np
import pytest
from tests.control.walking import Held, Record, records

from gaitsmith.template.step import LEFT, RIGHT, STAND, WALK

DT = 1e-3
FAST_ENOUGH = 0.2  # m/s, more than the speed at which a walk may end


def walking(held: Held, speed: tuple[float, float] = (0.0, 0.0)) -> Held:
    """Take the first step."""
    held.controller.command(speed=speed)
    held.controller.walk()
    held.tick(0.0, 0.0)
    return held


def until_switch(held: Held, force: float = 0.0, limit: int = 2000) -> int:
    """Tick with a force on both soles until the legs switch; how many ticks it took."""
    count = int(held.groups.step.count[0])
    for tick in range(1, limit):
        held.tick(force, force)
        if held.groups.step.count[0] != count:
            return tick
    raise AssertionError("no switch")


def test_stands_until_told_to_walk() -> None:
    held = Held()
    for _ in range(500):
        held.tick()
    step = held.groups.step
    assert (step.mode[0], step.count[0], step.time[0]) == (STAND, 0, 0.0)
    assert held.controller.telemetry.stance[0] == 2.0
    walking(held)
    assert (step.mode[0], step.count[0]) == (WALK, 1)


@pytest.mark.parametrize(("lateral", "stance"), [(-0.1, LEFT), (0.1, RIGHT)])
def test_first_step_goes_where_the_command_points(lateral: float, stance: int) -> None:
    """To the left the left leg swings, so the right one bears; and the other way round."""
    assert walking(Held(), (0.0, lateral)).groups.step.stance[0] == stance


def test_first_step_starts_from_rest() -> None:
    """Support from where its sole is, at rest; swing from its actual state; both references from the joints."""
    held = walking(Held())
    step, frames, control = held.groups.step, held.groups.frames, held.groups.control
    stance = int(step.stance[0])
    np.testing.assert_array_equal(step.support_start[0], frames.relative[stance, 0])
    assert not np.any(step.support_start[1:])
    np.testing.assert_array_equal(step.swing_start, frames.relative[1 - stance])
    reach = held.robot.velocity_limit[0] * DT
    for row, leg in enumerate(held.robot.legs):
        np.testing.assert_allclose(control.leg_reference[row], held.q[7 + leg.joint_indices], atol=reach)


def test_step_ends_at_the_clock_without_contact() -> None:
    """And is counted as forced."""
    held = walking(Held())
    ticks = until_switch(held)
    assert abs(ticks * DT - held.controller.parameters.touchdown.latest * held.gait.period) <= 2.0 * DT
    assert held.controller.telemetry.touchdowns_forced[0] == 1.0
    until_switch(held)
    assert held.controller.telemetry.touchdowns_forced[0] == 2.0


def test_early_contact_ends_the_step_at_the_earliest_time() -> None:
    """Contact all along does not end the step at once."""
    held = walking(Held())
    ticks = until_switch(held, force=500.0)
    assert abs(ticks * DT - held.controller.parameters.touchdown.earliest * held.gait.period) <= 2.0 * DT
    assert held.controller.telemetry.touchdowns_forced[0] == 0.0


def test_only_the_swing_sole_counts() -> None:
    """The stance sole is loaded all the time; it must not end the step."""
    held = walking(Held(), (0.0, 0.1))
    for _ in range(int(1.2 * held.gait.period / DT)):
        held.tick(left=0.0, right=400.0)
    assert held.groups.step.count[0] == 1
    held.tick(left=400.0, right=0.0)
    assert held.groups.step.count[0] == 2
    assert held.groups.step.stance[0] == LEFT


def test_commands_wait_for_the_switch() -> None:
    """Section 2.3: whatever is asked for in mid-step, the step is finished as it began."""
    held = walking(Held(), (0.1, 0.0))
    before = [array.copy() for array in held.groups.latched]
    wanted = {"speed": (0.3, -0.1), "period": 0.3, "alpha": 0.4, "height": 0.6, "lift": 0.05, "width": 0.05}
    held.controller.command(**wanted)
    for _ in range(100):
        held.tick(0.0, 0.0)
        for now, then in zip(held.groups.latched, before, strict=True):
            np.testing.assert_array_equal(now, then)
    until_switch(held, force=500.0)
    for name, value in wanted.items():
        np.testing.assert_array_equal(getattr(held.groups.latched, name), np.atleast_1d(value), err_msg=name)
    np.testing.assert_array_equal(held.controller.telemetry.command, [0.3, -0.1, 0.3, 0.4, 0.6, 0.05, 0.05])


def test_height_moves_slowly_while_standing() -> None:
    """A jump of the commanded height is followed at a bounded rate, and reached."""
    held = Held()
    held.controller.command(height=0.55)
    heights = [held.gait.height]
    for _ in range(1500):
        held.tick()
        heights.append(float(held.groups.control.standing_height[0]))
    assert np.max(np.abs(np.diff(heights))) <= 0.15 * DT * (1.0 + 1e-9)
    assert heights[-1] == pytest.approx(0.55, abs=1e-12)


def stop(held: Held, steps: int = 6) -> int:
    """Ask for rest and count the steps until the robot stands, or all of them."""
    held.controller.stand()
    for k in range(steps):
        until_switch(held, force=500.0)
        if held.groups.step.mode[0] == STAND:
            return k + 1
    return steps


def test_comes_to_rest_when_slow() -> None:
    """Soles side by side and the CoM slow: the walk ends at a switch, at the height that the hips have then."""
    held = walking(Held())
    until_switch(held, force=500.0)
    assert stop(held) <= 2
    assert held.groups.step.mode[0] == STAND
    assert held.groups.control.standing_height[0] == pytest.approx(held.gait.height, abs=1e-6)
    assert held.groups.targets.in_contact.tolist() == [1, 1]


def test_does_not_stop_at_speed() -> None:
    held = walking(Held(), (0.2, 0.0))
    held.v[0] = FAST_ENOUGH
    until_switch(held, force=500.0)
    assert stop(held) == 6
    assert held.groups.step.mode[0] == WALK


def test_does_not_stop_on_a_forced_touchdown() -> None:
    """A sole that found no ground bears nothing."""
    held = walking(Held())
    until_switch(held)
    held.controller.stand()
    for _ in range(3):
        until_switch(held)
        assert held.groups.step.mode[0] == WALK


def test_walks_on_when_asked_again() -> None:
    held = walking(Held())
    until_switch(held, force=500.0)
    stop(held)
    count = int(held.groups.step.count[0])
    walking(held)
    assert held.groups.step.mode[0] == WALK
    assert held.groups.step.count[0] == count + 1


def at_switches() -> list[Record]:
    """Every switch of a walk on the plant."""
    switches = [record for record in records("bhr_b2") if 0 < record.step.count[0] < record.groups.step.count[0]]
    assert len(switches) >= 5
    return switches


def test_support_goes_on_from_the_desired_state() -> None:
    """First rule of section 2.2: position, velocity, and acceleration are continuous through the switch."""
    for record in at_switches():
        landed = int(record.groups.step.stance[0])
        assert landed != record.step.stance[0]
        desired = record.foot_desired[3 * landed : 3 * landed + 3]
        np.testing.assert_array_equal(record.groups.step.support_start, desired)
        if record.groups.step.mode[0] == WALK:
            now = record.groups.control.foot_desired[3 * landed : 3 * landed + 3, 2]
            np.testing.assert_allclose(now, desired[:, 2], rtol=0.0, atol=1e-9)


def test_swing_goes_on_from_the_actual_state() -> None:
    """Second rule of section 2.2."""
    for record in at_switches():
        step, frames, control = record.groups.step, record.groups.frames, record.groups.control
        if step.mode[0] == STAND:
            continue
        swing = 1 - int(step.stance[0])
        np.testing.assert_array_equal(step.swing_start, frames.relative[swing])
        assert step.swing_pitch_start[0] == frames.sole_pitch[swing]
        np.testing.assert_allclose(control.foot_desired[3 * swing], frames.relative[swing, 0], atol=1e-9)
        assert step.time[0] == 0.0


def test_the_clock_runs_in_ticks() -> None:
    for record in records("bhr_b2"):
        before, after = record.step, record.groups.step
        if before.mode[0] == after.mode[0] == WALK and before.count[0] == after.count[0]:
            assert after.time[0] - before.time[0] == pytest.approx(DT, abs=1e-12)
        if after.mode[0] == STAND and before.mode[0] == STAND:
            assert after.time[0] == before.time[0]
