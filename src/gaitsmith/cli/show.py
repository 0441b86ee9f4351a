"""``gaitsmith report``, ``plot`` and ``video``: what a finished run looks like."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field

from gaitsmith.cli.arguments import Arguments, Positional, parse
from gaitsmith.cli.dispatch import DONE, Outcome
from gaitsmith.documents import About
from gaitsmith.errors import BadInput
from gaitsmith.simulation.run_folder import check_file, run_files

RunFolder = Annotated[str, Positional("Folder of a run, as gaitsmith walk --out writes it", metavar="RUN")]
_WHAT = ("speed", "height", "joints", "feet", "torques", "footprints", "landings", "fall")


class ReportArguments(Arguments):
    """Write one HTML file about a run that opens without a network: what was asked, numbers, figures, faults."""

    run: RunFolder
    out: Annotated[
        str | None, About("HTML file to write", metavar="FILE", absent="report.html in the run's folder")
    ] = None
    no_figures: Annotated[bool, About("Numbers only")] = False


class PlotArguments(Arguments):
    """Draw figures of a run, each as PNG and as SVG."""

    run: RunFolder
    what: Annotated[
        tuple[str, ...],
        Field(max_length=len(_WHAT)),
        About(f"Figure: {', '.join(_WHAT)}", metavar="NAME", absent="all that the run has something for"),
    ] = ()
    out: Annotated[str | None, About("Folder to write them to", metavar="DIR", absent="the run's folder")] = None


class VideoArguments(Arguments):
    """Write a run as a film (MP4, VP9), drawn by software if need be; needs pip install 'gaitsmith[video]'."""

    run: RunFolder
    out: Annotated[str | None, About("MP4 file to write", metavar="FILE", absent="run.mp4 in the run's folder")] = None
    rate: Annotated[
        float, Field(ge=0.05, le=4.0), About("How fast time goes: 1 is real time, 0.25 slow motion", metavar="X")
    ] = 1.0


def report(words: list[str], program: str) -> Outcome:
    """Write the page of a run."""
    arguments = parse(ReportArguments, words, program)
    from gaitsmith.cli.display import Display
    from gaitsmith.files import write_text_atomic
    from gaitsmith.reports.run import open_run
    from gaitsmith.reports.run_page import run_page

    run = open_run(arguments.run)
    path = check_file(arguments.out or str(run.folder / "report.html"), run_files(run.folder))
    with Display("writing the report"):
        write_text_atomic(path, run_page(run, not arguments.no_figures))
    return Outcome(DONE, {"file": str(path), "fell": run.summary.fell, "notes": list(run.notes)}, [f"written: {path}"])


def plot(words: list[str], program: str) -> Outcome:
    """Draw figures of a run."""
    arguments = parse(PlotArguments, words, program)
    from gaitsmith.cli.display import Display
    from gaitsmith.files import reason
    from gaitsmith.reports.run import open_run
    from gaitsmith.view import save, suitable

    run = open_run(arguments.run)
    recording = run.recording
    known = suitable(recording)
    for name in arguments.what:
        if name not in known:
            told = f"one of {', '.join(known)}"
            raise BadInput("--what", name, told, "this run has nothing for it" if name in _WHAT else "")
    folder, paths = Path(arguments.out or run.folder), []
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInput("--out", str(folder), "a folder that can be written", reason(error)) from None
    wanted = arguments.what or tuple(known)
    with Display("drawing") as display:
        for number, name in enumerate(wanted):
            display.show("drawing", name, number, len(wanted))
            paths.append(str(save(known[name](recording), folder / f"{name}.png")))
    lines = [f"note: {note}" for note in run.notes]
    return Outcome(
        DONE, {"figures": paths, "notes": list(run.notes)}, [*lines, *(f"written: {p}, .svg" for p in paths)]
    )


def video(words: list[str], program: str) -> Outcome:
    """Write a run as a film."""
    arguments = parse(VideoArguments, words, program)
    from gaitsmith.cli.display import Display
    from gaitsmith.reports.run import open_run
    from gaitsmith.reports.video import need_video, write_video

    need_video()
    run = open_run(arguments.run)
    path = check_file(arguments.out or str(run.folder / "run.mp4"), run_files(run.folder))
    if path.suffix.lower() != ".mp4":
        raise BadInput("--out", str(path), "a name that ends in .mp4")
    with Display("drawing") as display:
        tell = lambda done, total: display.show("drawing", f"picture {done} of {total}", done, total)  # noqa: E731
        count = write_video(run, path, arguments.rate, tell)
    return Outcome(DONE, {"file": str(path), "pictures": count}, [f"written: {path}, {count} pictures"])
