"""The page of a run: what was asked, what came of it in numbers and figures, what went wrong, how to do it again."""

from __future__ import annotations

import shlex

from gaitsmith.reports.page import Page
from gaitsmith.reports.run import Run
from gaitsmith.simulation.run_folder import SCENARIO, scenario_toml
from gaitsmith.simulation.stage_table import STAGE_HEADINGS, run_lines, stage_row
from gaitsmith.simulation.summary import Summary
from gaitsmith.view import suitable

_COUNTERS = {
    "qp_fallbacks": "ticks in which the whole-body QP fell back",
    "qp_infeasible": "ticks in which it was infeasible",
    "ik_fallbacks": "ticks in which the inverse kinematics fell back",
    "stops_dropped": "ticks that could not keep every joint off its stops",
    "touchdowns_forced": "steps ended by the clock instead of by contact",
    "refused_ticks": "ticks with readings that were replaced",
}


def run_page(run: Run, figures: bool = True) -> str:
    """The page of a run as HTML that opens without a network.

    Args:
        figures: whether to draw them, which takes most of the time.
    """
    summary = run.summary
    what = f"{summary.duration:.2f} s, preset {summary.preset}, {summary.state} state, {summary.terrain}"
    page = Page(f"{summary.robot}: {run.folder.resolve().name}", f"{what}, seed {summary.seed}")
    outcome(page, run)
    for note in run.notes:
        page.text(f"Note: {note}.", "bad")
    page.heading("What was asked")
    page.code(scenario_toml(run.scenario))
    page.heading("What came of it")
    numbers(page, summary)
    page.heading("Faults and fallbacks")
    faults(page, run)
    if figures:
        page.heading("Figures")
        for draw in suitable(run.recording).values():
            page.figure(draw(run.recording), (draw.__doc__ or "").strip().split("\n")[0])
    page.heading("Again")
    page.text(f"The same run, from the same seed ({summary.seed}), gives the same result:")
    page.code(f"gaitsmith walk {shlex.quote(str(run.folder.resolve() / SCENARIO))} --out NEW_FOLDER")
    page.versions()
    return page.render()


def outcome(page: Page, run: Run) -> None:
    """How it ended, in a line."""
    summary = run.summary
    if summary.fall is not None:
        page.text(f"Fell at {summary.fall.time:.2f} s, {summary.fall.phase}: {summary.fall.reason}.", "bad")
        if (cause := summary.fall.cause) is not None:
            tried = {
                None: "not tried; gaitsmith why does" if not run.scenario.controller else "not tried",
                True: "without it the robot stands",
                False: "it falls without it too",
            }
            told = tried[cause.confirmed]
            page.text(f"Most likely begun by: {cause.what} ({told}).")
    elif summary.interrupted:
        page.text(f"Interrupted after {summary.duration:.2f} s, upright.", "bad")
    else:
        page.text("Upright to the end.", "good")


def numbers(page: Page, summary: Summary) -> None:
    """Stages, joints, and the rest in lines."""
    page.table(STAGE_HEADINGS, map(stage_row, summary.stages), left=())
    headings = ("joint", "largest torque\nN·m", "ticks at limit", "largest step\nN·m in 1 tick", "largest speed\nrad/s")
    rows = [
        (name, f"{peak:.1f}", f"{100.0 * summary.torque_saturated[name]:.2f} %",
         f"{summary.torque_step_max[name]:.1f}", f"{summary.velocity_peak[name]:.2f}")
        for name, peak in summary.torque_peak.items()
    ]  # fmt: skip
    page.table(headings, rows)
    for line in run_lines(summary):
        page.text(f"{line[0].upper()}{line[1:]}.")


def faults(page: Page, run: Run) -> None:
    """Everything that did not go as usual, counted; that nothing happened is said too."""
    summary, last = run.summary, dict(zip(run.log.columns, run.log.rows[-1], strict=True))
    rows = [(what, f"{int(last[name])}") for name, what in _COUNTERS.items() if name in last]
    rows += [(f"ticks with replaced readings of {sensor}", f"{count}") for sensor, count in summary.refused.items()]
    rows.append(("rows that the log lacks", f"{summary.log.dropped if summary.log else 0}"))
    rows.append(("ticks over the control period", f"{summary.tick_us.overruns}"))
    rows += [(f"physics engine: {warning}", "1") for warning in summary.warnings]
    rows += [(f"{f.time:.3f} s: {f.component}, {f.type}: {f.reaction}", "1") for f in summary.faults]
    happened = [row for row in rows if row[1] != "0"]
    page.table(("what", "how often"), happened or [("nothing that is counted happened", "0")])
