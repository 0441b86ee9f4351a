"""One run in closed loop with physics: scenario in, summary and log out."""

from __future__ import annotations

import contextlib
import gc
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from gaitsmith.control import Controller
from gaitsmith.errors import BadInput, GaitsmithError
from gaitsmith.kinematics.posture import standing_posture
from gaitsmith.log.columns import Columns
from gaitsmith.log.record import DECIMATION, Log, Recorder, Scratch, new_file, read_back
from gaitsmith.robots import Robot, load_robot
from gaitsmith.robots.footing import check_soles
from gaitsmith.simulation.diagnosis import Suspect, suspects
from gaitsmith.simulation.disturbances import Disturber
from gaitsmith.simulation.engines import engine_of
from gaitsmith.simulation.fall import Fall
from gaitsmith.simulation.footholds import Guided, source_of
from gaitsmith.simulation.injection import Injector
from gaitsmith.simulation.library_run import Steered, family_of
from gaitsmith.simulation.loop import Backend, Commands, Loop, Observer
from gaitsmith.simulation.memory import resident_mb
from gaitsmith.simulation.monitor import UPRIGHT, Monitor
from gaitsmith.simulation.orders import commanded_first, commands_of, controller_of, first_gait
from gaitsmith.simulation.planned_run import Tracked, balls_of, plan_of, region_of
from gaitsmith.simulation.reactions import DAMPED, DRIVES, Reactions, with_unnoticed
from gaitsmith.simulation.remote import RemoteController
from gaitsmith.simulation.report import explain, phase_in_words, refused_readings, sum_up
from gaitsmith.simulation.run_folder import log_notes
from gaitsmith.simulation.scenario import Scenario, check_scenario
from gaitsmith.simulation.scene_log import SceneLog
from gaitsmith.simulation.strides import Strides
from gaitsmith.simulation.summary import LogCounts, Memory, Summary
from gaitsmith.simulation.terrain import Region, parse_terrain
from gaitsmith.simulation.tour import Guide
from gaitsmith.simulation.wall_time import Stopwatch, WallTimes

Progress = Callable[[float], None]
_PROGRESS_EVERY = 100  # ticks
_COLLECT_EVERY = 10_000  # ticks
_PLANT = {  # as the plant calls them
    *("joint_friction", "joint_frictions", "torque_delay", "friction", "mass_factor", "mass_spread"),
    *("torso_shift", "seed"),
}


@dataclass(frozen=True)
class Episode:
    """A finished run.

    Attributes:
        file: of the log; None if it was not recorded.
        interrupted: whether a signal cut it short; summary and log hold everything up to then.
    """

    summary: Summary
    file: BinaryIO | None
    interrupted: bool

    @cached_property
    def log(self) -> Log | None:
        """Rows of the run, read back from the file when they are asked for; None if it was not recorded."""
        return None if self.file is None else read_back(self.file)


class Simulation:
    """A run that can be stepped.

    Args:
        robot: instead of loading the scenario's.
        controller: instead of making one from the scenario; it is reset.
        record: whether to keep a log, in a temporary file; or the path of a new file, or what opens one, unbuffered,
            once everything else is right.
        commands: instead of the scenario's walk, changes and rest.
        passing: whether the legs pass through each other, to see what would be.
        region: where ground is needed, if the commands lead elsewhere than the scenario.

    Attributes:
        robot, plant, controller: the closed loop's parts.
        columns: telemetry of the controller and the plant's truth, by name.
        ticks: after which it is over, if nothing ends it before.

    Raises:
        BadInput: the scenario does not fit the robot or the controller, or the log cannot be written.
    """

    def __init__(
        self,
        scenario: Scenario,
        *,
        robot: Robot | None = None,
        controller: Controller | None = None,
        record: bool | str | Path | Callable[[], BinaryIO] = True,
        commands: Commands | None = None,
        region: Region | None = None,
        passing: bool = False,
    ) -> None:
        self.scenario = scenario
        self.robot = robot if robot is not None else load_robot(scenario.robot)
        if robot is None:
            check_soles(self.robot)
        check_scenario(scenario, self.robot)
        self._gait = first_gait(scenario, self.robot)
        self.controller = controller or controller_of(scenario, self.robot, self._gait)
        state = "estimated" if self.controller.estimated else "true"
        if state != scenario.state:
            remedy = "make both alike: the scenario says what the plant's sensors give"
            raise BadInput("controller's state", state, f"{scenario.state}, the scenario's", remedy)
        self._family = family_of(scenario, self.robot)
        self.plan = plan_of(scenario, self.robot) if self._family is None else self._family.plan
        self._commanded = commanded_first(scenario, self._gait, self.plan, self._family)
        if self.plan is not None:
            self.controller.reset()
            self.controller.load(self.plan, scenario.tracking)
        self._terrain = parse_terrain(scenario.terrain, scenario.seed)
        source = source_of(scenario, self._terrain, self.robot)
        self._region = region or region_of(self.plan, scenario)
        self.plant = engine_of(scenario.engine)(
            self.robot,
            terrain=self._terrain,
            sensors=scenario.sensors if scenario.state == "estimated" else None,
            region=self._region,
            props=balls_of(self.plan, self.robot),
            passing=passing,
            **scenario.model_dump(include=_PLANT),
        )
        for k, push in enumerate(scenario.pushes):
            try:
                self.plant.push(np.zeros(3), push.body, push.joint)
            except BadInput as error:
                raise error.named(error.field.replace("push", f"pushes[{k}]", 1)) from None
        self.columns = Columns(
            (self.controller.telemetry_columns, self.controller.telemetry_buffer),
            ([f"true.{name}" for name in self.plant.truth_columns], self.plant.truth_buffer),
        )
        step = self.plant.control_step
        self._warm_up()
        self.ticks = max(1, round(scenario.duration / step))
        self._monitor = self._make_monitor()
        self._disturber = Disturber(scenario.pushes, self.plant, self.columns, self._tell)
        self._file = new_file(record) if record else None
        self._recorder = self._make_recorder(self._file) if self._file is not None else None
        told = self._tell if scenario.gait else None
        self._tracked = Tracked(self.plan, self.controller, self.plant, told) if self.plan is not None else None
        self._reactions = Reactions(self.columns, self.controller.estimated, step, self._tell)
        if isinstance(self.controller, RemoteController):
            self.controller.stopped = lambda why: self._reactions.add("controller", why, DAMPED)
        self._strides = Strides(self.columns, self._monitor.prefix, scenario, step, self.robot, self._commanded)
        tour = scenario.tour
        self._guide = Guide(tour, self.plant, self.controller, scenario.walk_from) if tour is not None else None
        seeing = (self._monitor, self._recorder, self._reactions, self._strides, self._disturber, self._tracked)
        self._eyes = None if source is None else Guided(source, self.controller, self.plant.truth)
        watching: list[Observer | None] = [*seeing, self._guide, self._eyes]
        observers = [observer for observer in watching if observer is not None]
        orders = commands_of(scenario, self.controller, self._family, step, self._tell, commands or self._guide)
        backend: Backend = self.plant
        if scenario.faults:
            braked = partial(self._reactions.add, "ticks", "late", DRIVES)
            backend = Injector(self.plant, scenario.faults, self.robot, self._tell, braked)
        self._steered = orders if isinstance(orders, Steered) else None
        self.loop = Loop(backend, self.controller, orders, observers, getattr(backend, "withholds", None))
        self._watch, self._memory = Stopwatch(), resident_mb()
        self.interrupted = False

    def _tell(self, event: Mapping[str, Any]) -> None:
        """Let all observers hear of something."""
        self.loop.tell(event)

    def _warm_up(self) -> None:
        """Load everything compiled before time is measured, then put the robot on the ground, at rest."""
        start = (standing_posture(self.robot, self._gait.height, self._gait.width), np.zeros(self.robot.model.nv))
        if self.plan is not None:
            start = self.plan.start
        self.plant.reset(*start)
        self.controller.reset()
        self.plant.measure(self.controller.measurement)
        self.plant.step(self.controller.tick())
        self._make_monitor().observe(0)
        self.plant.reset(*start)
        self.controller.reset()
        self.controller.command(**self._gait.model_dump())
        self.controller.reset()  # a controller that has walked before still has its last gait latched

    def _make_monitor(self) -> Monitor:
        step = self.plant.control_step
        return Monitor(self.robot, self.controller.parameters, self.columns, step, self._commanded)

    def _make_recorder(self, file: BinaryIO) -> Recorder:
        """Recorder of the controller's telemetry and the plant's truth."""
        notes = log_notes(self.scenario, self.robot, self.plant.control_step, self._commanded)
        return Recorder(file, self.columns.buffers, self.columns.names, notes, DECIMATION, self.scene_log())

    def scene_log(self) -> SceneLog:
        """What other programs draw of a log of this run."""
        step, ground = self.plant.control_step * DECIMATION, self._terrain.blocks(self._region or Region())
        return SceneLog(self.robot, self.columns.names, step, ground, lambda: self.wall_times.lap())

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self.loop.time

    @property
    def tick(self) -> int:
        """Control ticks done."""
        return self.loop.tick

    @property
    def wall_times(self) -> WallTimes:
        """Of the control ticks so far."""
        return self.loop.wall_times

    @cached_property
    def _fall(self) -> Fall:
        phase = phase_in_words(self.columns) if self._tracked is None else self._tracked.phase
        return explain(self._monitor, self.time, phase, refused_readings(self.columns), self.suspects()[0].what)

    def suspects(self) -> list[Suspect]:
        """What may have caused the fall that has just been seen, the likeliest first."""
        hits, pushes = self._monitor.dated_hits(self.time), self._disturber.pushes.started
        began = [None if math.isnan(time) else time for time in pushes]
        place = float(self._monitor.kept.place[0])
        return suspects(self.scenario, hits, began, self._reactions.found, place, self.time, self.robot)

    @property
    def fall(self) -> Fall | None:
        """The fall, None while upright."""
        return self._fall if self._monitor.state != UPRIGHT else None

    def watch(self, observer: Observer) -> None:
        """Let one more observer see every tick, after the others."""
        self.loop.observers = (*self.loop.observers, observer)

    def step(self) -> bool:
        """One control tick; False once the run is over, by its duration or by a fall.

        Raises:
            BadInput: the disk is full.
            GaitsmithError: the physics engine stopped.
        """
        if self.loop.tick >= self.ticks:
            return False
        return self.loop.step() and self.loop.tick < self.ticks

    def run(self, progress: Progress | None = None) -> Episode:
        """Step until the end, a fall, or a signal that is heard as KeyboardInterrupt; then finish the log.

        Args:
            progress: called with the simulated time, s, ten times a simulated second.

        Raises:
            BadInput: the disk is full; the log is kept up to then.
            GaitsmithError: the physics engine stopped; the log is finished.
        """
        try:
            with self._watch.running():
                while self.step():
                    tick = self.loop.tick
                    if progress is not None and tick % _PROGRESS_EVERY == 0:
                        progress(self.time)
                    if tick % _COLLECT_EVERY == 0:
                        gc.collect(1)
        except KeyboardInterrupt:
            self.interrupted = True
        except GaitsmithError:
            with contextlib.suppress(BadInput):
                self._close()
            raise
        if progress is not None and not self.interrupted:
            progress(self.time)
        return self.finish()

    def finish(self) -> Episode:
        """Finish the log and sum up.

        Raises:
            BadInput: the disk is full.
        """
        try:
            self._close()
        except KeyboardInterrupt:  # the log waits with it until it is in order
            self.interrupted = True
        return Episode(self.summary(), self._file, self.interrupted)

    def _close(self) -> None:
        if isinstance(self.controller, RemoteController):
            self.controller.close()
        if self._recorder is not None and self._file is not None:
            try:
                self._recorder.close()
            finally:
                if not isinstance(self._file, Scratch):
                    self._file.close()

    def log(self) -> Log | None:
        """Rows so far; None if the run is not recorded."""
        if self._recorder is None or self._file is None:
            return None
        if not self._recorder.closed:
            self._recorder.flush()
        return read_back(self._file)

    def summary(self) -> Summary:
        """The run so far, in numbers."""
        recorder = self._recorder
        return sum_up(
            self.scenario,
            self.robot,
            self._monitor,
            self.columns,
            duration=self.time,
            fall=self.fall,
            interrupted=self.interrupted,
            tick_us=self.wall_times.summary(),
            realtime_factor=self.time / self._watch.seconds if self._watch.seconds > 0.0 else 0.0,
            pushes=tuple(None if math.isnan(began) else began for began in self._disturber.pushes.started),
            **self._strides.report(self.fall is not None),
            warnings=(*self.plant.warnings, *(self._eyes.warnings if self._eyes else ())),
            memory_mb=Memory(start=self._memory, end=resident_mb()),
            tracking=self._tracked.report(self.time) if self._tracked and self.scenario.gait else None,
            faults=with_unnoticed(tuple(self._reactions.found), self.scenario.faults, self.time),
            steps_held=self._steered.held if self._steered is not None else None,
            tour=self._guide.report() if self._guide is not None else None,
            log=LogCounts(rows=recorder.rows, dropped=recorder.dropped, complete=recorder.closed) if recorder else None,
        )


def run_episode(
    scenario: Scenario,
    *,
    robot: Robot | None = None,
    controller: Controller | None = None,
    progress: Progress | None = None,
    record: bool | str | Path | Callable[[], BinaryIO] = True,
) -> Episode:
    """Run a scenario from beginning to end; see :class:`Simulation` and :class:`Episode`.

    Raises:
        BadInput: the scenario does not fit the robot.
    """
    return Simulation(scenario, robot=robot, controller=controller, record=record).run(progress)
