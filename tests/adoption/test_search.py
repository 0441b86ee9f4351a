"""The search is seeded, stays within its ranges and the card's limits, and ends with the first gait that walks."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from tests.experiments.made_up import made_up_stage, made_up_summary

from gaitsmith.adoption import search as searching
from gaitsmith.adoption.search import Candidate, Found, score, search
from gaitsmith.control.defaults import default_parameters, robot_scale
from gaitsmith.experiments.episodes import Episodes
from gaitsmith.experiments.result import silent
from gaitsmith.experiments.store import Store
from gaitsmith.robots import load_robot
from gaitsmith.robots.presets import CardPreset
from gaitsmith.simulation import Scenario, Summary

ROBOT = load_robot("thbip_ii")
FALLS, WALKS = made_up_summary(fell_at=3.0), made_up_summary()


def tried(
    monkeypatch: pytest.MonkeyPatch, folder: Path, outcomes: Any, most: int = 20, seed: int = 1
) -> tuple[Found | None, list[Scenario]]:
    """A search whose runs are not run."""
    asked: list[Scenario] = []

    def run(scenarios: Sequence[Scenario], *_: Any, **__: Any) -> Episodes:
        first = len(asked)
        asked.extend(scenarios)
        return Episodes({s: outcomes(first + k) for k, s in enumerate(scenarios)}, False, 0)

    monkeypatch.setattr(searching, "run_all", run)
    found = search(ROBOT, lambda presets: ("thbip_ii", ROBOT), Store(folder), most, seed, 1, silent)
    return found, asked


def test_it_ends_with_the_first_round_in_which_one_walks(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    found, asked = tried(monkeypatch, tmp_path, lambda k: WALKS if k == 10 else FALLS)
    assert found is not None
    assert found.walks
    assert (found.rollouts, len(asked)) == (16, 16)
    assert found.gait["period"] == asked[10].period


def test_it_gives_up_after_the_number_allowed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    found, asked = tried(monkeypatch, tmp_path, lambda k: FALLS, most=11)
    assert found is not None
    assert not found.walks
    assert len(asked) == 11


def test_the_same_seed_tries_the_same(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    first, second, other = (tried(monkeypatch, tmp_path, lambda k: FALLS, most=8, seed=seed)[1] for seed in (1, 1, 2))
    assert first == second != other
    assert len(set(first)) == 8


def test_candidates_keep_the_cards_limits_and_are_presets_of_a_card() -> None:
    defaults = default_parameters(robot_scale(ROBOT))
    for factor in (0.01, 1.0, 100.0):
        names = (*searching._GAIT, *searching.GAINS)
        candidate = Candidate(dict.fromkeys(names, factor))
        for name, value in candidate.gait(ROBOT).items():
            low, high = getattr(ROBOT.card.gait_limits, name)
            assert low <= value <= high
        CardPreset.model_validate(candidate.gains(defaults))


@pytest.mark.parametrize(
    ("worse", "better"),
    [
        (made_up_summary(fell_at=3.0), made_up_summary(fell_at=9.0)),
        (made_up_summary(fell_at=15.0), made_up_summary(stages=(made_up_stage(vx_error=-0.3),))),
        (made_up_summary(stages=(made_up_stage(vx_error=-0.03),)), made_up_summary()),
        (made_up_summary(stages=(made_up_stage(heading_drift_deg=-20.0),)), made_up_summary()),
    ],
)
def test_later_falls_and_smaller_errors_are_better(worse: Summary, better: Summary) -> None:
    assert score(worse) < score(better)
