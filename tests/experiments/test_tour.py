"""The tour's totals are those of its runs: survival, errors of waypoints whose time was over, falls by strength."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from tests.experiments.made_up import made_up_summary

from gaitsmith.documents import checked
from gaitsmith.errors import BadInput
from gaitsmith.experiments import TourOptions, run_tour
from gaitsmith.experiments import tour as module
from gaitsmith.experiments.episodes import Episodes
from gaitsmith.robots import load_robot
from gaitsmith.simulation import Scenario
from gaitsmith.simulation.summary import TourReport

BEGIN, LENGTH, FELL_AT = 3.0, 90.0, 3.0 + 12.0


def _episodes(wanted: Any, *_: Any, **__: Any) -> Episodes:
    """The first run completes; the others fall in their third segment, after the third punch."""
    found = {}
    for k, scenario in enumerate(wanted):
        fell = None if k == 0 else FELL_AT
        count = 18 if k == 0 else 3
        score = TourReport(
            position_error=(*[0.1] * (count - 1), 0.7), yaw_error_deg=(5.0,) * count, energy=1000.0 * k + 1.0
        )
        landed = len(scenario.pushes) if k == 0 else 3
        began = tuple(push.time if n < landed else None for n, push in enumerate(scenario.pushes))
        duration = BEGIN + LENGTH if k == 0 else FELL_AT
        found[scenario] = made_up_summary(fell, duration=duration, pushes=began, tour=score)
    return Episodes(found, False, 0)


@pytest.fixture
def document(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    monkeypatch.setattr(module, "run_all", _episodes)
    return run_tour(TourOptions(runs=4, out=str(tmp_path))).document


def test_survival_counts_from_the_beginning_of_the_walk(document: dict[str, Any]) -> None:
    assert (document["runs"], document["completed"]) == (4, 1)
    assert document["mean_survival_s"] == pytest.approx((LENGTH + 3 * 12.0) / 4)
    assert [entry["id"] for entry in document["per_run"]] == [0, 1, 2, 3]
    assert [entry["survived_s"] for entry in document["per_run"]] == [LENGTH, 12.0, 12.0, 12.0]
    assert [bool(entry["reason"]) for entry in document["per_run"]] == [False, True, True, True]


def test_errors_are_those_of_waypoints_whose_time_was_over(document: dict[str, Any]) -> None:
    assert document["position_error_m"] == pytest.approx((17 * 0.1 + 0.7 + 3 * 2 * 0.1) / 24)
    with_the_fallen = document["with_the_fallen"]["position_error_m"]
    assert with_the_fallen == pytest.approx((17 * 0.1 + 0.7 + 3 * (2 * 0.1 + 0.7)) / 27)
    assert document["energy_j"] == 1.0  # of the runs that completed


def test_a_fall_belongs_to_the_last_punch_that_landed(document: dict[str, Any]) -> None:
    bins = document["punches"]
    assert sum(entry["landed"] for entry in bins) == 18 + 3 * 3
    assert sum(entry["falls"] for entry in bins) == 3
    assert all(entry["falls"] <= entry["landed"] for entry in bins)
    assert [entry["from"] for entry in bins] == pytest.approx([0.05 * k for k in range(7)])


def test_legs_are_bent_as_far_as_the_card_allows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "run_all", _episodes)
    gait = run_tour(TourOptions(runs=2, out=str(tmp_path))).document["gait"]
    card = load_robot("bhr_b2").card
    assert card.gait_limits.height[0] <= gait["height"] < card.gait.height
    assert gait["period"] ** 2 / gait["height"] == pytest.approx(card.gait.period**2 / card.gait.height, rel=1e-3)
    assert gait["width"] > card.gait.width


def test_commands_stay_within_the_card(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Scenario] = []

    def keep(wanted: Any, *given: Any, **more: Any) -> Episodes:
        seen.extend(wanted)
        return _episodes(seen, *given, **more)

    monkeypatch.setattr(module, "run_all", keep)
    result = run_tour(TourOptions(runs=2, force=0.0, height=0.6, out=str(tmp_path)))
    assert all(scenario.tour is not None and scenario.tour.yaw_rate == 0.0 for scenario in seen)  # its legs cannot turn
    assert all(scenario.height == 0.6 and scenario.pushes == () for scenario in seen)
    assert not any("falls per punch" in note for note in result.notes)
    assert {len(row) for row in result.rows} == {len(result.columns)}
    assert (tmp_path / "tour.json").is_file()


@pytest.mark.parametrize(("field", "value"), [("runs", 0), ("force", -1.0), ("height", 9.0)])
def test_numbers_out_of_range_are_refused(field: str, value: float, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=field):
        run_tour(checked(TourOptions, {field: value, "out": str(tmp_path)}))
