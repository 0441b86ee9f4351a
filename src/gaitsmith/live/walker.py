"""The process with the control loop: paced by the clock, steered by wishes, seen through frames."""

from __future__ import annotations

import gc
import os
import signal
import time
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np

from gaitsmith.errors import BadInput, GaitsmithError
from gaitsmith.live.frame import Frame
from gaitsmith.live.handover import Note, Ring
from gaitsmith.live.pace import Pace, go_first, wait_in_line
from gaitsmith.live.recording import Recording
from gaitsmith.live.steering import Shoves, Steering
from gaitsmith.live.wishes import FASTEST, SLOWEST, TERRAINS, WIDTH, Kind, Wish, understood
from gaitsmith.robots.parameters import check_gait, gait_numbers
from gaitsmith.simulation.episode import Simulation
from gaitsmith.simulation.loop import Order
from gaitsmith.simulation.scenario import make_scenario
from gaitsmith.simulation.terrain import Region

ROWS, WISHES = 512, 64
"""Frames and wishes that are kept for a reader."""
REGION = Region((-4.0, 14.0), (-3.0, 3.0))
"""Ground that is prepared, world, m; beyond it boxes and slopes give way to a level plane."""
_REST = 1.0  # s of standing before a walk
_FRAME = 0.01  # s of wall time between two frames
_IDLE = 0.005  # s of sleep while nothing moves
_COLLAPSE = 1.2  # s for which a robot that fell is watched falling
_LOOK = 0.5  # s between two looks whether the page is still there
_COLLECT = 20_000  # ticks


@dataclass(frozen=True)
class Request:
    """What to walk: fields of a :class:`gaitsmith.simulation.Scenario`, and where recordings go."""

    scenario: dict[str, Any]
    recordings: str


class Walker:
    """One walk after the other, as somebody steers.

    Args:
        pace: of the loop; by the wall clock if None.

    Attributes:
        frames: rows for the page.
        note: words for the page.
        first: whether ticks go ahead of ordinary processes.

    Raises:
        BadInput: the scenario does not fit the robot.
    """

    def __init__(self, request: Request, wishes: Ring, pace: Pace | None = None) -> None:
        self._request, self._wishes, self._seen = request, wishes, 0
        self._parent = os.getppid()
        self._scenario = make_scenario(request.scenario)
        self._paused, self._steps, self._ended, self._refused, self._episode = False, 0, False, 0, 0
        self._simulation: Simulation | None = None
        self._words: dict[str, Any] = {}
        self._fall: dict[str, Any] | None = None
        self._recording: Recording
        self._begin()
        simulation = self.simulation
        self.frame = Frame(simulation.columns.names, simulation.robot.model.nq, len(simulation.plant.balls))
        self.frames, self.note = Ring(len(self.frame.row), ROWS), Note()
        self._pace = pace or Pace(simulation.plant.control_step)
        self._busy = self._published = 0.0
        self._pace_mark = (time.perf_counter(), 0.0)
        self._speed, self.first = 1.0, False

    @property
    def simulation(self) -> Simulation:
        """The present walk."""
        assert self._simulation is not None
        return self._simulation

    def _begin(self) -> None:
        """A new walk, by the present gait; robot and controller stay."""
        old = self._simulation
        if old is not None:
            self._recording.stop()
            if old.plan is None:
                self._scenario = self._scenario.model_copy(update=old.controller.gait.model_dump())
        first = [(0.0, Order(action="follow"))] if self._scenario.gait else [(_REST, Order(action="walk"))]
        self._steering = Steering(first)
        self._simulation = Simulation(
            self._scenario,
            robot=old.robot if old else None,
            controller=old.controller if old else None,
            record=False,
            commands=self._steering,
            region=REGION,
        )
        done = self._recording.done if old else None
        self._recording = Recording(self._simulation, Path(self._request.recordings))
        self._recording.done = done
        self._shoves = Shoves(self._simulation)
        self._simulation.watch(self._recording)
        self._simulation.watch(self._shoves)
        self._episode += 1
        self._walks, self._over, self._after, self._trouble, self._fall = True, False, 0, "", None

    def run(self) -> None:
        """Until somebody wishes the end, or the page is gone."""
        looked = time.perf_counter()
        gc.collect()
        gc.freeze()
        gc.disable()
        self.first = go_first()
        self._pace.restart()
        while not self._ended:
            moved = self.turn()
            if self.first and self._pace.lost > 0.0:  # a loop that never sleeps leaves nothing to the page
                self.first = False
                wait_in_line()
            now = time.perf_counter()
            if now - self._published >= _FRAME:
                self.publish(now)
            if now - looked >= _LOOK:
                looked, self._ended = now, self._ended or os.getppid() != self._parent
            if not moved:
                time.sleep(_IDLE)
                self._pace.restart()
        self._recording.stop()
        self.publish(time.perf_counter())

    def turn(self) -> bool:
        """Obey what is wished for, then one tick if time goes on; whether it did."""
        if self._wishes.written != self._seen:
            rows, self._seen = self._wishes.read(self._seen)
            for row in rows:
                wish = understood(row.tolist())
                if wish is None or not self._obey(wish):
                    self._refused += 1
        if (self._paused and not self._steps) or (self._over and not self._after):
            return False
        if self._paused:
            self._steps -= 1
        else:
            self._pace.wait()
        began = time.perf_counter()
        self._tick()
        self._busy = max(self._busy, time.perf_counter() - began)
        if self.simulation.tick % _COLLECT == 0:
            gc.collect(1)
        return True

    def _tick(self) -> None:
        """One tick of the loop, or of a robot that has fallen and lies down."""
        simulation = self.simulation
        try:
            if self._over:
                simulation.plant.measure(simulation.controller.measurement)
                simulation.plant.step(simulation.controller.tick())
                self._after -= 1
            elif not simulation.loop.step():
                self._end()
        except GaitsmithError as error:
            self._trouble, self._after = str(error), 0
            self._end()

    def _end(self) -> None:
        """The walk is over."""
        fall = None if self._trouble else self.simulation.fall
        self._over, self._walks = True, False
        self._recording.stop()
        if fall is not None:
            self._fall = fall.model_dump(mode="json")
            self.simulation.plant.push(np.zeros(3))
            self.simulation.controller.damp()
            self._after = round(_COLLAPSE / self.simulation.plant.control_step)

    def _obey(self, wish: Wish) -> bool:
        """Do what is wished for; False if that is not possible."""
        kind, values = wish.kind, wish.values
        on = values[0] != 0.0
        if kind is Kind.GAIT:
            return self._command(values)
        if kind in (Kind.WALK, Kind.PUSH, Kind.HOLD) and (self._over or (kind is Kind.WALK and self.simulation.plan)):
            return False
        if kind is Kind.WALK:
            self._steering.act(Order(action="walk" if on else "stand"))
            self._walks = on
        elif kind is Kind.PUSH:
            self._shoves.push(values[:3])
        elif kind is Kind.HOLD:
            self._shoves.hold(values[:3])
        elif kind is Kind.PAUSE:
            self._paused, self._steps = on, 0
            self._pace.restart()
        elif kind is Kind.STEP:
            self._paused, self._steps = True, self._steps + min(max(int(values[0]), 0), 1000)
        elif kind is Kind.FACTOR:
            self._pace.factor = min(max(values[0], SLOWEST), FASTEST)
        elif kind is Kind.RESET:
            self._restart()
        elif kind is Kind.TERRAIN:
            return self._change_terrain(values)
        elif kind is Kind.RECORD:
            if on and not self._over:
                self._recording.start(self._walks)
            elif not on:
                self._recording.stop()
        else:
            self._ended = True
        return True

    def _command(self, values: tuple[float, ...]) -> bool:
        """Command a gait, if it is within the robot's limits and no plan is followed."""
        simulation = self.simulation
        if simulation.plan is not None:
            return False
        gait: dict[str, Any] = {}
        old = simulation.controller.gait.model_dump()
        for (_, place, _), value in zip(gait_numbers(old), values, strict=False):
            name, bracket, _ = place.partition("[")
            gait[name] = (*gait.get(name, ()), value) if bracket else value
        try:
            check_gait(gait, simulation.robot.card.gait_limits)
        except BadInput:
            return False
        self._steering.command(gait)
        return True

    def _change_terrain(self, values: tuple[float, ...]) -> bool:
        """Begin anew on another ground."""
        kind, amount, seed = values[:3]
        if not 0 <= kind < len(TERRAINS):
            return False
        name = TERRAINS[int(kind)]
        fields = self._scenario.model_dump(mode="json", exclude_none=True)
        terrain = name if name == "flat" else f"{name}:{amount:g}"
        try:
            self._scenario = make_scenario({**fields, "terrain": terrain, "seed": int(abs(seed)) % 2**32})
        except BadInput:
            return False
        self._restart()
        return True

    def _restart(self) -> None:
        """Begin anew, and count anew."""
        self._begin()
        self._pace.forget()
        self._pace.restart()
        self._steps, self._busy = 0, 0.0
        self._pace_mark = (time.perf_counter(), 0.0)

    def publish(self, now: float) -> None:
        """Hand over what is to be seen now, and what is to be read if it has changed."""
        simulation, frame, pace = self.simulation, self.frame, self._pace
        frame.fill(
            simulation.columns, simulation.plant, self._shoves.force, [b.position for b in simulation.plant.balls]
        )
        since, at = now - self._pace_mark[0], simulation.plant.time
        if since >= 0.5:
            self._speed = (at - self._pace_mark[1]) / since
            self._pace_mark = (now, at)
        frame.vitals[:] = (
            *(at, self._episode, pace.factor, self._speed, pace.ticks, pace.late, pace.worst, self._busy),
            *(self._paused, self._over, self._walks, self._recording.folder is not None, self._refused),
        )
        pace.worst = self._busy = 0.0
        self.frames.write(frame.row)
        self._published = now
        words = {
            "episode": self._episode,
            "terrain": self._scenario.terrain,
            "seed": self._scenario.seed,
            "fall": self._fall,
            "trouble": self._trouble or self._recording.trouble,
            "recording": str(self._recording.folder or ""),
            "recorded": str(self._recording.done or ""),
            "first": self.first,
        }
        if words != self._words:
            self._words = words
            self.note.write(words)


def serve(connection: Connection, wishes: str, request: Request) -> None:
    """Main function of the process.

    Args:
        connection: gets the names of the shared memory and of the numbers in a frame, or why it cannot be done.
        wishes: name of the ring with wishes.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the page's process hears it, and ends this one
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    try:
        walker = Walker(request, Ring(WIDTH, WISHES, wishes))
    except BadInput as error:
        connection.send({"error": [error.field, str(error.value), error.valid, error.remedy]})
        return
    except GaitsmithError as error:
        connection.send({"failed": str(error)})
        return
    connection.send(
        {
            "frames": walker.frames.name,
            "note": walker.note.name,
            "columns": list(walker.simulation.columns.names),
            "balls": len(walker.simulation.plant.balls),
            "phases": list(walker.simulation.plan.phases) if walker.simulation.plan else [],
        }
    )
    try:
        walker.run()
    finally:
        walker.frames.close()
        walker.note.close()
