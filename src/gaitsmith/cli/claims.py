"""``gaitsmith plan --claims``: the paper's claims beside our figures."""

from __future__ import annotations

from typing import Any

from gaitsmith.cli.dispatch import DONE, NOT_SOLVED, Outcome
from gaitsmith.cli.inputs import named_robot


def claims(robot_name: str) -> Outcome:
    """Plan the static and the dynamic gait and compare them with section 5.

    Raises:
        BadInput: the robot cannot be planned for.
    """
    from gaitsmith.cli.display import Display
    from gaitsmith.synthesis import Planner, Request, StepParameters, answer
    from gaitsmith.synthesis.proof.claims import paper_claims

    robot = named_robot(robot_name)
    gaits = []
    with Display() as display:
        planner = Planner(robot, display.slow)
        for length, period in ((0.15, 1.0), (0.20, 0.5)):
            found = answer(planner, Request("cyclic", StepParameters(length, period)), display.iteration)
            if found.gait is None:
                reason = f"a step of {length:g} m in {period:g} s: {found.main.reason}"
                display.say(f"{found.main.status}: {reason}")
                return Outcome(NOT_SOLVED, _document(found.main.status, reason, []), lambda: None)
            gaits.append(found.gait)
        display.show("comparing")
        items = paper_claims(gaits[0], gaits[1], robot)

    def show() -> None:
        from gaitsmith.cli.printing import Printer, table

        rows = [(item.claim, item.found, "holds" if item.holds else "does not hold") for item in items]
        Printer().print(table(("the paper's claim", "here", "verdict"), rows, left=(0, 1, 2)))

    return Outcome(DONE, _document("solved", "", [item.as_dict() for item in items]), show)


def _document(status: str, reason: str, claims: list[dict[str, Any]]) -> dict[str, Any]:
    return {"motion": "claims", "status": status, "reason": reason, "claims": claims}
