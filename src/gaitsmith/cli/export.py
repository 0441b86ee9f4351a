"""``gaitsmith export``: a gait file as CSV or MCAP."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Annotated

from gaitsmith.cli.arguments import Positional, choice, integer, number, parse, text
from gaitsmith.cli.dispatch import DONE, Outcome
from gaitsmith.cli.inputs import given_steps, planned_gait
from gaitsmith.cli.run_folder import check_file
from gaitsmith.errors import BadInput


@dataclass(frozen=True)
class ExportArguments:
    """Write a gait file's states, torques and contact wrenches at a fixed rate."""

    gait: Annotated[str, Positional, text("GAIT", "GAIT")]
    """Gait file."""
    format: Annotated[str, choice("--format", ("csv", "mcap"))] = "csv"
    """csv or mcap."""
    rate: Annotated[float, number("--rate", "HZ")] = 1000.0
    """Rows per second."""
    steps: Annotated[int | None, integer("--steps", "N", 1, 10_000, absent="1")] = None
    """Steps of a cyclic gait."""
    robot: Annotated[str | None, text("--robot", "NAME_OR_PATH", absent="the one it names")] = None
    """The robot it was planned for, if it is not one of the package."""
    out: Annotated[str | None, text("--out", "FILE", absent="beside the gait file")] = None
    """File to write."""
    json: bool = False
    """Print one JSON document instead of text."""


def export(words: list[str], program: str) -> Outcome:
    """Run the command.

    Raises:
        BadInput: the command line, the file or the robot cannot be used.
    """
    arguments = parse(ExportArguments, words, program)
    if not arguments.rate > 0.0:
        raise BadInput("--rate", arguments.rate, "a positive number of rows per second")
    path = check_file(arguments.out or _beside(arguments.gait, arguments.format), (arguments.gait,))
    from gaitsmith.cli.display import Display
    from gaitsmith.synthesis.gaits.export import export_gait

    gait, robot, _ = planned_gait(arguments.gait, arguments.robot)
    steps = given_steps(arguments.steps, gait, 1)
    with Display("exporting") as display:
        tell = lambda done, total: display.show("exporting", f"{done} of {total} rows", done, total)  # noqa: E731
        rows = export_gait(gait, robot, path, arguments.format, arguments.rate, steps, tell)
    document = {"file": str(path), "format": arguments.format, "rate": arguments.rate, "rows": rows}

    def show() -> None:
        from gaitsmith.cli.printing import Printer

        Printer().print(f"written: {document['file']}, {rows} rows", soft_wrap=True)

    return Outcome(DONE, document, show)


def _beside(gait: str, form: str) -> str:
    """The default name: walk.json gives walk.csv, and any other name keeps all of itself."""
    stem, suffix = os.path.splitext(gait)
    return f"{stem if suffix.lower() == '.json' else gait}.{form}"
