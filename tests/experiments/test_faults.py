"""The fault matrix goes on where it stopped, says what was survived and how, and refuses what no robot has."""

from __future__ import annotations

import json

import pytest

from gaitsmith.errors import BadInput
from gaitsmith.experiments import FallOptions, FaultOptions, run_falls, run_faults
from gaitsmith.experiments.falls import KNOWN
from gaitsmith.experiments.store import Lines


def test_a_small_matrix_and_the_same_again(tmp_path):
    options = FaultOptions(component=("left.force",), type=("nan",), duration=(0.05,), instants=2, out=str(tmp_path))
    result = run_faults(options)
    (entry,) = json.loads((tmp_path / "faults.json").read_text())["faults"]
    assert entry | {"falls": []} == {
        "component": "left.force",
        "type": "nan",
        "duration": 0.05,
        "survived": 2,
        "of": 2,
        "braked": 0,
        "reaction": "replaced by kinematics and the step's clock",
        "falls": [],
    }
    assert result.rows == (("left.force", "nan", "2 of 2", entry["reaction"]),)
    assert "2 of 2 episodes found" in " ".join(run_faults(options).notes)


def test_a_fault_that_ends_braked_is_no_fall_without_warning(tmp_path):
    options = FaultOptions(component=("ticks",), type=("dead",), duration=(1.0,), instants=1, out=str(tmp_path))
    result = run_faults(options)
    (entry,) = result.document["faults"]
    assert (entry["survived"], entry["braked"], entry["falls"][0]["braked"]) == (0, 1, True)
    assert result.notes[0] == "1000 ms: 0 of 1 stood, 1 ended braked, 0 fell without"


@pytest.mark.parametrize(
    ("fields", "flag"),
    [({"component": ("nose",)}, "--component"), ({"component": ("gyro",), "type": ("odd",)}, "--type")],
)
def test_what_cannot_fail_is_one_line(tmp_path, fields, flag):
    with pytest.raises(BadInput) as caught:
        run_faults(FaultOptions(out=str(tmp_path), **fields))
    assert caught.value.field == flag


def test_a_fall_of_known_cause_is_named_confirmed_and_kept(tmp_path):
    options = FallOptions(falls=1, kind=("motor",), out=str(tmp_path))
    result = run_falls(options)
    (entry,) = result.document["falls"]
    assert (entry["kind"], entry["named"], entry["confirmed"]) == ("motor", "fault", True)
    kept = (tmp_path / "falls.jsonl").read_text()
    assert run_falls(options).document == result.document
    assert (tmp_path / "falls.jsonl").read_text() == kept
    with pytest.raises(BadInput, match="one of " + ", ".join(KNOWN)):
        run_falls(FallOptions(kind=("moon",), out=str(tmp_path)))


@pytest.mark.parametrize("kind", ["torque_limit", "swing_lag", "noise", "speed_limit"])
def test_what_lies_in_the_robot_is_named_too(tmp_path, kind):
    """Weak motors, a leg that follows softly, loud sensors, joints that are slow: not the walk that shows it."""
    (entry,) = run_falls(FallOptions(falls=1, kind=(kind,), out=str(tmp_path))).document["falls"]
    assert (entry["right"], entry["confirmed"]) == (True, True)


def test_lines_that_are_damaged_are_passed_over(tmp_path):
    Lines(tmp_path, "x.jsonl").keep("a", {"b": 1})
    with open(tmp_path / "x.jsonl", "ab") as file:
        file.write(b'{"key": "c", "va')
    again = Lines(tmp_path, "x.jsonl")
    assert ("a" in again, again["a"], "c" in again, again.damaged) == (True, {"b": 1}, False, 1)
