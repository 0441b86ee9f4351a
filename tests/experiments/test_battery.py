"""Trials are data, and judged by their worst episode."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from tests.experiments.made_up import made_up_stage, made_up_summary
from tests.simulation.standing import robot

from gaitsmith.errors import BadInput
from gaitsmith.experiments import BatteryOptions, battery, run_battery
from gaitsmith.experiments.battery import TrialOutcome
from gaitsmith.experiments.limits import Limit, judge, measure, shown
from gaitsmith.experiments.sets import Trial, TrialEntry, TrialSet
from gaitsmith.simulation.scenario import make_scenario

SHORT = {"duration": 1.5, "rest_before": 0.5}
EPISODES = tuple(make_scenario({"duration": 5.0, "seed": seed}) for seed in (0, 1))
TRIAL = Trial(TrialEntry(name="walk", report=("pitch",)), EPISODES, (Limit("speed_error", 0.003),))


def _outcome(*summaries, trial=TRIAL):
    padded = [*summaries, *[None] * (len(trial.scenarios) - len(summaries))]
    return TrialOutcome(trial, tuple(zip(trial.scenarios, padded, strict=True)))


def _walked(error: float, **given):
    return made_up_summary(stages=(made_up_stage(vx_error=error),), **given)


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


def test_as_many_falls_as_the_trial_allows_are_no_miss():
    trial = replace(TRIAL, entry=TrialEntry(name="walk", least=1))
    assert _outcome(_walked(0.0), _walked(0.0, fell_at=3.0), trial=trial).verdict == "pass"
    assert trial.target().startswith("≥ 1 of 2 stand")


def test_missing_episodes_are_not_a_pass_but_a_miss_stays_one():
    assert _outcome().verdict == "not run"
    assert _outcome(_walked(0.0)).verdict == "not run"
    assert _outcome(_walked(0.5)).verdict == "miss"


def test_a_trial_that_is_not_judged_reports_its_falls():
    trial = Trial(TrialEntry(name="far", judged=False), EPISODES[:1])
    outcome = _outcome(made_up_summary(fell_at=3.0), trial=trial)
    assert (outcome.verdict, trial.target()) == ("report", "report")


def test_limits_hold_at_their_bound_and_nothing_holds_for_no_number():
    assert Limit("roll", 0.4).met(0.4)
    assert not Limit("roll", 0.4).met(0.4000001)
    assert not Limit("roll", 0.4).met(float("nan"))
    assert Limit("separation", 0.07).met(0.07)
    assert not Limit("separation", 0.07).met(float("nan"))
    assert Limit("separation", 0.07).target() == "separation ≥ 7 cm"
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
    short, unfit = make_scenario(SHORT), make_scenario({**SHORT, "height": 5.0})
    trials = (Trial(TrialEntry(name="short", report=("pitch",)), (short,)), Trial(TrialEntry(name="unfit"), (unfit,)))
    monkeypatch.setattr(battery, "load_set", lambda *_: TrialSet("made_up", robot(), trials, (), {}))
    first = run_battery(BatteryOptions(out=str(tmp_path)))
    assert [row[0] for row in first.rows] == ["short", "unfit"]
    assert [row[3] for row in first.rows] == ["pass", "skipped"]
    assert any("height 5.0" in note for note in first.notes)
    assert json.loads((tmp_path / "battery.json").read_text())["verdicts"] == {"pass": 1, "skipped": 1}
    again = run_battery(BatteryOptions(out=str(tmp_path)))
    assert again.document == first.document
    assert any("1 of 1 episodes found" in note for note in again.notes)
    assert [row[0] for row in run_battery(BatteryOptions(only=("short",), out=str(tmp_path))).rows] == ["short"]


@pytest.mark.parametrize(
    ("options", "field"),
    [({"only": ["nothing"]}, "--only"), ({"preset": "none"}, "--preset"), ({"set": "none"}, "--set")],
)
def test_options_that_cannot_be_used_are_named(tmp_path, options, field):
    with pytest.raises(BadInput) as caught:
        run_battery(BatteryOptions(**options, out=str(tmp_path)))
    assert caught.value.field == field
