"""One loop around any backend: orders in time, an even clock, bounded memory, and no need of the truth."""

from __future__ import annotations

import io
import math
import sys
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.simulation.standing import posture, robot

from gaitsmith.control import Controller
from gaitsmith.errors import BadInput
from gaitsmith.log.columns import Columns
from gaitsmith.log.record import Recorder, read_stream
from gaitsmith.simulation.belief import Belief
from gaitsmith.simulation.episode import Simulation, run_episode
from gaitsmith.simulation.loop import BackendError, Loop, Order, Script, replayed
from gaitsmith.simulation.monitor import Monitor
from gaitsmith.simulation.plant import Plant
from gaitsmith.simulation.scenario import make_scenario

DT = 1e-3


class Robot:
    """A backend that measures, steps and has a clock, and nothing else."""

    control_step = DT

    def __init__(self) -> None:
        self._plant = Plant(robot())
        self._plant.reset(posture())
        self.measure, self.step = self._plant.measure, self._plant.step

    @property
    def time(self) -> float:
        return 1000.0 + self._plant.time  # its own epoch


@cache
def _controller() -> Controller:
    return Controller(robot())


def _loop(backend, commands=None, observers=()):
    controller = _controller()
    controller.reset()
    return Loop(backend, controller, commands or Script([], DT), observers)


@pytest.mark.parametrize("advance", [0.0, -0.5, 0.2, math.nan])
def test_a_clock_that_stops_or_jumps_is_told_in_one_line(advance):
    class Broken(Robot):
        wrong = 0.0

        @property
        def time(self):
            return super().time + self.wrong

    backend = Broken()
    loop = _loop(backend)
    for _ in range(3):
        assert loop.step()
    backend.wrong = advance - DT
    with pytest.raises(
        BackendError, match=r"backend's clock: got '.* in one step, after 0\.003 s', expected"
    ) as caught:
        loop.step()
    assert isinstance(caught.value, BadInput)
    assert "\n" not in str(caught.value)
    assert caught.value.remedy


def test_a_loop_needs_no_truth():
    controller = _controller()
    backend = Robot()
    belief = Belief(controller.telemetry, [leg.name for leg in robot().legs], DT)
    names = [f"believed.{name}" for name in belief.columns]
    columns = Columns((controller.telemetry_columns, controller.telemetry_buffer), (names, belief.buffer))
    monitor = Monitor(robot(), controller.parameters, columns, DT, controller.gait.model_dump())
    file = io.BytesIO()
    recorder = Recorder(file, columns.buffers, columns.names, {})
    script = Script([(0.1, Order({"speed": (0.1, 0.0)}, "walk"))], DT)
    loop = _loop(backend, script, (belief, monitor, recorder))
    while loop.time < 1.5 - 1e-9:
        assert loop.step()
    recorder.close()
    log = read_stream(io.BytesIO(file.getvalue()), "file")
    assert [stage.rest for stage in monitor.stages()] == [True, False]
    assert log.column("mode")[-1] == 1.0
    assert not any(name.startswith("true.") for name in log.columns)
    assert log.events == ({"time": pytest.approx(0.1), "command": {"speed": [0.1, 0.0]}, "action": "walk"},)


@given(st.lists(st.tuples(st.integers(0, 60), st.integers(0, 1000)), max_size=12))
def test_orders_come_at_the_nearest_tick_in_sequence(given_orders):
    orders = [(1e-3 * tick, Order({"n": k})) for k, (tick, _) in enumerate(given_orders)]
    script, seen = Script(orders, DT), []
    for tick in range(70):
        seen += [(tick, order.command["n"]) for order in script.poll(tick * DT)]
    assert seen == sorted((tick, k) for k, (tick, _) in enumerate(given_orders))


def test_a_log_replayed_gives_the_same_run():
    changes = [{"time": 1.0, "speed": [0.2, 0.0]}, {"time": 1.7, "height": 0.68}]
    scenario = make_scenario({"duration": 2.5, "rest_before": 0.3, "rest_after": 0.4, "changes": changes})
    first = run_episode(scenario, robot=robot()).log
    commands = replayed(first, DT)
    again = Simulation(make_scenario({"duration": 2.5}), robot=robot(), commands=commands).run().log
    assert [event["time"] for event in first.events] == pytest.approx([0.3, 1.0, 1.7, 2.1])
    np.testing.assert_array_equal(first.rows, again.rows)


class Restless:
    """Random orders without an end."""

    def __init__(self) -> None:
        self._rng = np.random.default_rng(0)

    def poll(self, time):
        tick = round(time / DT)
        if tick == 100:
            return [Order(action="walk")]
        return [Order({"speed": (float(self._rng.uniform(-0.2, 0.3)), 0.0)})] if tick % 500 == 0 else []


def test_memory_stays_flat_under_random_commands():
    simulation = Simulation(make_scenario({"duration": 60.0}), robot=robot(), commands=Restless())
    blocks = []
    for tick in range(10_000):
        assert simulation.step()
        if tick % 5000 == 4999:
            blocks.append(sys.getallocatedblocks())
    # A stage of 0.5 s is one string; a tick must leave nothing.
    assert blocks[1] - blocks[0] < 200
    summary = simulation.summary()
    assert len(summary.stages) == 21
    assert summary.memory_mb.end > 0.0
    assert summary.log.rows == 2500


def test_a_controller_with_another_state_than_the_scenario_is_refused():
    with pytest.raises(BadInput, match="controller's state: got 'true', expected estimated"):
        Simulation(make_scenario({"state": "estimated"}), robot=robot(), controller=_controller())
