"""``gaitsmith plan sweep``: the grid of speeds and periods."""

from __future__ import annotations

from gaitsmith.cli.dispatch import DONE, NOT_SOLVED, Outcome
from gaitsmith.cli.inputs import named_robot


def sweep(robot: str, jobs: int) -> Outcome:
    """Run the grid and report it.

    Raises:
        BadInput: the robot cannot be planned for.
    """
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
