"""Trials are data, and judged by their worst episode."""

from __future__ import annotations

import json
from itertools import pairwise

import pytest
from tests.experiments.made_up import made_up_stage, made_up_summary
from tests.simulation.standing import robot

from gaitsmith.errors import BadInput
from gaitsmith.experiments import battery, battery_trials, run_battery
from gaitsmith.experiments.battery import TrialOutcome
from gaitsmith.experiments.limits import QUANTITIES, Limit, judge, shown
from gaitsmith.experiments.measures import measure
from gaitsmith.experiments.trials import Trial
from gaitsmith.simulation.scenario import check_scenario

TRIAL = Trial("walk", {"duration": 5.0}, (Limit("speed_error", 0.003),), ("pitch",), seeds=(0, 1))


def _outcome(*summaries, trial=TRIAL):
    padded = [*summaries, *[None] * (len(trial.seeds) - len(summaries))]
    return TrialOutcome(trial, tuple(zip(trial.scenarios("bhr_b2", "default"), padded, strict=True)))


def _walked(error: float, **given):
    return made_up_summary(stages=(made_up_stage(vx_error=error),), **given)


def test_every_trial_fits_the_shipped_robot_and_measures_known_quantities():
    trials = battery_trials()
    assert len({trial.name for trial in trials}) == len(trials)
    for trial in trials:
        assert {limit.quantity for limit in trial.limits} | set(trial.reported) <= set(QUANTITIES)
        for scenario in trial.scenarios("bhr_b2", "default"):
            check_scenario(scenario, robot())


def test_changes_are_held_for_twenty_seconds():
    for trial in battery_trials():
        if trial.name.split("_")[0] in ("height", "lift", "period", "alpha"):
            (scenario,) = trial.scenarios("bhr_b2", "default")
            times = [*(change.time for change in scenario.changes), scenario.duration]
            assert all(after - before >= 20.0 for before, after in pairwise(times))
            assert scenario.speed == (0.2, 0.0)


def test_the_paper_s_trials_keep_their_preset_and_the_rest_take_the_one_asked_for():
    presets = {trial.name: trial.scenarios("bhr_b2", "mine")[0].preset for trial in battery_trials()}
    assert {name for name, preset in presets.items() if preset == "paper"} == {"paper_0", "paper_0.4"}
    assert set(presets.values()) == {"paper", "mine"}


def test_the_worst_episode_decides():
    assert _outcome(_walked(0.001), _walked(-0.002)).verdict == "pass"
    assert _outcome(_walked(0.001), _walked(-0.004)).verdict == "miss"
    (limited, reported) = _outcome(_walked(0.001), _walked(-0.004)).judgement.findings
    assert (limited.value, limited.verdict()) == (0.004, "miss")
    assert reported.verdict() == "report"


def test_a_fall_is_a_miss_whatever_the_numbers_say():
    outcome = _outcome(_walked(0.0), _walked(0.0, fell_at=3.0))
    assert outcome.verdict == "miss"
    assert outcome.row()[2].startswith("1 of 2 fell")
    assert "seed 0: fell at 3.00 s" in outcome.notes()[0]


def test_missing_episodes_are_not_a_pass_but_a_miss_stays_one():
    assert _outcome().verdict == "not run"
    assert _outcome(_walked(0.0)).verdict == "not run"
    assert _outcome(_walked(0.5)).verdict == "miss"


def test_a_trial_that_is_not_judged_reports_its_falls():
    trial = Trial("far", {"duration": 5.0}, judged=False)
    outcome = _outcome(made_up_summary(fell_at=3.0), trial=trial)
    assert (outcome.verdict, trial.target()) == ("report", "report")


def test_limits_hold_at_their_bound_and_nothing_holds_for_no_number():
    assert Limit("roll", 0.4).met(0.4)
    assert not Limit("roll", 0.4).met(0.4000001)
    assert not Limit("roll", 0.4).met(float("nan"))
    assert Limit("separation", 0.07, least=True).met(0.07)
    assert not Limit("separation", 0.07, least=True).met(float("nan"))
    assert Limit("separation", 0.07, least=True).target() == "separation ≥ 7 cm"
    assert shown("speed_error", 0.0021) == "2.1 mm/s"


def test_a_quantity_that_was_not_measured_is_no_pass():
    judgement = judge([Limit("speed_error", 1.0)], [], [measure(made_up_summary(stages=()))], falls=0)
    assert judgement.verdict == "miss"


def test_measures_take_the_largest_magnitude_over_the_stages():
    stages = (
        made_up_stage(rest=True, vx_error=9.0, roll_deg=(-0.7, 0.1)),
        made_up_stage(vx_error=0.01, vy_error=-0.02, height_error=-0.003, pitch_deg=(-1.5, 0.2)),
        made_up_stage(vx_error=-0.005),
    )
    found = measure(made_up_summary(stages=stages))
    assert found["speed_error"] == 0.01
    assert found["lateral_error"] == 0.02
    assert found["speed_bias"] == -0.005
    assert found["height_error"] == 0.003
    assert (found["roll"], found["pitch"]) == (0.7, 1.5)  # rests count
    assert found["qp_fallbacks"] == 0.002


def test_a_battery_runs_writes_and_resumes(tmp_path, monkeypatch):
    short = {"duration": 1.5, "rest_before": 0.5}
    trials = (Trial("short", short, reported=("pitch",)), Trial("unfit", {**short, "height": 5.0}))
    monkeypatch.setattr(battery, "battery_trials", lambda: trials)
    first = run_battery(out=tmp_path)
    assert [row[0] for row in first.rows] == ["short", "unfit"]
    assert [row[3] for row in first.rows] == ["pass", "skipped"]
    assert any("height 5.0" in note for note in first.notes)
    assert json.loads((tmp_path / "battery.json").read_text())["verdicts"] == {"pass": 1, "skipped": 1}
    again = run_battery(out=tmp_path)
    assert again.document == first.document
    assert any("1 of 1 episodes found" in note for note in again.notes)
    assert [row[0] for row in run_battery(only=["short"], out=tmp_path).rows] == ["short"]


@pytest.mark.parametrize(("options", "field"), [({"only": ["nothing"]}, "--only"), ({"preset": "none"}, "--preset")])
def test_options_that_cannot_be_used_are_named(tmp_path, options, field):
    with pytest.raises(BadInput) as caught:
        run_battery(**options, out=tmp_path)
    assert caught.value.field == field
