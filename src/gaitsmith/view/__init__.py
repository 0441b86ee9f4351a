"""Figures of an episode as PNG files, drawn without a display."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from matplotlib.figure import Figure

from gaitsmith.view.canvas import save as save
from gaitsmith.view.footprints import draw_footprints as draw_footprints
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
    "timing": draw_timing,
}
"""Every figure by the name of its file."""


def write_figures(recording: Recording, folder: Path) -> list[Path]:
    """Draw every figure of a recording into a folder, as ``<name>.png``; ``timing`` only if durations are known.

    Raises:
        BadInput: the folder cannot be written.
    """
    wanted = {name: draw for name, draw in FIGURES.items() if name != "timing" or len(recording.tick_us)}
    return [save(draw(recording), folder / f"{name}.png") for name, draw in wanted.items()]
