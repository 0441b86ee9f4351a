"""``gaitsmith reproduce``: the figures of both papers made again, and what the papers say set beside them."""

from __future__ import annotations

import time
from typing import Annotated

from pydantic import Field

from gaitsmith.cli.arguments import Arguments, Positional, parse
from gaitsmith.cli.dispatch import DONE, INTERRUPTED, NOT_SOLVED, Outcome, Table, Text
from gaitsmith.documents import About
from gaitsmith.simulation.run_folder import NewFolder, check_new_folder


class ReproduceArguments(Arguments):
    """Run the experiment behind each figure of both papers, draw it as the paper does, and compare.

    The page says of every sentence that states a result what came of it here, and whether that agrees.
    """

    figures: Annotated[
        tuple[str, ...],
        Field(max_length=40),
        Positional("template, synthesis, or figures such as template5 or synthesis6", metavar="FIGURE", absent="all"),
    ] = ()
    out: Annotated[
        str | None, About("New folder for page, figures and runs", metavar="DIR", absent="runs/reproduce-TIME")
    ] = None
    jobs: Annotated[int, Field(ge=1, le=64), About("Processes", metavar="N")] = 1


def reproduce(words: list[str], program: str) -> Outcome:
    """Run the command."""
    arguments = parse(ReproduceArguments, words, program)
    folder = check_new_folder(arguments.out or time.strftime("runs/reproduce-%Y%m%d-%H%M%S"))
    from gaitsmith.cli.display import Display

    with Display("loading (the first time compiles)") as display:
        from gaitsmith.reproduction.reproducing import chosen
        from gaitsmith.reproduction.reproducing import reproduce as run

        figures = chosen(arguments.figures)
        NewFolder(folder).make()
        found = run(figures, folder, arguments.jobs, display.advance)
    document = {
        "page": str(found.page),
        "figures": list(figures),
        "rows": [row._asdict() for row in found.rows],
        "failed": found.failed,
        "interrupted": found.interrupted,
    }
    text: list[Text] = [Table(("figure", "the paper says", "here", "verdict"), found.rows, (0, 1, 2, 3))]
    text += [f"failed: {name}: {reason}" for name, reason in found.failed.items()]
    text.append(f"written: {found.page}")
    return Outcome(INTERRUPTED if found.interrupted else NOT_SOLVED if found.failed else DONE, document, text)
