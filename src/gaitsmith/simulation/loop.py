"""The closed loop: a backend that is measured and driven, a controller, a source of commands, observers.

Nothing here knows what the backend is. Every tick: commands since the last one, measure, control, observe, step.
Ticks that the backend's clock has passed over are missed, and the controller is told how many.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from time import perf_counter_ns
from typing import TYPE_CHECKING, Any, Literal, Protocol

import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.simulation.wall_time import WallTimes

if TYPE_CHECKING:
    from gaitsmith.control import Controller, Measurement
    from gaitsmith.log import Log

_LONGEST = 0.1  # s from one tick to the next by the backend's clock; more is a jump


class BackendError(BadInput):
    """A backend that no loop can be closed around: what of it, the value, and what to do."""


class Backend(Protocol):
    """What is controlled: a simulated robot, or a real one.

    Attributes:
        control_step: wanted time from one tick to the next, s.
        time: its own clock, s; goes on by about one control step with every :meth:`step`.
    """

    control_step: float

    @property
    def time(self) -> float:
        """Its own clock, s."""

    def measure(self, into: Measurement) -> None:
        """Fill a measurement with what the sensors say now."""

    def step(self, torque: npt.NDArray[np.float64]) -> None:
        """Apply joint torques (nj,), N·m, until the next tick."""


@dataclass(frozen=True)
class Order:
    """Something to tell the controller between two ticks.

    Attributes:
        command: gait inputs by name, for :meth:`gaitsmith.control.Controller.command`.
        posture: angles of joints outside the legs by name, for :meth:`gaitsmith.control.Controller.posture`, rad.
        action: the name of another of its methods, called after that.
        told: whether observers hear of it; False for one of a stream of small corrections.
    """

    command: Mapping[str, Any] = field(default_factory=dict)
    action: Literal["", "walk", "stand", "follow", "rest"] = ""
    told: bool = True
    posture: Mapping[str, float] = field(default_factory=dict)


class Commands(Protocol):
    """Where orders come from: a script, a page, a log."""

    def poll(self, time: float) -> Iterable[Order]:
        """Orders that are due at the tick of this time, s since the run began, and were not given before."""


class Script:
    """Orders known beforehand.

    Args:
        orders: with the time of each, s; those of one time keep their sequence.
        control_step: s; an order is given at the tick that is nearest to its time.
    """

    def __init__(self, orders: Iterable[tuple[float, Order]], control_step: float) -> None:
        # Popped from the end, so what comes first stands last.
        self._left = sorted(orders, key=lambda entry: entry[0])[::-1]
        self._half = 0.5 * control_step

    def poll(self, time: float) -> Iterable[Order]:
        """Orders of this tick."""
        due = []
        while self._left and self._left[-1][0] <= time + self._half:
            due.append(self._left.pop()[1])
        return due


def replayed(log: Log, control_step: float) -> Script:
    """What was told to the controller in a run that was logged."""
    fields = ("command", "action", "posture")
    told = [(event["time"], {name: event[name] for name in fields if name in event}) for event in log.events]
    return Script([(time, Order(**given)) for time, given in told if given], control_step)


class Observer(Protocol):
    """What watches a loop: a monitor, a recorder, a page. Its memory is bounded."""

    def observe(self, tick: int) -> bool:
        """Take note of a tick, after control and before the step; True ends the run."""

    def hear(self, event: Mapping[str, Any]) -> None:
        """Take note of what happens once, if it matters: an order, a push; ``event`` has its ``time``, s of the run."""
        return


class Loop:
    """A closed loop that can be stepped.

    Args:
        controller: told what the backend measures.
        commands: asked before every tick.
        observers: told of every tick, in order.
        withholds: asked every tick whether the controller does not get to do it; the torque stays then.

    Attributes:
        tick: control ticks done.
        over: whether an observer has ended the run.
        wall_times: of the controller's ticks.
    """

    def __init__(
        self,
        backend: Backend,
        controller: Controller,
        commands: Commands,
        observers: Sequence[Observer],
        withholds: Callable[[], bool] | None = None,
    ) -> None:
        self.backend, self.controller, self.commands, self.observers = backend, controller, commands, observers
        self.tick, self.over = 0, False
        self.wall_times = WallTimes(backend.control_step)
        self._began = self._clock = backend.time
        self._withholds, self._missed = withholds, 0
        self._torque: npt.NDArray[np.float64] = np.zeros(0)

    @property
    def time(self) -> float:
        """Since the run began, by the backend's clock, s."""
        return self._clock - self._began

    def tell(self, event: Mapping[str, Any]) -> None:
        """Let all observers hear of something; its time is that of the present tick."""
        for observer in self.observers:
            observer.hear({"time": self.time, **event})

    def step(self) -> bool:
        """One control tick; False once the run is over.

        Raises:
            BackendError: the backend's clock jumps or stands still.
        """
        if self.over:
            return False
        controller, backend = self.controller, self.backend
        for order in self.commands.poll(self._clock - self._began):
            self._give(order)
        backend.measure(controller.measurement)
        if self._withholds is not None and len(self._torque) and self._withholds():
            self._missed += 1
        else:
            self._control()
        for observer in self.observers:
            if observer.observe(self.tick):
                self.over = True
        if self.over:
            return False
        backend.step(self._torque)
        self.tick += 1
        advance = backend.time - self._clock
        if not 0.0 < advance <= _LONGEST:
            raise self._clock_error(advance)
        if advance > 1.5 * backend.control_step:
            self._missed += round(advance / backend.control_step) - 1
        self._clock = backend.time
        return True

    def _control(self) -> None:
        """The controller's tick; it is told of those that it has missed."""
        if self._missed:
            self.controller.missed(self._missed)
            self._missed = 0
        before = perf_counter_ns()
        self._torque = self.controller.tick()
        self.wall_times.add(perf_counter_ns() - before)

    def _give(self, order: Order) -> None:
        """Tell the controller, then the observers."""
        event: dict[str, Any] = {}
        if order.command:
            self.controller.command(**order.command)
            event["command"] = dict(order.command)
        if order.posture:
            self.controller.posture(order.posture)
            event["posture"] = dict(order.posture)
        if order.action:
            getattr(self.controller, order.action)()
            event["action"] = order.action
        if order.told:
            self.tell(event)

    def _clock_error(self, advance: float) -> BackendError:
        """What to tell of a clock that does not go on evenly."""
        shown = f"{advance:.4g} s in one step, after {self.time:.3f} s"
        valid = f"more than 0 and at most {_LONGEST:g} s, about {self.backend.control_step:g} s"
        return BackendError("backend's clock", shown, valid, "the run ends here; check the backend and its connection")
