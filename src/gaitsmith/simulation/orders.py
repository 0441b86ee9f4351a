"""What a scenario tells the controller, and when; and who says it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from gaitsmith.control import Controller
from gaitsmith.simulation.library_run import Steered
from gaitsmith.simulation.loop import Commands, Order, Script
from gaitsmith.simulation.scenario import Scenario
from gaitsmith.simulation.step_policy import OnnxPolicy, PolicyCommands

if TYPE_CHECKING:
    from gaitsmith.library.family import Family


def scenario_orders(scenario: Scenario) -> list[tuple[float, Order]]:
    """What a scenario tells the controller, with the time of each order, s."""
    if scenario.gait:
        return [(0.0, Order(action="follow"))]
    orders = [(change.time, Order(change.given(), posture=change.posture)) for change in scenario.changes]
    orders.append((scenario.walk_from, Order(action="walk")))
    if scenario.rest_after > 0.0:
        orders.append((scenario.walk_until, Order(action="stand")))
    return orders


def commands_of(
    scenario: Scenario,
    controller: Controller,
    family: Family | None,
    step: float,
    tell: Callable[[Mapping[str, Any]], None],
    given: Commands | None = None,
) -> Commands:
    """Who tells the controller what: the scenario's own orders or others, through its library or policy.

    Args:
        scenario: what is run.
        controller: that is told.
        family: of the scenario's library.
        step: of control, s.
        tell: says to observers what a library walk was told.
        given: instead of the scenario's own orders.
    """
    orders = given or Script(scenario_orders(scenario), step)
    if family is not None:
        return Steered(family, controller, orders, scenario.given(), tell, controller.scale.speed)
    if scenario.policy:
        return PolicyCommands(orders, controller, OnnxPolicy(scenario.policy, controller.robot))
    return orders
