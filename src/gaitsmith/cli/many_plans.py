"""``gaitsmith plan sweep`` and ``gaitsmith plan --claims``: many gaits planned and compared."""

from __future__ import annotations

from typing import Any

from gaitsmith.cli.dispatch import DONE, NOT_SOLVED, Outcome
from gaitsmith.cli.inputs import named_robot


def sweep(robot: str, jobs: int) -> Outcome:
    """Run the grid and report it."""
    from gaitsmith.cli.display import Display
    from gaitsmith.synthesis.requests.sweep import sweep as run
    from gaitsmith.synthesis.requests.sweep import sweep_document

    named_robot(robot)
    with Display() as display:
        cells = run(robot, jobs, lambda done, total: display.show("sweep", f"{done} of {total}", done, total))
    document = sweep_document(cells)

    def show() -> None:
        from gaitsmith.cli.printing import Printer, table

        printer = Printer()
        printer.print(f"{document['certified']} of {document['reachable']} gaits within reach certified")
        headings = ("speed\nm/s", "period\ns", "step\nm", "status", "objective", "iterations", "s", "ZMP\nmm")
        rows = [
            (
                *(f"{cell.speed:.3f}", f"{cell.period:.2f}", f"{cell.length:.3f}", cell.status),
                *(f"{cell.objective:.1f}", str(cell.iterations), f"{cell.time_s:.2f}", f"{cell.zmp_margin_mm:.1f}"),
            )
            for cell in cells
        ]
        printer.print(table(headings, rows, left=(3,)))
        for cell in cells:
            if cell.status == "failed":
                printer.print(f"{cell.speed:.3f} m/s, {cell.period:.2f} s: {cell.reason}", soft_wrap=True)

    return Outcome(DONE if document["share"] >= 0.95 else NOT_SOLVED, document, show)


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
