"""``gaitsmith log convert``: a run's log for other programs."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from gaitsmith.cli.arguments import Arguments, Positional, parse
from gaitsmith.cli.dispatch import DONE, Outcome, printable
from gaitsmith.cli.inputs import require_ending
from gaitsmith.documents import About
from gaitsmith.errors import BadInput
from gaitsmith.simulation.run_folder import LOG, check_file, run_files

if TYPE_CHECKING:
    from gaitsmith.robots import Robot

_ENDINGS = {"csv": ".csv", "parquet": ".parquet", "npz": ".npz", "ros2bag": ".bag"}


class ConvertArguments(Arguments):
    """Write a run's log for other programs. Tables (csv, parquet, npz) hold every row and column.

    ros2bag holds joint states, the torso's transform and every column. parquet and ros2bag need
    pip install 'gaitsmith[logs]'. Foxglove (robot, forces, footholds) and Rerun (points on its bodies, frames,
    values) open the log itself.
    """

    run: Annotated[str, Positional("Folder of a run, or a log file", metavar="RUN")]
    to: Annotated[Literal["csv", "parquet", "npz", "ros2bag"], About("Format", metavar="FORMAT")] = "csv"
    out: Annotated[
        str | None, About("File (for ros2bag: folder) to write", metavar="FILE", absent="beside the log")
    ] = None


def convert(words: list[str], program: str) -> Outcome:
    """Run the command."""
    arguments = parse(ConvertArguments, words, program)
    log = Path(arguments.run)
    log = log / LOG if log.is_dir() else log
    require_ending(arguments.out, "--to", arguments.to, _ENDINGS)
    path = check_file(arguments.out or str(log.with_suffix(_ENDINGS[arguments.to])), [str(log), *run_files(log.parent)])
    from gaitsmith.cli.display import Display
    from gaitsmith.reports.log_tables import LogSource, write_csv, write_npz, write_parquet

    with Display(f"converting to {arguments.to}") as display:
        source = LogSource(log, lambda time: display.show("converting", f"{time:.1f} s"))
        if arguments.to == "ros2bag":
            from gaitsmith.reports.ros_bag import write_bag

            write_bag(source, _robot_of(source.head.notes), path)
        else:
            {"csv": write_csv, "npz": write_npz, "parquet": write_parquet}[arguments.to](source, path)
    if not source.complete:
        sys.stderr.write(printable(f"gaitsmith: {log} was cut or damaged; what is whole of it is converted\n"))
    document = {
        "file": str(path),
        "format": arguments.to,
        "rows": source.rows,
        "columns": len(source.head.columns),
        "complete": source.complete,
    }
    return Outcome(DONE, document, [f"written: {path}, {source.rows} rows of {len(source.head.columns)} columns"])


def _robot_of(notes: dict[str, object]) -> Robot:
    """The robot that was run, as its files are now."""
    from gaitsmith.robots import load_robot

    scenario = notes.get("scenario")
    name = scenario.get("robot") if isinstance(scenario, dict) else None
    if not isinstance(name, str):
        raise BadInput("RUN", "a log that does not say of which robot", "the log of a walk")
    return load_robot(name)
