"""The demonstration: the first paper's speed profile, then the second paper's walk and kick, planned and walked."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from gaitsmith.errors import GaitsmithError
from gaitsmith.files import write_text_atomic
from gaitsmith.reports.page import Page
from gaitsmith.reports.rendering import NoRenderer
from gaitsmith.reports.run import Run, make_run
from gaitsmith.reports.run_page import faults, numbers, outcome
from gaitsmith.reports.strip import strip
from gaitsmith.robots import load_robot
from gaitsmith.simulation.planned_run import completed
from gaitsmith.simulation.scenario import load_scenario, make_scenario
from gaitsmith.synthesis import Gait, Planner, Request, answer, write_gait
from gaitsmith.view import draw_feet, draw_footprints, draw_landings, draw_speed, draw_torques
from gaitsmith.view.gait_figures import draw_ground
from gaitsmith.view.gait_trace import GaitTrace
from gaitsmith.view.sticks import draw_sticks

PROFILE, PLANNED = "figure5", ("walk", "kick")
Tell = Callable[[str, str, float | None, float | None], None]


@dataclass(frozen=True)
class Demo:
    """What the demonstration did."""

    page: Path
    profile: Run
    planned: dict[str, Run]


def run_demo(folder: Path, tell: Tell) -> Demo:
    """Walk the profile, plan and walk the rest, and write the page; everything is in the folder, a part at a time.

    Args:
        folder: new or empty.
        tell: hears what is being done, how far, completed and total.

    Raises:
        BadInput: the folder cannot be written.
        GaitsmithError: a plan was not solved.
    """
    scenario = load_scenario(PROFILE)
    profile = make_run(scenario, folder / PROFILE, _walking("speed profile", scenario.duration, tell))
    gaits = _plans(folder, tell)
    planned = {}
    for name in PLANNED:
        asked = make_scenario(completed({"gait": [str((folder / f"{name}.json").resolve())]}))
        planned[name] = make_run(asked, folder / name, _walking(f"planned {name}", asked.duration, tell))
    tell("drawing", "", None, None)
    page = folder / "report.html"
    write_text_atomic(page, _page(profile, planned, gaits, tell))
    return Demo(page, profile, planned)


def _walking(name: str, end: float, tell: Tell) -> Callable[[float], None]:
    return lambda time: tell(f"walking the {name}", f"{time:.1f} of {end:.0f} s", time, end)


def _plans(folder: Path, tell: Tell) -> dict[str, Gait]:
    """The planned motions, each written as a gait file."""
    planner = Planner(load_robot("thbip_ii"), lambda text: tell(text, "", None, None))
    found = {}
    for name in PLANNED:
        tell(f"planning the {name}", "", None, None)
        request = Request("walk") if name == "walk" else Request("kick")
        plan = answer(
            planner,
            request,
            lambda motion, rounds, at: tell(f"planning {motion}", f"iteration {at.iteration}", None, None),
        )
        if plan.gait is None:
            raise GaitsmithError(f"the {name} was not planned: {plan.main.status}: {plan.main.reason}")
        found[name] = plan.gait
        write_gait(folder / f"{name}.json", plan.gait)
    return found


def _page(profile: Run, planned: dict[str, Run], gaits: dict[str, Gait], tell: Tell) -> str:
    """Everything on one page."""
    page = Page("gaitsmith: what it does", "a gait template walked in closed loop, whole motions planned and walked")
    page.text("Everything below was simulated and drawn just now, on this machine, from seed 0.")
    page.heading(f"{profile.summary.robot}: speed from 0 to 0.7 m/s and back")
    _part(page, profile, [draw_speed(profile.recording), draw_footprints(profile.recording)], tell)
    page.figure(draw_landings(profile.recording), "how closely the feet land where they are told to")
    for name, run in planned.items():
        tell("drawing", name, None, None)
        page.heading(f"{run.summary.robot}: a {name} planned by optimisation, then walked by the same controller")
        trace = GaitTrace(gaits[name], run.robot)
        page.heading("the plan", 3)
        page.figure(draw_sticks(trace))
        page.figure(draw_ground(trace))
        page.heading("the closed loop", 3)
        _part(page, run, [draw_feet(run.recording) if name == "walk" else draw_torques(run.recording)], tell)
    page.heading("Go on from here")
    page.code("\n".join(next_lines(profile.folder)))
    page.versions()
    return page.render()


def _part(page: Page, run: Run, figures: Sequence[Figure], tell: Tell) -> None:
    """One run: pictures, figures, numbers, faults."""
    outcome(page, run)
    tell("drawing", run.folder.name, None, None)
    try:
        times = np.linspace(0.2, float(run.log.time[-1]) - 0.2, 12)
        page.picture(strip(run, times), "image/png", f"{times[1] - times[0]:.1f} s from one picture to the next")
    except NoRenderer as error:
        page.text(f"No pictures: {error}.", "muted")
    for made in figures:
        page.figure(made)
    numbers(page, run.summary)
    faults(page, run)


def next_lines(folder: Path) -> list[str]:
    """What to type next."""
    return [
        "gaitsmith walk --speed 0.4 --push 4,0,20,0 --out pushed   # push it",
        "gaitsmith walk --robot thbip_ii --speed 0.2 --yaw-rate 0.3   # turn",
        f"gaitsmith plot {folder} --what torques   # more figures of this run",
        "gaitsmith adopt my_robot.urdf   # your own robot",
    ]
