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
        from rich.box import SIMPLE_HEAD
        from rich.table import Table

        from gaitsmith.cli.printing import Printer

        printer = Printer()
        printer.print(f"{document['certified']} of {document['reachable']} gaits within reach certified")
        table = Table(box=SIMPLE_HEAD)
        for heading in ("speed\nm/s", "period\ns", "step\nm", "status", "objective", "iterations", "s", "ZMP\nmm"):
            table.add_column(heading, justify="left" if heading == "status" else "right")
        for cell in cells:
            numbers = (f"{cell.objective:.1f}", str(cell.iterations), f"{cell.time_s:.2f}", f"{cell.zmp_margin_mm:.1f}")
            table.add_row(f"{cell.speed:.3f}", f"{cell.period:.2f}", f"{cell.length:.3f}", cell.status, *numbers)
        printer.print(table)
        for cell in cells:
            if cell.status == "failed":
                printer.print(f"{cell.speed:.3f} m/s, {cell.period:.2f} s: {cell.reason}", soft_wrap=True)

    return Outcome(DONE if document["share"] >= 0.95 else NOT_SOLVED, document, show)
