"""``gaitsmith log check``: what a run has recorded, and the repair of what a killed one left."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

from gaitsmith.cli.arguments import Arguments, Positional, parse
from gaitsmith.cli.dispatch import DONE, Outcome, printable
from gaitsmith.documents import About
from gaitsmith.files import lock, open_regular, replacing
from gaitsmith.simulation.run_folder import LOG, SUMMARY, write_summary


class CheckArguments(Arguments):
    """Read the log of a run to its end. After a run that was killed, finish the log and write the summary from it.

    Only what stands behind the last whole chunk, about a second of the run, is lost. A log with damage in its middle
    stays as it is.
    """

    run: Annotated[str, Positional("Folder of a run, or a log file", metavar="RUN")]
    no_repair: Annotated[bool, About("Look only; change nothing")] = False


def check(words: list[str], program: str) -> Outcome:
    """Run the command."""
    arguments = parse(CheckArguments, words, program)
    path = Path(arguments.run)
    path = path / LOG if path.is_dir() else path
    from gaitsmith.simulation.recovery import summary_of, survey

    with open_regular(path) as file:
        running = not lock(file)
        found = survey(file, str(path))
        repaired = []
        if not arguments.no_repair and not running and not found.damaged:
            if not found.complete:
                with replacing(path) as copy, open_regular(path) as cut:
                    survey(cut, str(path), copy)
                repaired.append(LOG)
            folder = path.parent
            if path.name == LOG and found.rows and not (folder / SUMMARY).exists():
                write_summary(folder, summary_of(path))
                repaired.append(SUMMARY)
    if not found.complete and not running:
        what = "is damaged, and stays as it is" if found.damaged else "was cut"
        sys.stderr.write(printable(f"gaitsmith: {path} {what}: whole up to {found.last_time:.3f} s\n"))
    document = {"run": arguments.run, **found._asdict(), "repaired": bool(repaired), "written": repaired}
    state = "still being written" if running else "damaged" if found.damaged else "cut short"
    state = "complete" if found.complete else state
    text = [f"{path}: {found.rows} rows up to {found.last_time:.3f} s, {state}"]
    text += ["written anew: " + ", ".join(repaired)] if repaired else []
    return Outcome(DONE, {**document, "running": running}, text)
