"""The replay: what it depends on, what ends it, and what it leaves behind."""

from dataclasses import replace

import numpy as np
import pytest

from gaitsmith.errors import BadInput
from gaitsmith.synthesis.proof.replay import replay

FORCES = 1e300  # N·m, more than physics can be computed with


def _with(gait, **changes):
    return replace(gait, motion=replace(gait.motion, **changes))


def _torque(gait, value):
    piece = gait.pieces[0][0]
    torque = piece.torque.copy()
    torque[3, 0] = value
    return replace(gait, pieces=((replace(piece, torque=torque), *gait.pieces[0][1:]), *gait.pieces[1:]))


def test_a_name_decides_nothing(dynamic, robot):
    plain, named = replay(dynamic.gait, robot, steps=1), replay(_with(dynamic.gait, name="kick"), robot, steps=1)
    assert named.ball is None
    assert named.as_dict() == plain.as_dict()


def test_a_ball_lies_where_the_parameters_say(dynamic, robot):
    found = replay(_with(dynamic.gait, parameters={"ball_1": 0.5, "ball_2": 1.0}), robot, steps=1)
    assert found.ball is not None
    assert found.ball["speed"] < 0.1
    with pytest.raises(BadInput, match=r"parameters\.ball_1"):
        replay(_with(dynamic.gait, parameters={"ball_1": 1e5, "ball_2": 0.0}), robot, steps=1)


def test_work_is_bounded_and_reported(dynamic, robot):
    told = []
    found = replay(dynamic.gait, robot, steps=3, report=lambda *done: told.append(done))
    assert found.stood
    assert np.isclose(told[-1][1], 3 * dynamic.gait.duration)
    assert 0.0 <= told[0][0] <= told[-1][0] < told[-1][1]
    with pytest.raises(BadInput, match="--steps"):
        replay(dynamic.gait, robot, steps=1_000_000)


def test_a_torque_that_is_not_a_number_ends_it(dynamic, robot, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    found = replay(_torque(dynamic.gait, np.nan), robot, steps=1)
    assert not found.stood
    assert found.duration < 0.01
    assert "not a number" in found.fall["reason"]
    assert list(tmp_path.iterdir()) == []
    assert capfd.readouterr() == ("", "")


def test_a_fall_leaves_no_log_file(dynamic, robot, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    wild = replace(robot, torque_limit=np.full(len(robot.joint_names), FORCES))
    found = replay(_torque(dynamic.gait, FORCES), wild, steps=1)
    assert not found.stood
    assert list(tmp_path.iterdir()) == []
    assert capfd.readouterr() == ("", "")
