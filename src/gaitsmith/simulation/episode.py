"""One run in closed loop: scenario in, summary and log out."""

from __future__ import annotations

import gc
import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from time import perf_counter, perf_counter_ns
from typing import Any

import numpy as np
import numpy.typing as npt

from gaitsmith.control import Controller
from gaitsmith.kinematics.posture import standing_posture
from gaitsmith.log.record import Log, Recorder
from gaitsmith.robots import Robot, load_robot
from gaitsmith.robots.parameters import GaitParameters, at_rest, gait_numbers
from gaitsmith.simulation import plant as physics
from gaitsmith.simulation.disturbances import Pushes, StrideClock
from gaitsmith.simulation.fall import Fall, explain
from gaitsmith.simulation.monitor import UPRIGHT, Monitor
from gaitsmith.simulation.scenario import Scenario, check_scenario
from gaitsmith.simulation.summary import (
    FallReport,
    QpCounts,
    Span,
    StageCommand,
    Summary,
    measure_stages,
    tick_times,
)
from gaitsmith.simulation.terrain import parse_terrain

Progress = Callable[[float], None]
_PROGRESS_EVERY = 100  # ticks


@dataclass(frozen=True)
class Episode:
    """A finished run.

    Attributes:
        summary: in numbers.
        log: rows of the run; None if it was not recorded.
        interrupted: whether Ctrl-C cut it short; summary and log hold everything up to then.
    """

    summary: Summary
    log: Log | None
    interrupted: bool


class Simulation:
    """A run that can be stepped.

    Args:
        scenario: what to run.
        robot: instead of loading the scenario's.
        controller: instead of making one from the scenario; it is reset.
        record: whether to keep a log.

    Attributes:
        robot, plant, controller: the closed loop's parts.
        fall: the fall, None while upright.
        tick: control ticks done.

    Raises:
        BadInput: the scenario does not fit the robot.
    """

    def __init__(
        self,
        scenario: Scenario,
        *,
        robot: Robot | None = None,
        controller: Controller | None = None,
        record: bool = True,
    ) -> None:
        self.scenario = scenario
        self.robot = robot if robot is not None else load_robot(scenario.robot)
        check_scenario(scenario, self.robot)
        self._gait = GaitParameters.model_validate({**self.robot.card.gait.model_dump(), **scenario.given()})
        self.controller = controller or Controller(
            self.robot, preset=scenario.preset, state=scenario.state, gait=self._gait
        )
        self.plant = physics.Plant(
            self.robot,
            terrain=parse_terrain(scenario.terrain, scenario.seed),
            sensors=scenario.sensors if scenario.state == "estimated" else None,
            joint_friction=scenario.joint_friction,
            torque_delay=scenario.torque_delay,
            friction=scenario.friction,
            mass_factor=scenario.mass_factor,
            mass_spread=scenario.mass_spread,
            seed=scenario.seed,
            region=scenario.region(),
        )
        for push in scenario.pushes:
            self.plant.body_id(push.body)
        self._warm_up()
        step = self.plant.control_step
        self.ticks = max(1, round(scenario.duration / step))
        self.tick = 0
        self.fall: Fall | None = None
        self._pushes = Pushes(scenario.pushes, self.plant, step)
        self._clock = StrideClock() if any(push.phase is not None for push in scenario.pushes) else None
        self._monitor = Monitor(self.robot, self.controller, self.plant, scenario.duration)
        self._recorder = self._make_recorder() if record else None
        self._tick_ns = np.zeros(self.ticks, dtype=np.int64)
        self._wall = 0.0
        self._events = self._schedule()
        self._warned = len(physics.heard)
        self.interrupted = False

    def _warm_up(self) -> None:
        """Load everything compiled before time is measured, then put the robot on the ground, at rest."""
        start = standing_posture(self.robot, self._gait.height, self._gait.width)
        self.plant.reset(start)
        self.controller.reset()
        self.plant.measure(self.controller.measurement)
        self.plant.step(self.controller.tick())
        Monitor(self.robot, self.controller, self.plant, self.scenario.duration).watch()
        self.plant.reset(start)
        self.controller.reset()
        self.controller.command(**self._gait.model_dump())

    def _make_recorder(self) -> Recorder:
        """Recorder of the controller's telemetry and the plant's truth."""
        columns = (*self.controller.telemetry_columns, *(f"true.{name}" for name in self.plant.observed_columns))
        return Recorder(self.controller.telemetry_buffer, self.plant.observed, columns, self.ticks)

    def _schedule(self) -> list[tuple[int, Callable[[], None]]]:
        """What to tell the controller, by tick, last first."""
        scenario, step = self.scenario, self.plant.control_step
        events: list[tuple[int, Callable[[], None]]] = []
        for change in scenario.changes:
            given = change.given()
            events.append((round(change.time / step), lambda given=given: self.controller.command(**given)))  # type: ignore[misc]
        events.append((round(scenario.walk_from / step), self._start_walking))
        if scenario.rest_after > 0.0:
            events.append((round(scenario.walk_until / step), self.controller.stand))
        return sorted(events, key=lambda event: -event[0])

    def _start_walking(self) -> None:
        """Ask for a walk, and count the drift from here."""
        self.controller.walk()
        self.plant.restart_excursion()

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self.tick * self.plant.control_step

    @property
    def tick_us(self) -> npt.NDArray[np.float64]:
        """Wall time of every control tick so far, µs."""
        return np.asarray(self._tick_ns[: self.tick] * 1e-3, dtype=np.float64)

    def step(self) -> bool:
        """One control tick; False once the run is over, by its duration or by a fall."""
        if self.tick >= self.ticks or self.fall is not None:
            return False
        while self._events and self._events[-1][0] <= self.tick:
            self._events.pop()[1]()
        controller, plant = self.controller, self.plant
        plant.measure(controller.measurement)
        before = perf_counter_ns()
        torque = controller.tick()
        self._tick_ns[self.tick] = perf_counter_ns() - before
        state = self._monitor.watch()
        if self._recorder is not None:
            self._recorder.keep(self.tick)
        if state != UPRIGHT:
            self._end_in_fall(state)
            return False
        if not self._pushes.done:
            self._pushes.apply(self.tick * plant.control_step, self._phase())
        plant.step(torque)
        self.tick += 1
        return self.tick < self.ticks

    def _phase(self) -> float:
        """Phase of the stride, NaN if no push asks for it."""
        if self._clock is None:
            return math.nan
        telemetry = self.controller.telemetry
        return self._clock.phase(
            self.tick * self.plant.control_step,
            telemetry.mode[0] == 1.0,
            int(telemetry.stance[0]),
            float(telemetry.step_time[0]),
            int(telemetry.step_count[0]),
            float(telemetry.command[2]),
        )

    def _end_in_fall(self, kind: int) -> None:
        """Note the fall and its explanation."""
        telemetry = self.controller.telemetry
        mode, stance = int(telemetry.mode[0]), int(telemetry.stance[0])
        step_time, period = float(telemetry.step_time[0]), float(telemetry.command[2])
        self.fall = explain(kind, self.time, self._monitor, mode, stance, step_time, period)

    def run(self, progress: Progress | None = None) -> Episode:
        """Step until the end, a fall, or Ctrl-C.

        Args:
            progress: called with the simulated time, s, ten times a simulated second.
        """
        collecting = gc.isenabled()
        gc.disable()
        began = perf_counter()
        try:
            while self.step():
                if progress is not None and self.tick % _PROGRESS_EVERY == 0:
                    progress(self.time)
        except KeyboardInterrupt:
            self.interrupted = True
        finally:
            self._wall += perf_counter() - began
            if collecting:
                gc.enable()
        if progress is not None and not self.interrupted:
            progress(self.time)
        return Episode(self.summary(), self.log(), self.interrupted)

    def log(self) -> Log | None:
        """Rows so far; None if the run is not recorded."""
        if self._recorder is None:
            return None
        notes: dict[str, Any] = {
            "scenario": self.scenario.model_dump(mode="json"),
            "robot": self.robot.card.name,
            "robot_hash": self.robot.content_hash,
        }
        return self._recorder.log(notes)

    def _spans(self) -> list[Span]:
        """Stages between changes of the command, in control ticks."""
        scenario, step = self.scenario, self.plant.control_step
        walk_from, walk_until = round(scenario.walk_from / step), round(scenario.walk_until / step)
        marks = {0, walk_from, walk_until, self.ticks}
        changes = [(round(change.time / step), change.given()) for change in scenario.changes]
        marks.update(tick for tick, _ in changes)
        edges = sorted(mark for mark in marks if mark <= self.ticks)
        spans = []
        for first, last in pairwise(edges):
            gait = self._gait.model_dump()
            for tick, given in changes:
                if tick <= first:
                    gait.update(given)
            rest = first < walk_from or first >= walk_until
            numbers = gait_numbers(at_rest(gait) if rest else gait, keys=True)
            command = StageCommand.model_validate({key: value for key, _, value in numbers})
            spans.append(Span(first, last, rest, command))
        return spans

    def summary(self) -> Summary:
        """The run so far, in numbers."""
        monitor, plant, telemetry, scenario = self._monitor, self.plant, self.controller.telemetry, self.scenario
        kept, step = monitor.kept, plant.control_step
        seen = monitor.ticks if self.fall is None else monitor.ticks - 1
        vitals = kept.vitals[: max(seen, 0)]
        start = min(round(scenario.walk_from / step), max(len(vitals) - 1, 0))
        walked = vitals[-1, 6:8] - vitals[start, 6:8] if len(vitals) else np.zeros(2)
        yaw = np.degrees(vitals[:, 5]) if len(vitals) else np.zeros(1)
        ticks = max(monitor.ticks, 1)
        names = monitor.joint_names
        return Summary(
            fell=self.fall is not None,
            fall=FallReport(time=self.fall.time, phase=self.fall.phase, reason=self.fall.reason) if self.fall else None,
            interrupted=self.interrupted,
            robot=self.robot.card.name,
            preset=scenario.preset,
            state=scenario.state,
            terrain=scenario.terrain,
            seed=scenario.seed,
            duration=self.time,
            steps=int(telemetry.step_count[0]),
            stages=measure_stages(self._spans(), vitals, monitor.touchdowns, step),
            drift=plant.excursion,
            distance=float(np.hypot(*walked)),
            yaw_deg=(float(np.min(yaw)), float(np.max(yaw))),
            min_foot_separation=plant.min_separation,
            leg_contacts=plant.leg_contacts,
            torque_peak=dict(zip(names, kept.torque_peak.tolist(), strict=True)),
            torque_saturated=dict(zip(names, (kept.torque_saturated / ticks).tolist(), strict=True)),
            qp=QpCounts(
                solves=int(telemetry.qp_solves[0]),
                fallbacks=int(telemetry.qp_fallbacks[0]),
                infeasible=int(telemetry.qp_infeasible[0]),
            ),
            tick_us=tick_times(self._tick_ns[: monitor.ticks], step),
            realtime_factor=self.time / self._wall if self._wall > 0.0 else 0.0,
            pushes=tuple(None if math.isnan(began) else began for began in self._pushes.started),
            warnings=tuple(physics.heard[self._warned :]),
        )


def run_episode(
    scenario: Scenario,
    *,
    robot: Robot | None = None,
    controller: Controller | None = None,
    progress: Progress | None = None,
    record: bool = True,
) -> Episode:
    """Run a scenario from beginning to end; see :class:`Simulation` and :class:`Episode`.

    Raises:
        BadInput: the scenario does not fit the robot.
    """
    return Simulation(scenario, robot=robot, controller=controller, record=record).run(progress)
