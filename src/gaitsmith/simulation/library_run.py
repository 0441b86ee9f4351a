"""Walks by a library of gaits: orders become places in its grid, and every step is mixed before it begins."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

from gaitsmith.control import Controller
from gaitsmith.errors import BadInput
from gaitsmith.library.family import Family
from gaitsmith.library.folder import Folder
from gaitsmith.simulation.loop import Order
from gaitsmith.simulation.terrain import parse_terrain

if TYPE_CHECKING:
    from gaitsmith.robots import Robot
    from gaitsmith.simulation.scenario import Scenario

_FASTER = 0.02  # √(gz), most change of speed from one step to the next
_TURN = 0.02  # √(g/z), most change of the yaw rate
_OTHER = 0.1  # of a value, most change of it from one step to the next


def plans_for_slopes(scenario: Scenario) -> bool:
    """Whether a scenario's gaits were planned for the slope that it has."""
    return bool(scenario.gait or (scenario.library and Folder(scenario.library).spec()[0].slope))


def family_of(scenario: Scenario, robot: Robot) -> Family | None:
    """The library of a scenario; None without one.

    Raises:
        BadInput: it cannot be walked, or a command of the scenario leads outside of it.
    """
    if not scenario.library:
        return None
    ground = parse_terrain(scenario.terrain)
    family = Family(Folder(scenario.library), robot, ground.amount if ground.kind == "ramp" else 0.0)
    inputs: dict[str, float] = family.coordinates(family.base)
    for prefix, command in [("", scenario), *((f"changes[{k}].", c) for k, c in enumerate(scenario.changes))]:
        try:
            inputs = _changed(family, inputs, command.given())
        except BadInput as error:
            raise BadInput(prefix + error.field, error.value, error.valid, error.remedy) from None
    return family


def first_inputs(family: Family, scenario: Scenario) -> dict[str, Any]:
    """Gait inputs that a walk begins with: where its base is, and what the scenario says."""
    found: dict[str, Any] = dict(family.coordinates(family.base))
    return found | {"speed": (found["speed"], 0.0)} | scenario.given()


def _changed(family: Family, inputs: Mapping[str, float], given: Mapping[str, Any]) -> dict[str, float]:
    """The place after a command; a speed of zero leaves it where it is.

    Raises:
        BadInput: something that the library has no axis for, or a place outside of it.
    """
    found = dict(inputs)
    for name, value in given.items():
        if name == "speed" and value[1]:
            raise BadInput("speed", list(value), "a speed forward: no gait of the library walks sideways")
        if name not in found:
            raise BadInput(name, value, f"{' and '.join(found)}, the axes of the library", "leave it out")
        if name != "speed":
            found[name] = float(value)
        elif value[0]:
            found[name] = float(value[0])
    family.weights(found)
    return found


class Steered:
    """Commands of a library walk: takes orders as any walk does, and follows the plan that they make.

    Args:
        controller: that follows its plan.
        orders: speed, lift and period as commands; walk and stand as actions.
        given: gait inputs at first.
        units: √(gz) and √(g/z) of the robot, m/s and rad/s.

    Attributes:
        held: steps that stayed as they were because a gait on the way could not be planned.
    """

    def __init__(
        self,
        family: Family,
        controller: Controller,
        orders: Any,
        given: Mapping[str, Any],
        tell: Callable[[Mapping[str, Any]], None],
        units: tuple[float, float],
    ) -> None:
        self._family, self._controller, self._orders, self._tell = family, controller, orders, tell
        self._base = family.coordinates(family.base)
        self._most = {"speed": _FASTER * units[0], "yaw_rate": _TURN * units[1]}
        self._wanted = _changed(family, self._base, given)
        self._moves = bool(given.get("speed", (0.0, 0.0))[0])
        self._walks = self._begun = False
        self._now, self._weights = dict(self._base), dict(family.rest)
        self._stretch, self.held = -1, 0

    def poll(self, time: float) -> Iterable[Order]:
        """Take the orders of this tick, and see to the next step."""
        for order in self._orders.poll(time):
            self._take(order)
        controller = self._controller
        if not self._begun or controller.plan_ended:
            return self._rested()
        stretch = int(self._family.stretch[controller.plan_clock.visit[0]])
        if stretch != self._stretch:
            self._stretch = stretch
            self._see_to(stretch)
        return ()

    def _take(self, order: Order) -> None:
        """Change what is wanted."""
        if order.command:
            self._wanted = _changed(self._family, self._wanted, order.command)
            if "speed" in order.command:
                self._moves = bool(order.command["speed"][0])
        self._walks = {"walk": True, "stand": False}.get(order.action, self._walks)
        told: dict[str, Any] = {"command": dict(order.command)} if order.command else {}
        self._tell(told | ({"action": order.action} if order.action else {}))

    def _rested(self) -> tuple[Order, ...]:
        """At rest: stay, or begin to walk."""
        begins = self._walks and self._moves
        if self._begun and not begins:
            return ()
        self._begun, self._stretch = True, -1
        self._now, self._weights = dict(self._base), dict(self._family.rest)
        for half in (0, 1):
            self._family.write(half, self._weights, self._weights)
        return (Order(action="follow" if begins else "rest", told=False),)

    def _see_to(self, stretch: int) -> None:
        """A stretch has begun: write the step after it, if that is one of the loop's, or leave the loop."""
        swings = {self._family.loop[0]: 0, self._family.loop[2]: 1}
        wraps = stretch == self._family.loop[-1]
        following = self._family.loop[0] if wraps else stretch + 1
        if following not in swings:
            return
        rests = not (self._walks and self._moves)
        if wraps and rests and self._now == self._base:
            self._controller.leave_loop()
            return
        wanted = self._base if rests else self._wanted
        now = {name: _towards(self._now[name], wanted[name], self._most_of(name)) for name in self._now}
        try:
            weights = self._family.weights(now)
        except BadInput:
            now, weights = self._now, self._weights
            self.held += 1
        self._family.write(swings[following], self._weights, weights)
        self._now, self._weights = now, weights

    def _most_of(self, name: str) -> float:
        """Most change of an input from one step to the next."""
        return self._most[name] if name in self._most else _OTHER * self._now[name]


def _towards(value: float, goal: float, most: float) -> float:
    """A value nearer to its goal."""
    return goal if abs(goal - value) <= most else value + math.copysign(most, goal - value)
