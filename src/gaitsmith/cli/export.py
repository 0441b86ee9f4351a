"""``gaitsmith export``: a gait file as CSV or MCAP."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from gaitsmith.cli.arguments import Positional, choice, integer, number, parse, text
from gaitsmith.cli.dispatch import DONE, Outcome
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
    steps: Annotated[int, integer("--steps", "N", 1)] = 1
    """Steps of a cyclic gait."""
    robot: Annotated[str | None, text("--robot", "NAME_OR_PATH")] = None
    """The robot it was planned for, if it is not one of the package."""
    out: Annotated[str | None, text("--out", "FILE")] = None
    """File to write; beside the gait file by default."""
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
    if arguments.steps > 10_000:
        raise BadInput("--steps", arguments.steps, "at most 10000")
    from gaitsmith.synthesis import load_robot_of, read_gait
    from gaitsmith.synthesis.export import export_gait

    gait, _ = read_gait(arguments.gait)
    robot = load_robot_of(gait, arguments.robot)
    path = Path(arguments.out) if arguments.out else Path(arguments.gait).with_suffix(f".{arguments.format}")
    rows = export_gait(gait, robot, path, arguments.format, arguments.rate, arguments.steps)
    document = {"file": str(path.resolve()), "format": arguments.format, "rate": arguments.rate, "rows": rows}

    def show() -> None:
        from gaitsmith.cli.printing import Printer

        Printer().print(f"written: {document['file']}, {rows} rows", soft_wrap=True)

    return Outcome(DONE, document, show)
