"""Exported rows: columns in order, rates kept, velocities and accelerations those of the positions."""

import csv
from dataclasses import replace

import numpy as np
import pytest

from gaitsmith.errors import BadInput
from gaitsmith.log.record import read_log
from gaitsmith.synthesis.files.export import LARGEST, column_names, export_gait, gait_rows

RATE = 2000.0


@pytest.fixture(scope="module")
def rows(dynamic, robot):
    return gait_rows(dynamic.gait, robot, RATE, steps=2)


def test_columns(rows, robot):
    names = column_names(robot.joint_names)
    assert rows.shape == (2001, len(names))
    assert len(names) == 1 + 7 + 12 + 18 + 18 + 12 + 12
    assert names[:8] == [
        "time [s]",
        *[f"base_position_{a} [m]" for a in "xyz"],
        *[f"base_quaternion_{a} [-]" for a in "wxyz"],
    ]
    assert names[-12] == "left_contact_force_x [N]"


def test_velocities_and_accelerations_are_derivatives(rows):
    q, v, a = rows[:, 8:20], rows[:, 26:38], rows[:, 44:56]
    h = 1.0 / RATE
    assert np.abs((q[2:] - q[:-2]) / (2 * h) - v[1:-1]).max() < 1e-2
    # The third derivative jumps at the knots, so a few differences there are off.
    assert np.quantile(np.abs((v[2:] - v[:-2]) / (2 * h) - a[1:-1]), 0.97) < 1.0
    base, speed = rows[:, 1:4], rows[:, 20:23]
    assert np.abs((base[2:] - base[:-2]) / (2 * h) - speed[1:-1]).max() < 1e-3


def test_weight_is_borne(rows, planner):
    vertical = rows[:, -10] + rows[:, -4]
    assert abs(vertical.mean() - planner.biped.weight) < 0.02 * planner.biped.weight


def test_files(dynamic, robot, tmp_path):
    assert export_gait(dynamic.gait, robot, tmp_path / "a.csv", "csv", 100.0) == 51
    with (tmp_path / "a.csv").open() as file:
        table = list(csv.reader(file))
    assert table[0] == column_names(robot.joint_names)
    named = replace(robot, joint_names=('a,"b"', *robot.joint_names[1:]))
    export_gait(dynamic.gait, named, tmp_path / "b.csv", "csv", 100.0)
    with (tmp_path / "b.csv").open() as file:
        assert next(csv.reader(file)) == column_names(named.joint_names)
    assert len(table) == 52
    export_gait(dynamic.gait, robot, tmp_path / "a.mcap", "mcap", 100.0)
    assert np.allclose(read_log(tmp_path / "a.mcap").rows, np.array(table[1:], dtype=float))


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan"), float("inf"), 1e9])
def test_rates_that_cannot_be_used(dynamic, robot, rate):
    with pytest.raises(BadInput, match="rate"):
        gait_rows(dynamic.gait, robot, rate)


def test_work_is_bounded(dynamic, robot, tmp_path):
    columns = len(column_names(robot.joint_names))
    with pytest.raises(BadInput, match=f"rate.*{LARGEST // columns} rows"):
        export_gait(dynamic.gait, robot, tmp_path / "a.csv", "csv", 1000.0, steps=1000)
    with pytest.raises(BadInput, match=r"steps.*7200"):
        export_gait(dynamic.gait, robot, tmp_path / "a.csv", "csv", 1.0, steps=7201)
    assert list(tmp_path.iterdir()) == []


def test_progress_is_reported(dynamic, robot, tmp_path):
    told = []
    count = export_gait(dynamic.gait, robot, tmp_path / "a.csv", "csv", 1000.0, 10, lambda *done: told.append(done))
    assert told[-1] == (count, count)
    assert len(told) > 1
