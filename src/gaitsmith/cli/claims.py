"""``gaitsmith plan --claims``: the paper's claims beside our figures."""

from __future__ import annotations

from gaitsmith.cli.dispatch import DONE, Outcome
from gaitsmith.errors import BadInput


def claims(robot_name: str) -> Outcome:
    """Plan the static and the dynamic gait and compare them with section 5.

    Raises:
        BadInput: the robot cannot be planned for, or not at these speeds.
    """
    from gaitsmith.robots import load_robot
    from gaitsmith.synthesis import Planner, Request, StepParameters, answer
    from gaitsmith.synthesis.claims import paper_claims

    robot = load_robot(robot_name)
    planner = Planner(robot)
    gaits = []
    for length, period in ((0.15, 1.0), (0.20, 0.5)):
        found = answer(planner, Request("cyclic", StepParameters(length, period)))
        if found.gait is None:
            raise BadInput("robot", robot_name, "a robot that walks the paper's two gaits", found.main.reason)
        gaits.append(found.gait)
    items = paper_claims(gaits[0], gaits[1], robot)
    document = {"motion": "claims", "status": "solved", "claims": [item.as_dict() for item in items]}

    def show() -> None:
        from rich.box import SIMPLE_HEAD
        from rich.table import Table

        from gaitsmith.cli.printing import Printer

        table = Table(box=SIMPLE_HEAD)
        for heading in ("the paper's claim", "here", "verdict"):
            table.add_column(heading)
        for item in items:
            table.add_row(item.claim, item.found, "holds" if item.holds else "does not hold")
        Printer().print(table)

    return Outcome(DONE, document, show)
