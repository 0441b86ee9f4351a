"""Tuning tries candidates on the same walks, judges the best on others, and writes a card only for what is better."""

from __future__ import annotations

import json

import numpy as np
import pytest
from tests.experiments.made_up import made_up_summary

from gaitsmith.adoption import tuning
from gaitsmith.adoption.options import TuneOptions
from gaitsmith.adoption.tuning import HELD_OUT, TUNED, tune
from gaitsmith.control.defaults import preset_parameters, robot_scale
from gaitsmith.errors import BadInput
from gaitsmith.experiments.episodes import Episodes
from gaitsmith.experiments.withstanding import STRONGEST, pushed_walks, score, withstood
from gaitsmith.robots import load_robot

STANDS, FALLS = made_up_summary(pushed_at=3.0), made_up_summary(pushed_at=3.0, fell_at=5.0)


@pytest.fixture
def asked(monkeypatch):
    """Walks that are not run: candidate 3 of the first round stands, and so does whatever is judged after it."""
    groups = []

    def run_all(scenarios, robot, store, **_):
        wanted = list(scenarios)
        groups.append(wanted)
        judged = wanted[0].seed >= HELD_OUT
        good = "tuned_try_1" if judged else "tuned_try_3"
        return Episodes({one: STANDS if one.preset == good else FALLS for one in wanted}, False, 0)

    monkeypatch.setattr(tuning, "run_all", run_all)
    return groups


def test_the_best_is_judged_on_other_seeds_and_written_as_a_preset(tmp_path, asked):
    found = tune(TuneOptions(robot="thbip_ii", candidates=10, runs=4, held_out=6, out=str(tmp_path)))
    assert [len(group) for group in asked] == [4, 32, 8, 12]
    searched, judged = ({one.seed for group in part for one in group} for part in (asked[:3], asked[3:]))
    assert (len(searched), len(judged), searched & judged) == (4, 6, set())
    held = found.document["held_out"]
    assert (held["before"], held["after"], held["better"], held["worse"]) == (0.0, STRONGEST, 6, 0)
    assert found.document == json.loads(json.dumps(found.document))
    robot, tuned = load_robot("thbip_ii"), load_robot(found.card)
    today, better = (
        preset_parameters(one, robot_scale(one), name) for one, name in ((robot, "default"), (tuned, "tuned"))
    )
    for name in ("cop.gain", "foothold.reach", "weights.swing_foot"):
        group, _, entry = name.partition(".")
        ratio = np.divide(getattr(getattr(better, group), entry), getattr(getattr(today, group), entry))
        np.testing.assert_allclose(ratio, found.document["factors"][name], rtol=1e-3)
    assert preset_parameters(tuned, robot_scale(tuned), "default") == today
    assert all(TUNED[name][0] <= factor <= TUNED[name][1] for name, factor in found.document["factors"].items())


def test_the_same_seed_tries_the_same_and_nothing_worse_is_written(tmp_path, asked, monkeypatch):
    wishes = TuneOptions(robot="thbip_ii", candidates=8, runs=4, held_out=4, out=str(tmp_path))
    texts = []
    write = tuning._Bench.write
    monkeypatch.setattr(
        tuning._Bench, "write", lambda bench, *given: (texts.append(str(given[1])), write(bench, *given))
    )
    tune(wishes)
    count = len(texts)
    tune(wishes)
    assert texts[:count] == texts[count:]
    monkeypatch.setattr(tuning, "withstood", lambda _: 0.1)
    assert tune(TuneOptions(robot="thbip_ii", candidates=8, runs=4, held_out=4, out=str(tmp_path / "b"))).card is None
    assert not (tmp_path / "b" / "card").exists()


def test_ctrl_c_writes_no_card_and_says_how_far_it_came(tmp_path, monkeypatch):
    monkeypatch.setattr(tuning, "run_all", lambda *_, **__: Episodes({}, True, 0))
    found = tune(TuneOptions(robot="thbip_ii", out=str(tmp_path)))
    assert (found.interrupted, found.card, found.document["tried"]) == (True, None, 0)


def test_an_unknown_preset_is_one_line(tmp_path):
    with pytest.raises(BadInput) as caught:
        tune(TuneOptions(robot="thbip_ii", preset="odd", out=str(tmp_path / "out")))
    assert caught.value.field == "--preset"
    assert not (tmp_path / "out").exists()


def test_strengths_divide_the_range_and_the_mean_counts_who_stands():
    robot = load_robot("thbip_ii")
    unit = robot.mass * np.sqrt(9.81 * robot.card.gait.height)
    walks = pushed_walks(range(6), robot, {})
    sizes = [np.hypot(*walk.pushes[0].impulse[:2]) / unit for walk in walks]
    np.testing.assert_allclose(sizes, STRONGEST * (np.arange(6) + 0.5) / 6, atol=1e-3)
    assert all(len(walk.pushes) == 1 and walk.state == "estimated" for walk in walks)
    assert withstood([STANDS, FALLS, STANDS, STANDS]) == pytest.approx(0.75 * STRONGEST)
    assert withstood([made_up_summary(pushes=(None,))]) == 0.0
    later = made_up_summary(pushed_at=3.0, fell_at=8.0)
    assert score([STANDS, FALLS]) < score([STANDS, later]) < score([STANDS, STANDS])
