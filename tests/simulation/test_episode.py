"""Whole runs: the same bits twice, a log that survives interruption, falls that are explained."""

from __future__ import annotations

import json
from functools import cache

import numpy as np
import pytest
from tests.simulation.standing import robot

from gaitsmith.errors import BadInput
from gaitsmith.log.record import read_log
from gaitsmith.simulation.episode import Episode, Simulation, run_episode
from gaitsmith.simulation.scenario import make_scenario

PUSHED = {"duration": 3.0, "rest_before": 0.3, "terrain": "boxes:0.03", "seed": 2, "speed": 0.2}


def _run(record: bool = True, **fields) -> Episode:
    return run_episode(make_scenario(fields), robot=robot(), record=record)


@cache
def _short() -> Episode:
    changes = [{"time": 1.7, "speed": 0.2}]
    return _run(duration=3.5, rest_before=0.5, rest_after=0.5, changes=changes)


def test_a_short_walk_is_summed_up():
    summary = _short().summary
    assert not summary.fell
    assert summary.steps >= 4
    assert [(stage.t0, stage.t1, stage.rest) for stage in summary.stages] == [
        (0.0, 0.5, True),
        (0.5, 1.7, False),
        (1.7, 3.0, False),
        (3.0, 3.5, True),
    ]
    assert [stage.command.vx for stage in summary.stages] == [0.0, 0.0, 0.2, 0.0]
    assert set(summary.torque_peak) == set(robot().joint_names)
    assert summary.qp.solves > 0
    assert summary.realtime_factor > 0
    json.dumps(summary.model_dump(mode="json"), allow_nan=False)


def test_the_contract_s_fields_are_there():
    document = _short().summary.model_dump(mode="json")
    wanted = "fell fall duration steps stages drift min_foot_separation leg_contacts torque_peak torque_saturated qp"
    assert set(f"{wanted} tick_us realtime_factor".split()) <= set(document)
    stage = "t0 t1 command vx_mean vx_error vy_mean vy_error height_mean height_error roll_deg pitch_deg"
    assert set(stage.split()) <= set(document["stages"][0])
    assert set(document["qp"]) == {"solves", "fallbacks", "infeasible"}
    assert set(document["tick_us"]) == {"median", "p99", "max", "overruns"}
    assert len(document["stages"][0]["roll_deg"]) == 2


def test_log_and_summary_agree(tmp_path):
    episode = _short()
    assert episode.log is not None
    stage = episode.summary.stages[2]
    within = (episode.log.time >= stage.scored[0]) & (episode.log.time < stage.scored[1])
    # The log has every fourth tick of the signal that the summary averages.
    assert np.mean(episode.log.column("true.com_velocity_x")[within]) == pytest.approx(stage.vx_mean, abs=2e-3)
    episode.log.write(tmp_path / "run.mcap")
    np.testing.assert_array_equal(read_log(tmp_path / "run.mcap").rows, episode.log.rows)


def test_the_same_seed_gives_the_same_run_bit_for_bit():
    first, second = _run(**PUSHED), _run(**PUSHED)
    np.testing.assert_array_equal(first.log.rows, second.log.rows)
    clock = {"tick_us", "realtime_factor", "memory_mb"}
    assert first.summary.model_dump(exclude=clock) == second.summary.model_dump(exclude=clock)


def test_a_reused_controller_gives_the_same_run():
    simulation = Simulation(make_scenario(PUSHED), robot=robot())
    first = simulation.run()
    again = run_episode(make_scenario(PUSHED), robot=robot(), controller=simulation.controller)
    np.testing.assert_array_equal(first.log.rows, again.log.rows)


def test_a_hard_push_ends_in_a_fall_that_is_explained():
    summary = _run(duration=6.0, pushes=[{"time": 2.0, "impulse": [0.0, 150.0, 0.0]}]).summary
    assert summary.fell
    assert 2.0 < summary.fall.time == summary.duration < 4.0
    assert "first limit hit: " in summary.fall.reason
    assert "stance" in summary.fall.phase
    assert summary.fall.phase.endswith("% of the step, then braked")
    assert summary.pushes == (2.0,)


def test_a_phased_push_starts_at_the_measured_phase():
    simulation = Simulation(
        make_scenario({"duration": 4.0, "pushes": [{"time": 2.5, "impulse": [2, 0, 0], "phase": 0.5}]}), robot=robot()
    )
    episode = simulation.run()
    began = episode.summary.pushes[0]
    assert 2.5 <= began <= 3.5
    row = np.searchsorted(episode.log.time, began)
    stances = episode.log.column("stance")[row - 2 : row + 2]
    assert stances[0] == 0.0
    assert stances[-1] == 1.0


def test_ctrl_c_keeps_the_log_so_far_whole(tmp_path):
    def interrupt(time: float) -> None:
        if time >= 1.0:
            raise KeyboardInterrupt

    episode = run_episode(make_scenario({"duration": 5.0}), robot=robot(), progress=interrupt)
    assert episode.interrupted
    assert episode.summary.interrupted
    assert episode.summary.duration == pytest.approx(1.0)
    episode.log.write(tmp_path / "run.mcap")
    log = read_log(tmp_path / "run.mcap")
    assert len(log.rows) == 250
    assert np.all(np.isfinite(log.rows))


def test_stepping_by_hand_equals_running():
    scenario = make_scenario({"duration": 1.5, "rest_before": 0.2})
    stepped, ran = Simulation(scenario, robot=robot()), Simulation(scenario, robot=robot())
    ran.run()
    while stepped.step():
        pass
    assert not stepped.step()
    np.testing.assert_array_equal(stepped.plant.q, ran.plant.q)


def test_a_divergence_is_a_fall_with_a_name():
    simulation = Simulation(make_scenario({"duration": 1.0}), robot=robot())
    for _ in range(50):
        simulation.step()
    simulation.plant.v[0] = np.nan
    episode = simulation.run()
    assert episode.summary.fell
    assert "simulation diverged" in episode.summary.fall.reason
    json.dumps(episode.summary.model_dump(mode="json"), allow_nan=False)


@pytest.mark.parametrize(
    ("fields", "told"),
    [
        ({"height": 0.9}, "height: got 0.9, expected"),
        ({"preset": "best"}, "preset: got 'best'"),
        ({"pushes": [{"time": 1.0, "impulse": [1, 0, 0], "body": "head"}]}, "pushes[0].body: got 'head'"),
        ({"pushes": [{"time": 1.0, "impulse": [1, 0, 0], "joint": "nose"}]}, "pushes[0].joint: got 'nose'"),
        ({"changes": [{"time": 2.0, "period": 0.01}]}, "changes[0].period: got 0.01"),
    ],
)
def test_what_does_not_fit_the_robot_is_refused(fields, told):
    with pytest.raises(BadInput) as caught:
        Simulation(make_scenario(fields), robot=robot())
    assert told in str(caught.value)


def test_drift_and_distance_count_from_where_the_walk_begins():
    simulation = Simulation(make_scenario({"duration": 2.0, "rest_before": 0.5, "speed": 0.2}), robot=robot())
    simulation.plant.v[0] = 0.05  # it sways before it walks
    places = []
    while simulation.step():
        places.append(simulation.plant.truth.torso[:2].copy())
    began = places[499]
    away = np.hypot(*(np.array(places[499:]) - began).T)
    summary = simulation.summary()
    assert np.hypot(*began) > 1e-3
    assert summary.drift == pytest.approx(away.max(), abs=1e-3)
    assert summary.distance == pytest.approx(away[-2], abs=1e-3)
