"""Each episode runs once; what is finished is kept whatever comes after."""

from __future__ import annotations

import contextlib

import pytest
from tests.experiments.made_up import made_up_summary
from tests.simulation.standing import robot

from gaitsmith.errors import BadInput
from gaitsmith.experiments import episodes as module
from gaitsmith.experiments.episodes import RobotChanged, run_all
from gaitsmith.experiments.store import FILE, Store
from gaitsmith.simulation import Episode
from gaitsmith.simulation.scenario import make_scenario

SCENARIOS = [make_scenario({"duration": 3.0, "seed": seed}) for seed in range(4)]


@pytest.fixture
def ran(monkeypatch):
    """Seeds of the episodes that were really asked for; nothing is simulated."""
    seeds = []

    def fake(scenario, **_):
        seeds.append(scenario.seed)
        return Episode(made_up_summary(seed=scenario.seed), None, False)

    monkeypatch.setattr(module, "run_episode", fake)
    return seeds


def test_finished_episodes_are_not_repeated(tmp_path, ran):
    run_all(SCENARIOS[:2], robot(), Store(tmp_path))
    told = []
    done = run_all(SCENARIOS, robot(), Store(tmp_path), progress=lambda *what: told.append(what), what="walking")
    assert ran == [0, 1, 2, 3]
    assert (done.resumed, done.interrupted) == (2, False)
    assert [done.found[scenario].seed for scenario in SCENARIOS] == [0, 1, 2, 3]
    assert told == [(2, 4, "walking"), (3, 4, "walking"), (4, 4, "walking")]


def test_the_same_scenario_twice_runs_once(tmp_path, ran):
    run_all([*SCENARIOS, *SCENARIOS], robot(), Store(tmp_path))
    assert ran == [0, 1, 2, 3]


def test_stale_episodes_run_again(tmp_path, ran, monkeypatch):
    run_all(SCENARIOS[:1], robot(), Store(tmp_path))
    monkeypatch.setattr(module, "loop_identity", lambda robot: "the code was edited")
    done = run_all(SCENARIOS[:1], robot(), Store(tmp_path))
    assert (ran, done.resumed) == ([0, 0], 0)
    assert len(Store(tmp_path)) == 2


@pytest.mark.parametrize("how", ["within the loop", "outside it"])
def test_ctrl_c_keeps_what_is_finished(tmp_path, how, monkeypatch):
    def fake(scenario, **_):
        if scenario.seed == 2 and how == "outside it":
            raise KeyboardInterrupt
        return Episode(made_up_summary(seed=scenario.seed), None, scenario.seed == 2)

    monkeypatch.setattr(module, "run_episode", fake)
    store = Store(tmp_path)
    done = run_all(SCENARIOS, robot(), store)
    assert done.interrupted
    assert [scenario.seed for scenario in done.found] == [0, 1]
    assert len(Store(tmp_path)) == 2
    assert "2 of 4" in done.notes(4, store)[0]


def test_an_episode_of_changed_code_is_not_kept(tmp_path, monkeypatch):
    def source(*_):
        yield SCENARIOS[0], "another identity", made_up_summary()

    monkeypatch.setattr(module, "_here", source)
    with pytest.raises(RobotChanged, match="run again"):
        run_all(SCENARIOS[:1], robot(), Store(tmp_path))
    assert not (tmp_path / FILE).exists()


def test_a_scenario_that_does_not_fit_is_refused_before_any_runs(tmp_path, ran):
    with pytest.raises(BadInput, match="height"):
        run_all([*SCENARIOS, make_scenario({"duration": 3.0, "height": 2.0})], robot(), Store(tmp_path))
    assert ran == []


@pytest.mark.parametrize(("address", "begun"), [("", 4), ("host:1", 12)])
def test_what_is_needless_by_then_is_not_given_to_a_process(tmp_path, monkeypatch, address, begun):
    """Two processes have four episodes at hand, a cluster all of them."""
    scenarios, given, loop = [make_scenario({"seed": seed}) for seed in range(12)], [], module.loop_identity(robot())

    class Crew:
        def submit(self, key, task, scenario):
            given.append(scenario)

        def done(self):
            return "", (scenario := given[done.pop(0)], loop, made_up_summary(seed=scenario.seed))

    done = [*range(12)]
    monkeypatch.setattr(module, "workers", lambda *_: contextlib.nullcontext(Crew()))
    monkeypatch.setattr(module, "Simulation", lambda *_, **__: None)
    enough = {"jobs": 2, "address": address, "needless": lambda scenario, found: len(found) > 0}
    found = run_all(scenarios, robot(), Store(tmp_path), **enough).found
    assert len(given) == len(found) == begun


def test_no_processes_are_refused(tmp_path):
    with pytest.raises(BadInput, match="--jobs"):
        run_all(SCENARIOS, robot(), Store(tmp_path), jobs=0)


def test_other_processes_find_the_same(tmp_path):
    scenarios = [make_scenario({"duration": 1.5, "rest_before": 0.5, "seed": seed}) for seed in (0, 1)]
    there = run_all(scenarios, robot(), Store(tmp_path / "there"), jobs=2)
    here = run_all(scenarios, robot(), Store(tmp_path / "here"), jobs=1)
    varying = {"tick_us", "realtime_factor", "memory_mb"}
    for scenario in scenarios:
        assert there.found[scenario].model_dump(exclude=varying) == here.found[scenario].model_dump(exclude=varying)
