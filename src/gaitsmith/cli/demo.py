"""``gaitsmith demo``: both papers' robots walk, and a page shows it."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Annotated

from gaitsmith.cli.arguments import Arguments, parse
from gaitsmith.cli.dispatch import DONE, FELL, INTERRUPTED, Outcome, Table
from gaitsmith.documents import About
from gaitsmith.simulation.run_folder import NewFolder, check_new_folder

if TYPE_CHECKING:
    from gaitsmith.reports.demo import Demo
    from gaitsmith.reports.run import Run


class DemoArguments(Arguments):
    """Walk the speed profile of the first paper, plan and walk the walk and the kick of the second, write a page."""

    out: Annotated[
        str | None, About("New folder for runs, gaits and the page", metavar="DIR", absent="runs/demo-TIME")
    ] = None
    live: Annotated[bool, About("Open the live page instead; needs pip install 'gaitsmith[live]'")] = False


def demo(words: list[str], program: str) -> Outcome:
    """Run the command."""
    arguments = parse(DemoArguments, words, program)
    if arguments.live:
        from gaitsmith.cli.live import live

        return live([], "gaitsmith live")
    folder = check_new_folder(arguments.out or time.strftime("runs/demo-%Y%m%d-%H%M%S"))
    from gaitsmith.cli.display import Display

    with Display("loading (the first time compiles)") as display:
        from gaitsmith.reports.demo import run_demo

        NewFolder(folder).make()
        try:
            found = run_demo(folder, display.show)
        except KeyboardInterrupt:
            line = f"interrupted; what was finished is in {folder}"
            return Outcome(INTERRUPTED, {"interrupted": True, "out": str(folder)}, [line])
    runs = {"figure5": found.profile, **found.planned}
    fell = any(run.summary.fell for run in runs.values())
    document = {
        "page": str(found.page),
        "fell": fell,
        "runs": {name: run.summary.model_dump(mode="json") for name, run in runs.items()},
    }
    return Outcome(FELL if fell else DONE, document, _lines(found))


def _lines(found: Demo) -> list[str | Table]:
    from gaitsmith.reports.demo import next_lines
    from gaitsmith.simulation.stage_table import STAGE_HEADINGS, stage_row

    profile = found.profile.summary
    stages = Table(
        STAGE_HEADINGS, [stage_row(stage) for stage in profile.stages], (), f"{profile.robot}: speed profile"
    )
    headings = ("planned", "went\nm", "planned\nm", "torso off\n°", "ZMP off\nmm", "ball\nm/s", "fell")
    rows = [_row(name, run) for name, run in found.planned.items()]
    title = f"{next(iter(found.planned.values())).summary.robot}: planned, then walked in closed loop"
    after = ["next:", *(f"  {line}" for line in next_lines(found.profile.folder))]
    return [stages, Table(headings, rows, (0,), title), f"written: {found.page}", *after]


def _row(name: str, run: Run) -> tuple[str, ...]:
    track, fell = run.summary.tracking, "yes" if run.summary.fell else "no"
    if track is None:
        return (name, *[""] * 5, fell)
    ball = f"{track.ball.speed:.2f} of {track.ball.planned_speed:.2f}" if track.ball else ""
    tilt = f"{max(track.tilt_deg.values()):.2f}"
    return (name, f"{track.distance:.3f}", f"{track.planned_distance:.3f}", tilt, f"{track.zmp_rms_mm:.1f}", ball, fell)
