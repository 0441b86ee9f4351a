"""Random walks are drawn from their seeds alone, and the interval is what its name says."""

from __future__ import annotations

import math

import pytest
from scipy.stats import binom
from tests.experiments.made_up import made_up_summary
from tests.simulation.standing import robot

from gaitsmith.experiments import random_walks
from gaitsmith.experiments.episodes import Episodes
from gaitsmith.experiments.random_walks import interval, looks, random_walk, run_walks
from gaitsmith.robots import load_robot


@pytest.mark.parametrize(("stood", "of"), [(0, 7), (7, 7), (93, 100), (9920, 10_000)])
def test_the_interval_s_ends_are_where_the_tails_are(stood, of):
    low, high = interval(stood, of)
    assert 0.0 <= low <= stood / of <= high <= 1.0
    assert low == 0.0 if stood == 0 else binom.sf(stood - 1, of, low) == pytest.approx(0.025, rel=1e-6)
    assert high == 1.0 if stood == of else binom.cdf(stood, of, high) == pytest.approx(0.025, rel=1e-6)


def test_a_seed_draws_its_walk_whatever_else_is_run_and_in_the_robot_s_size():
    assert random_walk(3, robot(), {}) == random_walk(3, robot(), {}) != random_walk(4, robot(), {})
    small = load_robot("thbip_ii")
    for one in (robot(), small):
        unit, walks = one.mass * math.sqrt(9.81 * one.card.gait.height), [random_walk(k, one, {}) for k in range(30)]
        sizes = [math.hypot(*push.impulse) / unit for walk in walks for push in walk.pushes]
        assert 0.09 < max(sizes) <= 0.0961
        assert max(walk.torque_delay for walk in walks) <= 0.0301 * math.sqrt(one.card.gait.height / 9.81)
        assert all(walk.state == "estimated" and len(walk.pushes) == 5 for walk in walks)
    assert random_walk(0, robot(), {"state": "true"}).state == "true"


def _run(monkeypatch, fallen, target, runs=80, missing=()):
    asked = []

    def run_all(scenarios, *_args, **_kwargs):
        asked.append(wanted := list(scenarios))
        done = [one for one in wanted if one.seed not in missing]
        found = {one: made_up_summary(fell_at=9.0 if one.seed in fallen else None) for one in done}
        return Episodes(found, bool(missing), 0)

    monkeypatch.setattr(random_walks, "run_all", run_all)
    walks = run_walks(
        robot(), None, fields={}, runs=runs, first=0, target=target, jobs=1, address="", progress=lambda *_: None
    )
    return walks, [len(group) for group in asked]


def test_it_stops_once_the_target_is_decided_and_each_look_takes_its_share_of_the_error(monkeypatch):
    assert looks(80, None) == [80]
    walks, asked = _run(monkeypatch, set(range(9)), 0.95)
    assert (asked, walks.stood) == ([10], 1)
    assert walks.interval == interval(1, 10, 1.0 - 0.05 / 4)
    walks, asked = _run(monkeypatch, {5}, 0.95)
    assert asked == [10, 20, 40, 80]
    walks, asked = _run(monkeypatch, {5}, None)
    assert (asked, walks.interval) == ([80], interval(79, 80))
    assert walks.document()["falls"][0]["seed"] == 5


def test_what_ctrl_c_left_is_counted_up_to_the_first_gap(monkeypatch):
    walks, _ = _run(monkeypatch, {1, 30}, None, missing={20})
    assert (len(walks.found), walks.stood, walks.interrupted) == (20, 19, True)
