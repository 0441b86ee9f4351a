"""A gait file with one thing changed is never accepted, whatever it is."""

from __future__ import annotations

import json

import numpy as np
import pytest
from benchmarks.corruptions import KINDS, _checksum, accepted, corrupted

from gaitsmith.robots import load_robot
from gaitsmith.synthesis import Planner, Request, StepParameters, answer
from gaitsmith.synthesis.files.gait_file import gait_document

EACH = 3  # changes of every kind; benchmarks/corruptions.py makes a thousand


@pytest.fixture(scope="module")
def planned():
    robot = load_robot("thbip_ii")
    gait = answer(Planner(robot), Request("cyclic", StepParameters(0.20, 0.5))).gait
    assert gait is not None
    return json.loads(json.dumps(gait_document(gait))), robot


def test_the_file_itself_is_accepted(planned):
    assert accepted(*planned)


@pytest.mark.parametrize("kind", sorted(set(KINDS), key=lambda kind: kind.__name__))
def test_no_corrupted_file_is_accepted(planned, kind):
    document, robot = planned
    rng = np.random.default_rng(7)
    for _ in range(EACH):
        changed = json.loads(json.dumps(document))
        what = kind(changed, rng)
        changed["checksum"] = _checksum(changed)
        assert not accepted(changed, robot), what


def test_the_same_seed_makes_the_same_files(planned):
    one, two = (corrupted(planned[0], np.random.default_rng(3)) for _ in range(2))
    assert one == two
    assert one[1]["checksum"] == _checksum(one[1]) != planned[0]["checksum"]
