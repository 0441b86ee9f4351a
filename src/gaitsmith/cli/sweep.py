"""``gaitsmith plan sweep``: the grid of speeds and periods."""

from __future__ import annotations

from gaitsmith.cli.dispatch import DONE, Outcome


def sweep(robot: str, jobs: int) -> Outcome:
    """Run the grid and report it.

    Raises:
        BadInput: the robot cannot be planned for.
    """
    from rich.console import Console
    from rich.progress import Progress

    from gaitsmith.synthesis.sweep import sweep as run
    from gaitsmith.synthesis.sweep import sweep_document

    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as progress:
        task = progress.add_task("sweep", total=None)
        cells = run(robot, jobs, lambda done, total: progress.update(task, completed=done, total=total))
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

    return Outcome(DONE if document["share"] >= 0.95 else 3, document, show)
