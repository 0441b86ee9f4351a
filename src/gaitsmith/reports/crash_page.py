"""The sheet of a crash test: one page with every figure, the map of pushes, and the command that makes it again."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from gaitsmith.experiments.crash import rows_of
from gaitsmith.experiments.options import CrashOptions
from gaitsmith.experiments.random_walks import DRAWN
from gaitsmith.files import write_text_atomic
from gaitsmith.reports.page import Page
from gaitsmith.view.canvas import save
from gaitsmith.view.push_map import draw_push_map

PAGE, PICTURE = "crash.html", "crash_pushes.png"


def write_crash_page(document: Mapping[str, Any], folder: Path) -> Path:
    """Write the page, and the map of pushes as a picture beside it.

    Raises:
        BadInput: the folder cannot be written.
    """
    picture = _map(document)
    if picture is not None:
        save(picture, folder / PICTURE)
    path = folder / PAGE
    write_text_atomic(path, crash_page(document, picture))
    return path


def crash_page(document: Mapping[str, Any], picture: Figure | None = None) -> str:
    """The page as HTML that needs nothing else.

    Args:
        document: of :func:`gaitsmith.experiments.run_crash`.
    """
    page = Page(f"Crash test of {document['robot']}", f"{document['controller']}, preset {document['preset']}")
    page.table(("part", "outcome"), rows_of(document), left=(0, 1))
    for note in document["notes"]:
        page.text(f"Note: {note}.", "bad")
    if picture is not None:
        page.heading("Pushes")
        page.figure(picture, "Direction of the push around the circle, phase of the stride outwards.")
    _largest(page, document["pushes"], document["weakest_push"])
    if document["episodes"]:
        _episodes(page, document["episodes"])
    if document["faults"]:
        page.heading("Faults")
        rows = [
            (e["component"], e["type"], f"{1000 * e['duration']:g}", f"{e['survived']} of {e['of']}", e["reaction"])
            for e in document["faults"]
            if e["survived"] < e["of"]
        ]
        page.text(f"{len(document['faults'])} combinations of component, type and duration; {len(rows)} felled it.")
        if rows:
            page.table(("component", "type", "duration, ms", "stood", "reaction"), rows, left=(0, 1, 4))
    if document["terrain"]:
        page.heading("Other ground")
        grounds = [(entry["what"], f"{entry['survived']} of {entry['of']}") for entry in document["terrain"]]
        page.table(("ground", "stood"), grounds)
    page.heading("Again")
    page.text("The same command gives the same figures, to the last digit, on the same machine type and versions.")
    page.code(command(document))
    page.text(f"Identity of code, versions and robot: {document['identity']}.", "muted")
    page.versions()
    return page.render()


def command(document: Mapping[str, Any]) -> str:
    """The command line that makes the document again."""
    asked, words = document["asked"], ["gaitsmith", "bench", "crash"]
    usual = CrashOptions().model_dump(mode="json")
    for name, value in asked.items():
        if value == usual[name] and name != "robot":
            continue
        if name == "only":
            words += [word for part in value for word in ("--only", part)]
        elif isinstance(value, list):
            words += [word for each in value for word in (f"--{name}", f"{each:g}")]
        else:
            words += [f"--{name}", f"{value:g}" if isinstance(value, float) else str(value)]
    return shlex.join(words)


def _map(document: Mapping[str, Any]) -> Figure | None:
    """The grid that was pushed, survivors shaded by how soon they recovered; None without one."""
    found = document["push_map"]
    if found is None or not found["run"]:
        return None
    title = f"{document['robot']}, {document['pushes']['strength']:g} m√(gH), {found['name']}"
    times = _matrix(found["survival_time"])
    again, offset = _matrix(found["recovery_time"]), found["directions_deg"][0]
    return draw_push_map(title, times, found["survival_limit"], again, offset)


def _matrix(rows: list[list[float | None]]) -> npt.NDArray[np.float64]:
    """A matrix with NaN for null."""
    return np.array([[np.nan if value is None else value for value in row] for row in rows], dtype=np.float64)


def _largest(page: Page, pushes: Mapping[str, Any] | None, weakest: Mapping[str, Any] | None) -> None:
    """Largest push survived in every direction."""
    if not pushes or not pushes["largest"]:
        return
    page.heading("Largest push survived at every phase")
    rows = [
        (f"{entry['direction']:g}°", f"{entry['strength']:.3f}", f"{entry['impulse']:.3g}")
        for entry in pushes["largest"]
    ]
    page.table(("direction (0° forward, 90° left)", "over m√(gH)", "N·s"), rows)
    if weakest is None:
        page.text("No push was found that fells it.")


def _episodes(page: Page, episodes: Mapping[str, Any]) -> None:
    """Random walks, and what felled them."""
    page.heading("Random walks")
    page.text(f"Each draws, from its seed: {DRAWN}.", "muted")
    causes: dict[str, list[int]] = {}
    for fall in episodes["falls"]:
        causes.setdefault(fall["cause"].split(" of ")[0].split(",")[0], []).append(fall["seed"])
    ordered = Counter({cause: len(seeds) for cause, seeds in causes.items()}).most_common()
    rows = [(cause, str(count), ", ".join(map(str, causes[cause][:12]))) for cause, count in ordered]
    if rows:
        page.table(("likeliest cause of the fall", "falls", "seeds"), rows, left=(0, 2))
    else:
        page.text("No fall.", "good")
