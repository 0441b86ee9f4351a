"""``gaitsmith why``: a run that ended in a fall, run again without what may have caused it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from gaitsmith.cli.arguments import Arguments, Positional, parse
from gaitsmith.cli.dispatch import DONE, Outcome, Table
from gaitsmith.documents import About
from gaitsmith.errors import BadInput
from gaitsmith.files import read_bounded
from gaitsmith.simulation.run_folder import SCENARIO, SUMMARY, folder_of, write_summary
from gaitsmith.simulation.scenario import load_scenario

if TYPE_CHECKING:
    from gaitsmith.simulation.summary import Summary

_LARGEST = 10_000_000  # bytes of a summary


class WhyArguments(Arguments):
    """Find out why a robot fell.

    The run is repeated without each of its suspects in turn, the likeliest first: no push, more friction, no delay,
    nothing that fails, a larger limit. The first without which the robot stands is the cause, and confirmed. The run's
    summary is told.
    """

    run: Annotated[str, Positional("Folder of a run, or a scenario file", metavar="RUN")]
    no_summary: Annotated[bool, About("Leave the run's summary as it is")] = False


def why(words: list[str], program: str) -> Outcome:
    """Run the command."""
    arguments = parse(WhyArguments, words, program)
    path = folder_of(arguments.run)
    folder = path if path.is_dir() else None
    if folder is not None and not (folder / SCENARIO).is_file():
        raise BadInput("RUN", arguments.run, f"a folder with a {SCENARIO}, as gaitsmith walk --out writes it")
    scenario = load_scenario(path / SCENARIO if folder else arguments.run)
    summary = None
    if folder is not None and not arguments.no_summary and (folder / SUMMARY).exists():
        summary = _summary(folder / SUMMARY)
    from gaitsmith.cli.display import Display
    from gaitsmith.simulation.replay import why as replayed

    with Display("loading (the first time compiles)") as display:
        verdict = replayed(scenario, lambda what: display.show("replaying", what, 0.0, 1.0))
    if verdict is None:
        raise BadInput("RUN", arguments.run, "a run that ends in a fall", "run again, its robot stands")
    document: dict[str, Any] = {"run": arguments.run, **verdict.model_dump(mode="json")}
    if folder is not None and summary is not None and summary.fall is not None:
        told = summary.model_copy(update={"fall": summary.fall.model_copy(update={"cause": verdict.cause})})
        write_summary(folder, told)
    rows = [
        (trial.what, trial.relaxed, "stands" if trial.stands else f"falls at {trial.fell_at:.2f} s")
        for trial in verdict.trials
    ]
    fall, cause = verdict.fall, verdict.cause
    known = "confirmed" if cause.confirmed else "not confirmed: it falls without it too, or nothing relaxes it"
    text: list[Any] = [f"fell at {fall.time:.2f} s, {fall.phase}: {fall.reason}"]
    text += [Table(("suspect", "run again with", "then"), rows, left=(0, 1, 2))] if rows else []
    text += [f"cause: {cause.what}, {known}"]
    if verdict.edge:
        text.append("on the edge: as it was, it stands too when one joint begins 1e-9 rad elsewhere")
    return Outcome(DONE, document, text)


def _summary(path: Path) -> Summary:
    """The run's summary, into which the cause goes."""
    from pydantic import ValidationError

    from gaitsmith.simulation.summary import Summary

    try:
        return Summary.model_validate_json(read_bounded(path, _LARGEST))
    except ValidationError:
        raise BadInput(str(path), "something else", "the summary of a run", "use --no-summary") from None
