"""Gait files: whole, versioned, for one robot; anything else is refused in one line."""

import contextlib
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitsmith.errors import BadInput
from gaitsmith.robots import load_robot
from gaitsmith.synthesis.gait_file import gait_document, load_robot_of, read_gait, require_robot, write_gait


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
