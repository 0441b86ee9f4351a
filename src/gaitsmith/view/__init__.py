"""Figures of an episode as PNG and SVG files, drawn without a display."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np

from gaitsmith.errors import BadInput

try:
    from matplotlib.figure import Figure
except ValueError as error:  # it reads the variable when it is imported, though figures need no window
    remedy = "unset it: figures are drawn without a display"
    raise BadInput("MPLBACKEND", os.environ.get("MPLBACKEND", ""), "a backend of matplotlib", remedy) from error

from gaitsmith.view.canvas import save as save
from gaitsmith.view.fall import draw_fall as draw_fall
from gaitsmith.view.footprints import draw_footprints as draw_footprints
from gaitsmith.view.landings import draw_landings as draw_landings
from gaitsmith.view.push_map import draw_push_map as draw_push_map
from gaitsmith.view.recording import Recording as Recording
from gaitsmith.view.tracking import draw_feet as draw_feet
from gaitsmith.view.tracking import draw_height as draw_height
from gaitsmith.view.tracking import draw_joints as draw_joints
from gaitsmith.view.tracking import draw_speed as draw_speed
from gaitsmith.view.tracking import draw_timing as draw_timing
from gaitsmith.view.tracking import draw_torques as draw_torques

FIGURES: dict[str, Callable[[Recording], Figure]] = {
    "speed": draw_speed,
    "height": draw_height,
    "joints": draw_joints,
    "feet": draw_feet,
    "torques": draw_torques,
    "footprints": draw_footprints,
    "landings": draw_landings,
    "fall": draw_fall,
    "timing": draw_timing,
}
"""Every figure by the name of its file."""


def suitable(recording: Recording) -> dict[str, Callable[[Recording], Figure]]:
    """Figures that a recording has something for: ``timing`` with durations, ``landings`` of steps, ``fall`` of one."""
    absent = {
        "timing": not len(recording.tick_us),
        "landings": not np.any(recording.walking & (recording.stance < 2)),
        "fall": recording.fell is None,
    }
    return {name: draw for name, draw in FIGURES.items() if not absent.get(name)}


def write_figures(recording: Recording, folder: Path) -> list[Path]:
    """Draw every suitable figure of a recording into a folder, as ``<name>.png`` and ``<name>.svg``.

    Raises:
        BadInput: the folder cannot be written.
    """
    return [save(draw(recording), folder / f"{name}.png") for name, draw in suitable(recording).items()]
