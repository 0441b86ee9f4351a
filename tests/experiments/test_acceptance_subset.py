"""A fixed part of the acceptance grids in closed loop; ``gaitsmith bench battery`` and ``bench push`` run the whole.

Scenarios and limits are the set's own, so what passes there passes here.
"""

from __future__ import annotations

from dataclasses import replace

import pytest
from tests.simulation.standing import robot

from gaitsmith.experiments import load_set
from gaitsmith.experiments.battery import TrialOutcome
from gaitsmith.experiments.push_grid import Cell, survived
from gaitsmith.simulation import run_episode

WALKS = load_set("walks")
TRIALS = {trial.name: trial for trial in WALKS.trials}
BOXES_SEED, SENSORS_SEED = 2, 3  # any would do; these are never chosen by how they come out

# One cell of each grid of 15 N·s, of which all have to stand: outward over either stance leg, the weakest push,
# backwards at touchdown, and obliquely forward at the other one.
OUTWARD_LEFT, OUTWARD_RIGHT, BACKWARD, OBLIQUE = Cell(2, 3), Cell(6, 9), Cell(4, 0), Cell(1, 6)
PUSHES = list(zip(WALKS.grids[:4], (OUTWARD_LEFT, OUTWARD_RIGHT, BACKWARD, OBLIQUE), strict=True))


@pytest.mark.parametrize(
    ("name", "seed"),
    [("figure5", 0), ("slope_+8", 0), ("boxes", BOXES_SEED), ("figure5_estimated", SENSORS_SEED)],
)
def test_trial_of_the_battery(name, seed):
    scenario = TRIALS[name].scenarios[seed]
    trial = replace(TRIALS[name], scenarios=(scenario,))
    outcome = TrialOutcome(trial, ((scenario, run_episode(scenario, robot=robot(), record=False).summary),))
    assert outcome.verdict == "pass", " | ".join([*outcome.row(), *outcome.notes()])


@pytest.mark.parametrize(("grid", "cell"), PUSHES, ids=[f"{grid.slug}-{cell[0]}-{cell[1]}" for grid, cell in PUSHES])
def test_push_of_15_newton_seconds(grid, cell):
    summary = run_episode(grid.scenario(cell), robot=robot(), record=False).summary
    assert survived(summary), summary.fall.reason if summary.fall else "the push never began"
    separation = summary.min_foot_separation
    assert grid.separation.met(separation), f"{100 * separation:.1f} cm"
