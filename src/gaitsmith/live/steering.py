"""Commands of a walk that somebody steers, and the pushes that the torso gets meanwhile."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gaitsmith.live.wishes import HOLD_TIME, PUSH_TIME
from gaitsmith.simulation.loop import Observer, Order

if TYPE_CHECKING:
    from gaitsmith.simulation.episode import Simulation

Array = npt.NDArray[np.float64]
_SETTLED = 0.3  # s without another correction after which observers hear of a command


class Steering:
    """A source of commands.

    A slider that is dragged sends many: the controller gets all of them, observers hear of the last.

    Args:
        first: orders for the beginning, each with its time, s.
    """

    def __init__(self, first: Sequence[tuple[float, Order]] = ()) -> None:
        self._first, self._waiting = list(first), list[Order]()
        self._untold: Mapping[str, Any] | None = None
        self._changed = math.inf

    def command(self, inputs: Mapping[str, Any]) -> None:
        """Change gait inputs at the next tick."""
        self._untold, self._changed = dict(inputs), math.nan
        self._waiting = [order for order in self._waiting if not order.command]
        self._waiting.append(Order(dict(inputs), told=False))

    def act(self, order: Order) -> None:
        """Give an order at the next tick; what was planned for later goes."""
        self._first.clear()
        self._waiting.append(order)

    def poll(self, time: float) -> Iterable[Order]:
        """Orders of this tick."""
        if not self._first and not self._waiting and self._untold is None:
            return ()
        due, self._waiting = self._waiting, []
        while self._first and self._first[0][0] <= time + 1e-9:
            due.append(self._first.pop(0)[1])
        if math.isnan(self._changed):
            self._changed = time
        if self._untold is not None and time >= self._changed + _SETTLED:
            due.append(Order(self._untold))
            self._untold = None
        return due


class Shoves(Observer):
    """Observer that pushes the torso as somebody wishes, and tells the other observers.

    Attributes:
        force: (3,) that acts now, world, N.
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation, self._step = simulation, simulation.plant.control_step
        self._pulses: list[tuple[int, int, Array]] = []  # number, ticks left, force
        self._held, self._held_ticks, self._held_number = np.zeros(3), 0, -1
        self._count = 0
        self.force = np.zeros(3)

    def push(self, impulse: Sequence[float]) -> None:
        """Push for 0.1 s: impulse forward, to the left and up, heading axes, N·s."""
        yaw = float(self._simulation.columns.block(["true.torso_yaw"])[0])
        forward, left, up = impulse
        cos, sin = math.cos(yaw), math.sin(yaw)
        world = np.array([cos * forward - sin * left, sin * forward + cos * left, up])
        number = self._begin({"impulse": world.tolist(), "duration": PUSH_TIME})
        self._pulses.append((number, round(PUSH_TIME / self._step), world / PUSH_TIME))

    def hold(self, force: Sequence[float]) -> None:
        """Push with a force, world axes, N, until the next one, or for 0.3 s."""
        self._held[:] = force
        if not self._held_ticks and np.any(self._held):
            self._held_number = self._begin({"force": list(force)})
        self._held_ticks = round(HOLD_TIME / self._step) if np.any(self._held) else min(self._held_ticks, 1)

    def _begin(self, event: dict[str, Any]) -> int:
        """Tell of a push, and number it."""
        number, self._count = self._count, self._count + 1
        self._simulation.loop.tell({"push": number, "over": False, **event})
        return number

    def observe(self, tick: int) -> bool:
        """Set the force of this tick; never ends the run."""
        if not self._pulses and not self._held_ticks and not self.force.any():
            return False
        self.force = np.zeros(3)
        for number, left, force in self._pulses:
            self.force = self.force + (force if left else 0.0)
            if not left:
                self._simulation.loop.tell({"push": number, "over": True})
        self._pulses = [(number, left - 1, force) for number, left, force in self._pulses if left]
        if self._held_ticks:
            self.force = self.force + self._held
            self._held_ticks -= 1
            if not self._held_ticks:
                self._simulation.loop.tell({"push": self._held_number, "over": True})
        self._simulation.plant.push(self.force)
        return False
