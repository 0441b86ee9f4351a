"""``gaitsmith export``: a gait file as CSV or MCAP."""

from __future__ import annotations

import os
from typing import Annotated, Literal

from pydantic import Field

from gaitsmith.cli.arguments import Arguments, GaitFile, OwnRobot, parse
from gaitsmith.cli.dispatch import DONE, Outcome
from gaitsmith.cli.inputs import planned_gait, require_ending
from gaitsmith.documents import About
from gaitsmith.errors import BadInput
from gaitsmith.simulation.run_folder import check_file

_ENDINGS = {"csv": ".csv", "mcap": ".mcap"}


class ExportArguments(Arguments):
    """Write a gait file's states, torques and contact wrenches at a fixed rate."""

    gait: GaitFile
    format: Annotated[Literal["csv", "mcap"], About("A table for scripts, or a log for viewers")] = "csv"
    rate: Annotated[float, Field(gt=0.0), About("Rows per second", metavar="HZ")] = 1000.0
    steps: Annotated[int | None, Field(ge=1, le=10_000), About("Steps of a cyclic gait", metavar="N", absent="1")] = (
        None
    )
    robot: OwnRobot = None
    out: Annotated[str | None, About("File to write", metavar="FILE", absent="beside the gait file")] = None


def export(words: list[str], program: str) -> Outcome:
    """Run the command."""
    arguments = parse(ExportArguments, words, program)
    require_ending(arguments.out, "--format", arguments.format, _ENDINGS)
    path = check_file(arguments.out or _beside(arguments.gait, arguments.format), (arguments.gait,))
    from gaitsmith.cli.display import Display
    from gaitsmith.synthesis.files.export import export_gait

    gait, robot, _ = planned_gait(arguments.gait, arguments.robot)
    if arguments.steps is not None and not gait.motion.cyclic:
        raise BadInput("--steps", arguments.steps, f"nothing for {gait.motion.name}", "it applies to cyclic gaits")
    with Display("exporting") as display:
        tell = lambda done, total: display.show("exporting", f"{done} of {total} rows", done, total)  # noqa: E731
        rows = export_gait(gait, robot, path, arguments.format, arguments.rate, arguments.steps or 1, tell)
    document = {"file": str(path), "format": arguments.format, "rate": arguments.rate, "rows": rows}
    return Outcome(DONE, document, [f"written: {path}, {rows} rows"])


def _beside(gait: str, form: str) -> str:
    """The default name: walk.json gives walk.csv, and any other name keeps all of itself."""
    stem, suffix = os.path.splitext(gait)
    return f"{stem if suffix.lower() == '.json' else gait}.{form}"
