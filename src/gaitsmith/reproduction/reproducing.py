"""All experiments behind the figures, on as many processes as wanted, and the page that shows them."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from gaitsmith.errors import BadInput
from gaitsmith.files import write_text_atomic
from gaitsmith.reports.page import Page
from gaitsmith.reproduction import synthesis, template
from gaitsmith.reproduction.as_printed import as_printed
from gaitsmith.reproduction.engines import engines
from gaitsmith.reproduction.finding import Found, Row
from gaitsmith.simulation.episode import Simulation
from gaitsmith.simulation.scenario import Scenario
from gaitsmith.work.workers import workers

_Source = Generator[tuple[str, "Found | str"], None, None]
Advance = Callable[[int, int, str], None]
_TEMPLATE = "Han et al., A heuristic gait template planning and dynamic motion control for biped robots (2023)"
_SYNTHESIS = "Parametric gait synthesis in three dimensions for THBIP-II (doi:10.1007/978-3-319-58463-8_19)"
_GROUPS = {"template": _TEMPLATE, "synthesis": _SYNTHESIS}


class Experiment(NamedTuple):
    """What is run for some figures."""

    figures: tuple[str, ...]
    run: Callable[[Found, Callable[[str], None]], None]


EXPERIMENTS: dict[str, Experiment] = {
    "engines": Experiment(("template5",), engines),
    "whole": Experiment(("synthesis7", "synthesis8", "synthesis9", "synthesis10"), synthesis.whole),
    "cyclic": Experiment(("synthesis4", "synthesis5", "synthesis6"), synthesis.cyclic),
    "printed": Experiment(("template5",), as_printed),
    "profile": Experiment(("template5", "template6"), template.profile),
    "parameters": Experiment(("template10",), template.parameters),
    "heights": Experiment(("template7",), template.heights),
    "steady": Experiment(("template8", "template9"), template.steady),
    "periods": Experiment(("template11",), template.periods),
    "kick": Experiment(("synthesis11", "synthesis12"), synthesis.kick),
}
"""By name, those that take longest first."""
FIGURES = tuple(
    sorted(
        {figure for experiment in EXPERIMENTS.values() for figure in experiment.figures},
        key=lambda name: (name.startswith("synthesis"), int(name.lstrip("abcdefghijklmnopqrstuvwxyz"))),
    )
)
"""Every figure, in the order of the papers."""


@dataclass(frozen=True)
class Reproduction:
    """What was made.

    Attributes:
        rows: of every figure that was asked for.
        failed: why an experiment has none.
        interrupted: whether a signal left some out.
    """

    page: Path
    rows: list[Row]
    failed: dict[str, str]
    interrupted: bool


def chosen(words: Sequence[str]) -> tuple[str, ...]:
    """Figures by name (``template5``) or by paper (``synthesis``); all without any.

    Raises:
        BadInput: a figure that does not exist.
    """
    found: list[str] = []
    for word in words or tuple(_GROUPS):
        mine = [figure for figure in FIGURES if figure == word or (word in _GROUPS and figure.startswith(word))]
        if not mine:
            raise BadInput("FIGURE", word, f"one of {', '.join((*_GROUPS, *FIGURES))}")
        found += mine
    return tuple(figure for figure in FIGURES if figure in found)


def reproduce(figures: Sequence[str], folder: Path, jobs: int, advance: Advance) -> Reproduction:
    """Run what the figures need, draw them into the folder, and write the page; what fails costs only itself.

    Args:
        figures: from :func:`chosen`.
        folder: new or empty.
        advance: hears of experiments done, of all, and what is going on.

    Raises:
        BadInput: the page cannot be written.
    """
    wanted = [name for name, experiment in EXPERIMENTS.items() if set(experiment.figures) & set(figures)]
    done: dict[str, Found] = {}
    failed: dict[str, str] = {}
    interrupted = False
    source = (
        _here(wanted, folder, advance) if min(jobs, len(wanted)) <= 1 else _elsewhere(wanted, folder, jobs, advance)
    )
    try:
        for name, result in source:
            if isinstance(result, Found):
                done[name] = result
            else:
                failed[name] = result
            advance(len(done) + len(failed), len(wanted), f"{name} done")
    except KeyboardInterrupt:
        interrupted = True
    finally:
        source.close()
    rows = [row for figure in figures for found in done.values() for row in found.rows if row.figure == figure]
    page = folder / "report.html"
    write_text_atomic(page, _page(figures, done, rows, failed, interrupted))
    return Reproduction(page, rows, failed, interrupted)


def _perform(name: str, folder: Path, tell: Callable[[str], None]) -> Found | str:
    """One experiment; a reason instead if it fails."""
    found = Found(folder)
    try:
        EXPERIMENTS[name].run(found, tell)
    except Exception as error:  # a figure that fails never costs the others
        where = traceback.extract_tb(error.__traceback__)[-1]
        return f"{type(error).__name__}: {error} ({Path(where.filename).name}:{where.lineno})"
    return found


def _here(wanted: list[str], folder: Path, advance: Advance) -> _Source:
    for number, name in enumerate(wanted):
        tell = lambda text, number=number: advance(number, len(wanted), text)  # noqa: E731
        yield name, _perform(name, folder, tell)


def _silent(name: str, folder: Path) -> Found | str:
    return _perform(name, folder, lambda text: None)


def _elsewhere(wanted: list[str], folder: Path, jobs: int, advance: Advance) -> _Source:
    """On other processes."""
    advance(0, len(wanted), "loading (the first time compiles)")
    Simulation(Scenario(duration=1.0), record=False)  # compile once, not in every process at the same time
    with workers(min(jobs, len(wanted))) as crew:
        for name in wanted:
            crew.submit(name, _silent, name, folder)
        left = list(wanted)
        while left:
            advance(len(wanted) - len(left), len(wanted), ", ".join(left[:jobs]))
            name, result = crew.done()
            left.remove(name)
            yield name, result


def _page(
    figures: Sequence[str], done: dict[str, Found], rows: list[Row], failed: dict[str, str], interrupted: bool
) -> str:
    """Each figure beside what the paper says of it."""
    page = Page("Both papers, figure by figure", "each made anew here, from seed 0, beside what the paper states")
    counts = [sum(row.verdict.startswith(word) for row in rows) for word in ("agrees", "differs", "cannot")]
    page.text(f"{len(rows)} statements: {counts[0]} agree, {counts[1]} differ, {counts[2]} cannot be compared.")
    page.text("A verdict holds for the numbers in its row; what differs, or cannot be compared, says why.", "muted")
    if interrupted:
        page.text("Interrupted: some figures are missing.", "bad")
    for name, reason in failed.items():
        page.text(f"{name} ({', '.join(EXPERIMENTS[name].figures)}) failed: {reason}", "bad")
    for group, title in _GROUPS.items():
        mine = [figure for figure in figures if figure.startswith(group)]
        if mine:
            page.heading(title)
        for figure in mine:
            page.heading(f"Figure {figure.removeprefix(group)}", 3, figure)
            for picture in [p for found in done.values() for p in found.pictures if p.figure == figure]:
                if picture.content:
                    page.picture(picture.content, picture.kind, picture.caption)
                else:
                    page.text(picture.caption, "muted")
            own = [(row.says, row.ours, row.verdict) for row in rows if row.figure == figure]
            page.table(("the paper says", "here", "verdict"), own, left=(0, 1, 2))
            page.code(f"gaitsmith reproduce {figure}")
    page.versions()
    return page.render()
