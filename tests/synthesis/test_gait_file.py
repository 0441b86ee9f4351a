"""Gait files: whole, versioned, for one robot; anything else is refused in one line."""

import contextlib
import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitsmith.errors import BadInput
from gaitsmith.robots import load_robot
from gaitsmith.synthesis.files.gait_entries import LONGEST_PHASE
from gaitsmith.synthesis.files.gait_file import (
    _checksum,
    gait_document,
    load_robot_of,
    read_gait,
    require_robot,
    write_gait,
)


@pytest.fixture(scope="module")
def path(dynamic, tmp_path_factory):
    found = tmp_path_factory.mktemp("gait") / "gait.json"
    write_gait(found, dynamic.gait)
    return found


def test_what_is_written_is_read(path, dynamic):
    gait, intact = read_gait(path)
    assert intact
    assert gait_document(gait) == gait_document(dynamic.gait)
    times = np.linspace(0.0, gait.motion.phases[0].duration, 7)
    for one, two in zip(gait.joints(0, times), dynamic.gait.joints(0, times), strict=True):
        assert np.array_equal(one, two)


def test_a_truncated_file_is_refused(path, tmp_path):
    bad = tmp_path / "bad.json"
    bad.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(BadInput, match="whole gait file"):
        read_gait(bad)


def test_an_edited_file_is_refused_or_marked(path, tmp_path):
    document = json.loads(path.read_text())
    document["phases"][0]["sections"][0]["torque"][3][0] += 1.0
    bad = tmp_path / "bad.json"
    bad.write_text(json.dumps(document))
    with pytest.raises(BadInput, match="edited"):
        read_gait(bad)
    assert read_gait(bad, allow_edited=True)[1] is False


@pytest.mark.parametrize(
    "text", ["{}", "[]", "1", '{"format": "other"}', '{"format": "gaitsmith-gait", "version": 9}', ""]
)
def test_foreign_files_are_refused(tmp_path, text):
    bad = tmp_path / "bad.json"
    bad.write_text(text)
    with pytest.raises(BadInput):
        read_gait(bad)


def test_numbers_that_are_not_finite_are_refused(path, tmp_path):
    bad = tmp_path / "bad.json"
    bad.write_text(path.read_text().replace('"duration":', '"duration":NaN,"x":', 1))
    with pytest.raises(BadInput):
        read_gait(bad, allow_edited=True)


def test_a_file_beyond_the_limit_is_refused(tmp_path):
    bad = tmp_path / "bad.json"
    with bad.open("wb") as file:
        file.truncate(50_000_001)
    with pytest.raises(BadInput, match="50000000"):
        read_gait(bad)


def test_another_robot_is_refused(dynamic):
    with pytest.raises(BadInput, match="robot"):
        require_robot(dynamic.gait, load_robot("bhr_b2"))
    with pytest.raises(BadInput, match="robot"):
        load_robot_of(dynamic.gait, "bhr_b2")


PIECE = ("phases", 0, "sections", 0)
HUGE = 10**400
LOST = object()


@pytest.mark.parametrize(
    ("place", "value", "words"),
    [
        (("phases", 0, "duration"), HUGE, r"phases\[0\].duration.* 60"),
        (("phases", 0, "duration"), LONGEST_PHASE + 1.0, r"phases\[0\].duration"),
        (("phases", 0, "support"), LOST, r"phases\[0\].support: got nothing"),
        (("phases", 0, "name"), 3, "printable"),
        (("phases", 4, "support"), "right", r"phases\[4\]"),
        (("phases", 2, "other_foothold"), None, "other sole stands"),
        (("phases", 0, "limits"), [{"quantity": "toe_x", "low": 2, "high": 1}], "not above the upper"),
        ((*PIECE, "start"), 0.01, "where the section before ends"),
        ((*PIECE, "duration"), 0.01, r"sections.*the phase's duration|where the section before ends"),
        ((*PIECE, "joints", 2, 1), HUGE, "finite"),
        ((*PIECE, "joints", 2, 1), True, r"joints\[2\]\[1\].*a finite number"),
        ((*PIECE, "torque", 2, 1), "1", r"torque\[2\]\[1\].*a finite number"),
        ((*PIECE, "wrench"), [[1.0]], "list of 12 rows"),
        ((*PIECE, "joints", 2), [0.0] * 201, "1 to 200"),
        ((*PIECE, "joints", 2, 3), 1.7e308, "angle.*1000 rad"),
        ((*PIECE, "torque", 2, 0), 1.7e308, "torque.*100000"),
        (("conditions", 0, "quantity"), "foo", "one of ankle_x"),
        (("conditions", 0, "border"), 1.5, "whole number"),
        (("order",), 4.5, "one of 4, 5"),
        (("version",), True, "version"),
        (("motion",), None, "motion"),
        (("cyclic",), "x", "true or false"),
        (("bounds", "friction"), LOST, "bounds.friction"),
        (("bounds", "friction"), 99.0, "bounds.friction.*5"),
        (("bounds", "other"), 1.0, "bounds.other"),
        (("parameters", "length"), HUGE, "parameters.length"),
        (("solver",), [], "solver"),
    ],
)
def test_every_entry_is_checked(dynamic, tmp_path, place, value, words):
    document = json.loads(json.dumps(gait_document(dynamic.gait)))
    *path, last = place
    target = document
    for key in path:
        target = target[key]
    if value is LOST:
        del target[last]
    else:
        target[last] = value
    document["checksum"] = _checksum(document)
    bad = tmp_path / "bad.json"
    bad.write_text(json.dumps(document))
    with pytest.raises(BadInput, match=words):
        read_gait(bad)


def test_a_key_given_twice_is_refused(path, tmp_path):
    bad = tmp_path / "bad.json"
    bad.write_text(path.read_text().replace('"order":', '"order":5,"order":', 1))
    with pytest.raises(BadInput, match="'order' twice"):
        read_gait(bad)


def test_joints_in_another_order_are_named(dynamic, robot):
    names = dynamic.gait.joint_names
    with pytest.raises(BadInput, match=rf"joints\[0\].*{names[1]}.*{names[0]}"):
        require_robot(replace(dynamic.gait, joint_names=(names[1], names[0], *names[2:])), robot)


@given(st.integers(0, 10**9))
def test_damaged_files_never_raise_anything_else(path, tmp_path_factory, seed):
    rng = np.random.default_rng(seed)
    content = bytearray(path.read_bytes())
    for place in rng.integers(0, len(content), 3):
        content[place] = rng.integers(32, 127)
    bad = tmp_path_factory.getbasetemp() / "damaged.json"
    bad.write_bytes(bytes(content))
    with contextlib.suppress(BadInput):
        read_gait(bad, allow_edited=True)
