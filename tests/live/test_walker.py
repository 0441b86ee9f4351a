"""The loop does what is wished for within its ranges, and nothing that is not; whatever comes, the walk goes on."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from tests.live.bench import Bench

from gaitsmith.live.recording import finish_folder
from gaitsmith.live.run import Run
from gaitsmith.live.timeline import drawn, timeline_of
from gaitsmith.live.wishes import WIDTH, Kind, understood

NAN = math.nan


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    made = Bench(tmp_path_factory.mktemp("runs"), speed=[0.2, 0.0])
    yield made
    made.close()


@pytest.fixture(autouse=True)
def begun_anew(bench):
    bench.wish(Kind.PAUSE, 0.0)
    bench.wish(Kind.RESET)
    bench.ticks(1)
    assert bench.walker.simulation.tick == 1


def gait(bench, **changed):
    told = {"speed_x": 0.2, "speed_y": 0.0, "period": 0.4, "alpha": 0.5, "height": 0.7, "lift": 0.1, "width": 0.0375}
    bench.wish(Kind.GAIT, *(told | {"yaw_rate": 0.0} | changed).values())


def test_it_stands_then_walks_and_what_is_seen_is_what_is(bench):
    bench.ticks(2500)
    frame, plant = bench.seen(), bench.walker.simulation.plant
    np.testing.assert_array_equal(frame.q, plant.q)
    np.testing.assert_array_equal(frame.com, plant.com)
    assert frame["live.time"] == pytest.approx(plant.time)
    assert frame["mode"] == 1.0
    assert frame["true.torso_x"] > 0.1
    assert frame.contacts[:, 5].sum() > 100.0


def test_a_gait_within_the_limits_is_walked_and_observers_hear_of_it_once(bench):
    heard = []
    bench.walker.simulation.watch(
        type("Ear", (), {"observe": lambda s, t: False, "hear": lambda s, e: heard.append(e)})()
    )
    bench.ticks(1200)
    for speed in np.linspace(0.2, 0.5, 30):  # as a slider is dragged
        gait(bench, speed_x=float(speed))
        bench.ticks(10)
    bench.ticks(1500)
    assert bench.seen()["command.speed_x"] == 0.5
    told = [event["command"]["speed"] for event in heard if "command" in event]
    assert told == [(0.5, 0.0)]


@pytest.mark.parametrize(
    "row",
    [
        (NAN,) * WIDTH,
        (0.0, NAN, *(0.0,) * 8),
        (0.0, 99.0, *(0.0,) * 8),
        (0.0, 0.2, 0.0, -0.4, 0.5, 0.7, 0.1, 0.0375, 0.0, 0.0),
        (77.0, *(0.0,) * 9),
        (0.5, *(0.0,) * 9),
        (float(Kind.PUSH), math.inf, *(0.0,) * 8),
        (float(Kind.TERRAIN), 9.0, *(0.0,) * 8),
        (float(Kind.TERRAIN), 2.0, 5.0, *(0.0,) * 7),
    ],
)
def test_nonsense_is_counted_and_changes_nothing(bench, row):
    bench.ticks(1100)
    before, refused, episode = bench.walker.simulation.controller.gait, bench.walker._refused, bench.walker._episode
    bench.wishes.write(row)
    assert bench.ticks(50) == 50
    assert bench.walker.simulation.controller.gait == before
    assert (bench.walker._refused, bench.walker._episode) == (refused + 1, episode)
    assert understood(row) is None or row[0] in (0.0, float(Kind.TERRAIN))


def test_more_wishes_than_the_ring_holds_do_not_stop_it(bench):
    for _ in range(10_000):
        bench.wishes.write(np.random.default_rng(0).normal(size=WIDTH) * 1e9)
    assert bench.ticks(20) == 20


def test_time_stands_still_while_paused_and_goes_on_by_single_ticks(bench):
    bench.ticks(100)
    bench.wish(Kind.PAUSE, 1.0)
    assert bench.ticks(50) == 0
    bench.wish(Kind.STEP, 3.0)
    assert bench.ticks(50) == 3
    assert bench.seen()["live.paused"] == 1.0
    bench.wish(Kind.PAUSE, 0.0)
    assert bench.ticks(50) == 50


def test_a_push_acts_for_a_tenth_of_a_second_along_the_heading_and_is_survived(bench):
    bench.ticks(2000)
    bench.wish(Kind.PUSH, 8.0, 0.0, 0.0)
    bench.ticks(50)
    np.testing.assert_allclose(bench.seen().push, (80.0, 0.0, 0.0), atol=2.0)
    bench.ticks(60)
    assert not bench.seen().push.any()
    bench.ticks(1500)
    assert not bench.seen()["live.over"]


def test_a_pull_ends_by_itself_if_nobody_renews_it(bench):
    bench.ticks(500)
    bench.wish(Kind.HOLD, 5.0, 0.0, 0.0)
    bench.ticks(250)
    assert bench.seen().push[0] == 5.0
    bench.ticks(100)
    assert not bench.seen().push.any()


def test_a_fall_is_told_its_recording_is_a_run_and_reset_begins_anew(bench):
    bench.ticks(1500)
    bench.wish(Kind.RECORD, 1.0)
    bench.ticks(1000)
    bench.wish(Kind.PUSH, 0.0, 90.0, 0.0)
    bench.ticks(4000)
    frame = bench.seen()
    words, _ = bench.walker.note.read(0)
    assert frame["live.over"]
    assert not frame["live.recording"]
    assert words["fall"]["reason"]
    assert words["trouble"] == ""
    refused = bench.walker._refused
    bench.wish(Kind.PUSH, 1.0, 0.0, 0.0)
    assert bench.ticks(10) == 0
    assert bench.walker._refused == refused + 1

    folder = Path(words["recorded"])
    assert finish_folder(folder) == ""
    run = Run(str(folder))
    assert run.log.complete
    assert run.log.time[0] < 0.01
    assert run.notes == ()
    assert run.fall is not None
    assert run.fall.time == pytest.approx(run.log.time[-1], abs=0.01)
    timeline = timeline_of(run)
    assert len(timeline.touchdowns) >= 2
    assert timeline.fall == pytest.approx(run.fall.time, abs=0.005)
    assert [push.words for push in timeline.pushes] == ["push 90 N·s"]
    assert timeline.pushes[0].begin == pytest.approx(1.0, abs=0.01)
    assert drawn(timeline, 0.0, run.log.time[-1], ("a", "b", "c")).count("<title>") == 1 + len(timeline.limits)
    bench.wish(Kind.RESET)
    assert bench.ticks(100) == 100
    assert bench.walker.note.read(0)[0]["recorded"] == str(folder)


def test_a_frame_of_a_recorded_run_is_the_robot_as_it_was(bench):
    bench.wish(Kind.RECORD, 1.0)
    bench.ticks(2003)  # a tick whose row is kept comes next
    q, com = bench.walker.simulation.plant.q.copy(), bench.walker.simulation.plant.com.copy()
    bench.ticks(1)
    bench.wish(Kind.RECORD, 0.0)
    bench.ticks(1)
    run = Run(str(bench.walker._recording.done))
    assert run.fall is None
    assert run.scenario.duration == pytest.approx(2.004)
    frame = run.show(len(run.log.rows) - 1)
    np.testing.assert_allclose(frame.q, q, atol=1e-9)
    np.testing.assert_allclose(frame.com, com, atol=1e-9)
    assert frame.contacts[:, 5].sum() > 100.0


def test_another_ground_begins_anew_and_keeps_the_gait(bench):
    gait(bench, speed_x=0.1)
    bench.ticks(10)
    bench.wish(Kind.TERRAIN, 2.0, 0.02, 3.0)
    bench.ticks(2)
    words = bench.seen() and bench.walker.note.read(0)[0]
    assert (words["terrain"], words["seed"]) == ("boxes:0.02", 3)
    assert bench.walker.simulation.tick == 2
    assert bench.walker.simulation.controller.gait.speed == (0.1, 0.0)
    bench.wish(Kind.TERRAIN, 0.0)
    bench.ticks(1)
