"""What a scenario tells the controller, and when; and who says it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from gaitsmith.control import Controller
from gaitsmith.robots.parameters import GaitParameters
from gaitsmith.simulation.library_run import Steered, first_inputs
from gaitsmith.simulation.loop import Commands, Order, Script
from gaitsmith.simulation.remote import RemoteController, port_of
from gaitsmith.simulation.scenario import Scenario
from gaitsmith.simulation.step_policy import OnnxPolicy, PolicyCommands

if TYPE_CHECKING:
    from gaitsmith.library.family import Family
    from gaitsmith.planned import Plan
    from gaitsmith.robots import Robot


def first_gait(scenario: Scenario, robot: Robot) -> GaitParameters:
    """What the gait template begins with: the card's gait, and the scenario's inputs unless a library takes them."""
    given = {} if scenario.library else scenario.given()
    return GaitParameters.model_validate(robot.card.gait.model_dump() | given)


def commanded_first(
    scenario: Scenario, gait: GaitParameters, plan: Plan | None, family: Family | None
) -> dict[str, Any]:
    """Gait inputs at first, as reports have them: those of the library or the plan where there is one."""
    if family is not None:
        return gait.model_dump() | first_inputs(family, scenario)
    return gait.model_dump() | ({} if plan is None else {"speed": (plan.speed, 0.0)})


def scenario_orders(scenario: Scenario) -> list[tuple[float, Order]]:
    """What a scenario tells the controller, with the time of each order, s."""
    if scenario.gait:
        return [(0.0, Order(action="follow"))]
    orders = [(change.time, Order(change.given(), posture=change.posture)) for change in scenario.changes]
    orders.append((scenario.walk_from, Order(action="walk")))
    if scenario.rest_after > 0.0:
        orders.append((scenario.walk_until, Order(action="stand")))
    return orders


def controller_of(scenario: Scenario, robot: Robot, gait: GaitParameters) -> Controller:
    """Who controls the robot: the package's own controller, or another process.

    Args:
        scenario: names the preset, what is measured, and the process.
    """
    if scenario.controller:
        return RemoteController(robot, scenario.preset, scenario.state, gait, port_of(scenario.controller))
    return Controller(robot, preset=scenario.preset, state=scenario.state, gait=gait)


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
        step: of control, s.
        tell: says to observers what a library walk was told.
        given: instead of the scenario's own orders.
    """
    orders = given or Script(scenario_orders(scenario), step)
    if family is not None:
        return Steered(
            family,
            controller,
            orders,
            scenario.given(),
            tell,
            (controller.scale.speed, controller.scale.rate),
        )
    if scenario.policy:
        return PolicyCommands(orders, controller, OnnxPolicy(scenario.policy, controller.robot))
    return orders
