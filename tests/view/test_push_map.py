"""The map of pushes draws every cell, and says how many stood."""

from __future__ import annotations

import numpy as np
import pytest

from gaitsmith.errors import BadInput
from gaitsmith.view import save
from gaitsmith.view.push_map import draw_push_map


def _cells(made):
    return made.axes[0].patches


def test_every_push_is_a_cell_and_is_counted(tmp_path):
    seconds = np.full((8, 12), 10.0)
    seconds[2, 3], seconds[5, 0] = 1.5, np.nan
    made = draw_push_map("15 N·s", seconds, 10.0)
    assert len(_cells(made)) == 96
    assert made.texts[0].get_text() == "15 N·s: 94 of 95 survived"
    assert save(made, tmp_path / "map.png").stat().st_size > 10_000


def test_standing_falling_and_not_run_look_different():
    made = draw_push_map("", [[10.0, 2.0, np.nan]], 10.0)
    assert len({cell.get_facecolor() for cell in _cells(made)}) == 3


def test_survivors_are_shaded_by_recovery_and_those_that_never_were_calm_are_marked():
    made = draw_push_map("", [[10.0, 10.0, 10.0, 2.0]], 10.0, [[0.5, 2.4, np.nan, np.nan]])
    assert len({cell.get_facecolor() for cell in _cells(made)}) == 3
    assert sum(line.get_marker() == "x" for line in made.axes[0].lines) == 1


def test_the_first_direction_may_be_off():
    made = draw_push_map("", np.full((8, 2), 10.0), 10.0, offset=11.25)
    assert made.axes[0].get_xticklabels()[0].get_text() == "11.25°"


@pytest.mark.parametrize(("seconds", "limit"), [([1.0], 10.0), (np.zeros((0, 3)), 10.0), ([[1.0]], 0.0)])
def test_what_is_not_a_grid_is_refused(seconds, limit):
    with pytest.raises(BadInput):
        draw_push_map("", seconds, limit)
