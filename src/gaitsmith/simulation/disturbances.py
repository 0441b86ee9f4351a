"""Pushes: rectangular force pulses on one body, started at a time or at a phase of the stride."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Annotated, Any, Protocol

import numpy as np
import numpy.typing as npt
from pydantic import Field, model_validator

from gaitsmith.documents import Frozen
from gaitsmith.errors import BadInput

if TYPE_CHECKING:
    from gaitsmith.log.columns import Columns
    from gaitsmith.simulation.plant import Plant

Impulse = Annotated[float, Field(ge=-1000.0, le=1000.0)]


class Push(Frozen):
    """A rectangular push at a body's CoM, or at a joint's anchor.

    Attributes:
        time: start, s since the beginning of the run; with ``phase``, the earliest start.
        impulse: (3,) world axes, N·s, at most 1000 each.
        duration: s.
        phase: start when the stride reaches this phase: 0 at the start of a left stance, 0.5 at the start of a right
            stance, measured step time over the last step's duration in between. None: start at ``time``.
        body: name of the pushed body; None is the torso.
        joint: of whose body the anchor is pushed, instead of the body's CoM.
    """

    time: Annotated[float, Field(ge=0.0)]
    impulse: tuple[Impulse, Impulse, Impulse]
    duration: Annotated[float, Field(ge=1e-3, le=10.0)] = 0.1
    phase: Annotated[float, Field(ge=0.0, lt=1.0)] | None = None
    body: str | None = None
    joint: str | None = None

    @model_validator(mode="after")
    def _at_one_place(self) -> Push:
        """A push has one place."""
        if self.body is not None and self.joint is not None:
            raise BadInput("joint", self.joint, "nothing beside a body", "leave one of them out")
        return self


class Pushable(Protocol):
    """What pushes act on; :class:`gaitsmith.simulation.Plant` is one."""

    def push(self, force: npt.ArrayLike, body: str | None = None, joint: str | None = None) -> None:
        """Set the force at a body's CoM, or at a joint's anchor, until it is set again."""


class StrideClock:
    """Phase of the stride as measured: 0 to 0.5 in left stance, 0.5 to 1 in right stance.

    A step that begins on both feet belongs to the leg whose turn it is.
    """

    def __init__(self) -> None:
        self._step_count = -1
        self._stance = 2
        self._began = 0.0
        self._duration = math.nan

    def phase(self, time: float, walking: bool, stance: int, step_time: float, step_count: int, period: float) -> float:
        """Phase at ``time``, NaN while not walking.

        Args:
            time: s.
            stance: 0 left, 1 right, 2 both.
            step_time: since the step began, s.
            period: commanded step duration, s; stands in until one step has been measured.
        """
        if stance > 1 and self._stance < 2:
            stance = self._stance if step_count == self._step_count else 1 - self._stance
        if not walking or stance > 1:
            self._step_count, self._stance = -1, 2
            return math.nan
        if step_count != self._step_count:
            if step_count == self._step_count + 1 and self._step_count >= 0:
                self._duration = time - step_time - self._began
            else:
                self._duration = period
            self._step_count, self._stance = step_count, stance
            self._began = time - step_time
        return 0.5 * stance + 0.5 * min(step_time / self._duration, 1.0 - 1e-9)


def crossed(phase: float, before: float, now: float) -> bool:
    """Whether a stride that moved from phase ``before`` to ``now``, forwards, reached ``phase`` on the way."""
    travelled = (now - before) % 1.0
    return travelled < 0.75 and 0.0 < (phase - before) % 1.0 <= travelled


class Pushes:
    """Applies pushes to a plant, once a control tick.

    Args:
        control_step: s; a push lasts a whole number of these, and its force makes up for the rounding.

    Attributes:
        started: when each push began, s; NaN while it has not.
    """

    def __init__(self, pushes: tuple[Push, ...], plant: Pushable, control_step: float) -> None:
        self._pushes, self._plant = pushes, plant
        self._ticks = [max(1, round(push.duration / control_step)) for push in pushes]
        self._left = [-1] * len(pushes)  # ticks still to push; -1 before the start
        self._force = [
            np.asarray(push.impulse) / (n * control_step) for push, n in zip(pushes, self._ticks, strict=True)
        ]
        self._before = math.nan
        self.started = [math.nan] * len(pushes)

    @property
    def active(self) -> set[int]:
        """Pushes that act at this tick."""
        return {k for k, left in enumerate(self._left) if left > 0}

    @property
    def done(self) -> bool:
        """Whether every push is over, so that the loop need not ask any more."""
        return not any(self._left)

    def apply(self, time: float, phase: float) -> set[int]:
        """Set the forces for the control tick that begins at ``time``, s, with the stride at ``phase``.

        Returns:
            The pushes that begin or end with it.
        """
        before = self.active
        for k, push in enumerate(self._pushes):
            if k in before:
                self._left[k] -= 1
            elif self._left[k] < 0 and self._starts(push, time, phase):
                self._left[k], self.started[k] = self._ticks[k], time
        changed = before ^ self.active
        places = [(push.body, push.joint) for push in self._pushes]
        for place in {places[k] for k in changed}:
            acting = [self._force[k] for k in self.active if places[k] == place]
            self._plant.push(np.sum(acting, axis=0) if acting else np.zeros(3), *place)
        self._before = phase
        return changed

    def _starts(self, push: Push, time: float, phase: float) -> bool:
        """Whether a push that has not begun begins now."""
        if time < push.time - 1e-9:
            return False
        if push.phase is None:
            return True
        return crossed(push.phase, self._before, phase)


class Disturber:
    """Acts on a plant from outside while a loop goes: pushes it, and counts its excursion from where a walk begins.

    Args:
        pushes: in any order.
        columns: telemetry of the controller, whose stride has a phase.
        tell: hears of the beginning and the end of every push.
    """

    def __init__(
        self, pushes: tuple[Push, ...], plant: Plant, columns: Columns, tell: Callable[[Mapping[str, Any]], None]
    ) -> None:
        self.pushes, self._plant, self._tell = Pushes(pushes, plant, plant.control_step), plant, tell
        names = ("mode", "stance", "step_time", "step_count", "command.period")
        self._stride = [columns.block([name]) for name in names]
        self._clock = StrideClock() if any(push.phase is not None for push in pushes) else None

    def observe(self, tick: int) -> bool:
        """Push if it is time; never ends the run."""
        if not self.pushes.done:
            for push in self.pushes.apply(self._plant.time, self._phase()):
                self._tell({"push": push, "over": push not in self.pushes.active})
        return False

    def hear(self, event: Mapping[str, Any]) -> None:
        """A walk begins."""
        if event.get("action") in ("walk", "follow"):
            self._plant.restart_excursion()

    def _phase(self) -> float:
        """Phase of the stride, NaN if no push asks for it."""
        if self._clock is None:
            return math.nan
        mode, stance, step_time, step_count, period = (float(view[0]) for view in self._stride)
        return self._clock.phase(self._plant.time, mode == 1.0, int(stance), step_time, int(step_count), period)
