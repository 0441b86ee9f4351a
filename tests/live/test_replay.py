"""A replay shows the row of its time, jumps to what happened, and says why the robot fell."""

from __future__ import annotations

import numpy as np
import pytest

from gaitsmith.errors import BadInput
from gaitsmith.live.replay import Replay
from gaitsmith.live.run import Run


@pytest.fixture(scope="module")
def replay(fallen):
    made = Replay(Run(str(fallen)), "127.0.0.1", 0)
    yield made
    made.close()


def test_time_goes_on_at_its_pace_and_stops_at_the_end(replay):
    replay.at, replay.playing = replay._begin, True
    replay._set_pace(0.5)
    replay.update(1.0)
    assert replay.at == pytest.approx(replay._begin + 0.5)
    assert replay._run.frame["live.time"] == pytest.approx(replay.at, abs=0.005)
    replay._set_pace(1.0)
    replay.update(100.0)
    assert (replay.at, replay.playing) == (replay._end, False)
    assert f"Fell at {replay._run.fall.time:.2f} s" in replay._state()
    replay.toggle()
    assert (replay.at, replay.playing) == (replay._begin, True)


def test_it_jumps_to_the_push_and_the_fall_and_back(replay):
    replay.at, replay.playing = replay._begin, False
    replay.jump(1)
    assert replay.at == pytest.approx(1.5, abs=0.01)
    replay.jump(1)
    assert replay.at == pytest.approx(replay._end - 0.5, abs=0.01)
    replay.jump(-1)
    assert replay.at == pytest.approx(1.5, abs=0.01)


def test_charts_show_the_seconds_up_to_now_whatever_came_before(replay):
    replay.playing = False
    for at in (2.5, 1.0, 2.0):
        replay.at = at
        replay.update(0.0)
        rows = replay._history.rows
        assert rows[-1, 0] == pytest.approx(at, abs=0.03)
        assert np.all(np.diff(rows[:, 0]) > 0.0)


def test_the_push_is_seen_while_it_acts(replay):
    replay.at, replay.playing = 2.05, False
    replay.update(0.0)
    np.testing.assert_allclose(replay._run.frame.push, (0.0, 900.0, 0.0), rtol=0.03, atol=30.0)
    assert replay._scene._push.visible


def test_what_is_no_whole_run_is_one_clear_error_or_shown_with_a_note(fallen, tmp_path):
    content = (fallen / "log.mcap").read_bytes()
    with pytest.raises(BadInput):
        Run(str(tmp_path))
    (tmp_path / "scenario.toml").write_bytes((fallen / "scenario.toml").read_bytes())
    (tmp_path / "log.mcap").write_bytes(content[:500])
    with pytest.raises(BadInput):
        Run(str(tmp_path))
    (tmp_path / "log.mcap").write_bytes(content[:-20])
    assert any("cut" in note for note in Run(str(tmp_path)).notes)
