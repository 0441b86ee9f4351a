"""``gaitsmith bench``: the measurements behind every quoted figure, resumable, on as many cores as wanted."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any, cast

from pydantic import create_model

from gaitsmith.cli.arguments import Arguments, parse
from gaitsmith.cli.dispatch import DONE, INTERRUPTED, Outcome, Table, Text
from gaitsmith.documents import Frozen
from gaitsmith.experiments.options import (
    BatteryOptions,
    CrashOptions,
    FallOptions,
    FaultOptions,
    PushOptions,
    TickOptions,
    TourOptions,
)
from gaitsmith.files import uninterrupted

_EXPERIMENTS: dict[str, tuple[type[Frozen], str]] = {
    "tick": (TickOptions, "measure_tick"),
    "push": (PushOptions, "push_grids"),
    "battery": (BatteryOptions, "run_battery"),
    "falls": (FallOptions, "run_falls"),
    "faults": (FaultOptions, "run_faults"),
    "tour": (TourOptions, "run_tour"),
    "crash": (CrashOptions, "run_crash"),
}


def bench(words: list[str], program: str) -> Outcome:
    """Run the experiment that the program's last word names, with progress on stderr.

    An experiment takes its options and ``progress(done, total, what)``; it returns ``document`` (plain data),
    ``columns`` and ``rows`` (words), ``notes`` (lines) and ``interrupted``.
    """
    model, name = _EXPERIMENTS[program.split()[-1]]
    made = create_model(model.__name__, __base__=(model, Arguments), __doc__=model.__doc__)
    options = parse(cast("type[Arguments]", made), words, program)
    from gaitsmith.cli.display import Display

    experiment: Callable[..., Any] = getattr(import_module("gaitsmith.experiments"), name)
    with Display("loading (the first time compiles)") as display:
        result = experiment(options, display.advance)
    text: list[Text] = []
    with uninterrupted():  # the figures belong to what is recorded already
        _draw_grids(result.document, getattr(options, "out", ""))
        if "push_map" in result.document:
            from gaitsmith.reports.crash_page import write_crash_page

            text = [f"sheet: {write_crash_page(result.document, Path(getattr(options, 'out', '')))}"]
    told: list[Text] = [Table(result.columns, result.rows), *result.notes, *text]
    return Outcome(INTERRUPTED if result.interrupted else DONE, result.document, told)


def _draw_grids(document: dict[str, Any], folder: str) -> None:
    """A map of every grid of pushes, beside its numbers."""
    if not document.get("grids"):
        return
    from gaitsmith.view import draw_push_map, save

    for grid in document["grids"]:
        if "survival_time" in grid:
            picture = draw_push_map(
                grid["name"], grid["survival_time"], grid["survival_limit"], offset=grid["directions_deg"][0]
            )
            save(picture, Path(folder) / f"{grid['slug']}.png")
