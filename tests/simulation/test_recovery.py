"""From the log of a run comes the summary that the run itself would have written."""

from __future__ import annotations

import pytest
from tests.simulation.standing import robot

from gaitsmith.errors import BadInput
from gaitsmith.log.record import Log
from gaitsmith.simulation.episode import run_episode
from gaitsmith.simulation.recovery import summary_of, survey
from gaitsmith.simulation.scenario import make_scenario

ROW = 4e-3  # s
SAMPLED = {"abs": 2e-3, "rel": 2e-3}  # a signal at every fourth tick instead of at every one


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    changes = [{"time": 1.7, "speed": 0.2}]
    pushes = [{"time": 1.0, "impulse": [1.0, 2.0, 0.0]}]
    fields = {"duration": 4.0, "rest_before": 0.5, "rest_after": 0.5, "changes": changes, "pushes": pushes}
    episode = run_episode(make_scenario(fields), robot=robot(), record=folder / "log.mcap")
    return folder / "log.mcap", episode.summary


def test_the_summary_comes_back(run):
    path, own = run
    again = summary_of(path)
    assert [(stage.rest, stage.command) for stage in again.stages] == [
        (stage.rest, stage.command) for stage in own.stages
    ]
    for mine, theirs in zip(own.stages, again.stages, strict=True):
        assert (theirs.t0, theirs.t1) == pytest.approx((mine.t0, mine.t1), abs=2 * ROW)
        assert theirs.vx_mean == pytest.approx(mine.vx_mean, abs=0.01)
        assert theirs.roll_deg == pytest.approx(mine.roll_deg, abs=0.02)
    for name in ("steps", "robot", "preset", "seed", "leg_contacts", "min_foot_separation", "pushes"):
        assert getattr(again, name) == pytest.approx(getattr(own, name)), name
    assert again.drift == pytest.approx(own.drift, **SAMPLED)
    assert again.distance == pytest.approx(own.distance, **SAMPLED)
    # What happens between two rows is not seen.
    assert all(0.5 * peak < again.torque_peak[name] <= peak for name, peak in own.torque_peak.items())
    assert again.log.rows == own.log.rows == 1000
    assert again.log.complete
    assert again.interrupted
    assert again.warnings == ()


def test_a_cut_log_is_finished(run, tmp_path):
    path, _ = run
    content = path.read_bytes()
    (tmp_path / "cut.mcap").write_bytes(content[: len(content) - 500])
    with open(tmp_path / "cut.mcap", "rb") as file, open(tmp_path / "whole.mcap", "wb", buffering=0) as copy:
        found = survey(file, "cut", copy)
    assert not found.complete
    with open(tmp_path / "whole.mcap", "rb") as file:
        again = survey(file, "whole")
    assert (again.rows, again.last_time, again.complete) == (found.rows, found.last_time, True)
    assert summary_of(tmp_path / "whole.mcap").log.rows == found.rows


def test_a_log_of_something_else_has_no_summary(tmp_path):
    Log(("time",), robot().position_low[:0].reshape(0, 1)).write(tmp_path / "other.mcap")
    with pytest.raises(BadInput, match="the log of a run of gaitsmith walk"):
        summary_of(tmp_path / "other.mcap")
