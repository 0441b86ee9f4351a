"""``gaitsmith plan sweep`` and ``gaitsmith plan --claims``: many gaits planned and compared."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from gaitsmith.cli.dispatch import DONE, NOT_SOLVED, Outcome, Table, Text
from gaitsmith.cli.inputs import named_robot

if TYPE_CHECKING:
    from gaitsmith.synthesis.requests.sweep import Cell


def sweep(robot: str, jobs: int) -> Outcome:
    """Run the grid and report it."""
    from gaitsmith.cli.display import Display
    from gaitsmith.synthesis.requests.sweep import sweep as run
    from gaitsmith.synthesis.requests.sweep import sweep_document

    named_robot(robot)
    with Display() as display:
        cells = run(robot, jobs, lambda done, total: display.show("sweep", f"{done} of {total}", done, total))
    document = sweep_document(cells)
    return Outcome(DONE if document["share"] >= 0.95 else NOT_SOLVED, document, _sweep_lines(cells, document))


def _sweep_lines(cells: list[Cell], document: dict[str, Any]) -> Iterator[Text]:
    yield f"{document['certified']} of {document['reachable']} gaits within reach certified"
    headings = ("speed\nm/s", "period\ns", "step\nm", "status", "objective", "iterations", "s", "ZMP\nmm")
    forms = {"speed": ".3f", "period": ".2f", "length": ".3f", "status": "", "objective": ".1f", "iterations": ""}
    forms |= {"time_s": ".2f", "zmp_margin_mm": ".1f"}
    yield Table(headings, [[format(getattr(cell, key), form) for key, form in forms.items()] for cell in cells], (3,))
    for cell in cells:
        if cell.status == "failed":
            yield f"{cell.speed:.3f} m/s, {cell.period:.2f} s: {cell.reason}"


def claims(robot_name: str) -> Outcome:
    """Plan the static and the dynamic gait and compare them with section 5."""
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
                return Outcome(NOT_SOLVED, _document(found.main.status, reason, []), [])
            gaits.append(found.gait)
        display.show("comparing")
        items = paper_claims(gaits[0], gaits[1], robot)

    rows = [(item.claim, item.found, "holds" if item.holds else "does not hold") for item in items]
    shown = Table(("the paper's claim", "here", "verdict"), rows, left=(0, 1, 2))
    return Outcome(DONE, _document("solved", "", [item.as_dict() for item in items]), [shown])


def _document(status: str, reason: str, claims: list[dict[str, Any]]) -> dict[str, Any]:
    return {"motion": "claims", "status": status, "reason": reason, "claims": claims}
