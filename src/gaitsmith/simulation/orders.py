"""What a scenario tells the controller, and when."""

from __future__ import annotations

from gaitsmith.simulation.loop import Order
from gaitsmith.simulation.scenario import Scenario


def scenario_orders(scenario: Scenario) -> list[tuple[float, Order]]:
    """What a scenario tells the controller, with the time of each order, s."""
    if scenario.gait:
        return [(0.0, Order(action="follow"))]
    orders = [(change.time, Order(change.given(), posture=change.posture)) for change in scenario.changes]
    orders.append((scenario.walk_from, Order(action="walk")))
    if scenario.rest_after > 0.0:
        orders.append((scenario.walk_until, Order(action="stand")))
    return orders
