"""Live progress on stderr while that is a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn
from rich.table import Column

from gaitsmith.cli.interrupts import stop_if_heard
from gaitsmith.cli.printing import Printer

if TYPE_CHECKING:
    from gaitsmith.synthesis.solution.ipopt import Progress as Iteration


class _Bar(BarColumn):
    """A bar where the end is known."""

    def render(self, task: Any) -> Any:
        return super().render(task) if task.total is not None else ""


class Display:
    """What is being done, how far it is, and for how long already; notices are printed whatever stderr is."""

    def __init__(self, what: str = "loading") -> None:
        self._printer = Printer(stderr=True)
        # The last words wrap: on a narrow terminal nothing is cut off.
        words = TextColumn("{task.fields[done]}", markup=False, table_column=Column(no_wrap=False, overflow="fold"))
        name = TextColumn("{task.description}", markup=False)
        columns = (name, _Bar(bar_width=20), words, TimeElapsedColumn())
        quiet = not self._printer.is_terminal
        self._progress = Progress(*columns, console=self._printer, transient=True, disable=quiet)
        self._task: TaskID = self._progress.add_task(what, total=None, done="")

    def __enter__(self) -> Display:
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()

    def say(self, text: str) -> None:
        """A notice: a line of its own."""
        self._printer.print(f"gaitsmith: {text}", soft_wrap=True)

    def slow(self, text: str) -> None:
        """A notice about something slow: it also stays beside the running time until something else begins."""
        self.say(text)
        self.show(text.partition(",")[0])

    def show(self, what: str, done: str = "", completed: float | None = None, total: float | None = None) -> None:
        """What is being done now; where long work is left if a signal has asked for its end."""
        stop_if_heard()
        self._progress.update(self._task, description=what, done=done, completed=completed, total=total)

    def advance(self, done: int, total: int, what: str) -> None:
        """Progress of an experiment; without a total it is not known how far."""
        self.show(what, f"{done} of {total}" if total else "", done, total or None)

    def iteration(self, motion: str, rounds: int, progress: Iteration) -> None:
        """One iteration of a solve."""
        worst = f"{progress.violation:.2g}"
        if progress.constraint:
            worst = f"{progress.constraint} by {progress.violation * progress.span:.2g} {progress.unit}".rstrip()
        name = f"planning {motion}" + (f", refinement {rounds}" if rounds else "")
        self.show(name, f"iteration {progress.iteration}, worst {worst}, objective {progress.objective:.4g}")
