"""The verifier finds what is wrong: torques, wrenches, joints and places that physics does not confirm."""

from dataclasses import replace

import numpy as np
import pytest

from gaitsmith.synthesis import verify
from gaitsmith.synthesis.motions.motion import At

SPARSE = 40  # instants a phase: enough to see a lie


def _changed(gait, phase, **changes):
    piece = gait.pieces[phase][0]
    group = (replace(piece, **{k: v(getattr(piece, k).copy()) for k, v in changes.items()}), *gait.pieces[phase][1:])
    return replace(gait, pieces=(*gait.pieces[:phase], group, *gait.pieces[phase + 1 :]))


def _add(row, amount):
    def change(table):
        table[row, 0] += amount
        return table

    return change


@pytest.mark.parametrize(
    ("phase", "changes", "problem"),
    [
        (0, {"torque": _add(3, 0.01)}, "dynamics residual"),
        (1, {"wrench": _add(8, 0.1)}, "dynamics residual"),
        (3, {"joints": _add(8, 1e-3)}, "closure"),
        (0, {"joints": _add(3, -1e-3)}, "where phases or sections meet"),
    ],
)
def test_lies_are_found(dynamic, robot, phase, changes, problem):
    verdict = verify(_changed(dynamic.gait, phase, **changes), robot, SPARSE)
    assert not verdict.ok
    assert any(problem in text for text in verdict.problems), verdict.problems


def test_a_footprint_moved_is_found(dynamic, robot):
    motion = dynamic.gait.motion
    phases = list(motion.phases)
    phases[2] = replace(phases[2], other=(phases[2].other[0] + 0.001, phases[2].other[1]))
    verdict = verify(replace(dynamic.gait, motion=replace(motion, phases=tuple(phases))), robot, SPARSE)
    assert any("closure" in text for text in verdict.problems)


def test_a_foot_in_the_ground_is_found(dynamic, robot):
    knee = robot.legs[0].knee  # of the left leg, which swings
    verdict = verify(_changed(dynamic.gait, 1, joints=_add(knee, -0.02)), robot, SPARSE)
    assert any(text.startswith("penetration") for text in verdict.problems), verdict.problems


def test_a_support_foot_that_jumps_takes_the_base_along(dynamic, robot):
    motion = dynamic.gait.motion
    phases = list(motion.phases)
    x, y = phases[1].foothold
    phases[1] = replace(phases[1], foothold=(x + 1e-5, y))
    verdict = verify(replace(dynamic.gait, motion=replace(motion, phases=tuple(phases))), robot, SPARSE)
    assert abs(verdict.seam["position_m"] - 1e-5) < 1e-6
    assert any(text.startswith("jump of position_m") for text in verdict.problems), verdict.problems


def test_a_condition_that_does_not_hold_is_found(dynamic, robot):
    motion = replace(dynamic.gait.motion, conditions=(At(1, "ankle_z", 0.2),))
    verdict = verify(replace(dynamic.gait, motion=motion), robot, SPARSE)
    assert any("ankle_z" in text for text in verdict.problems)


def test_tighter_bounds_fail(dynamic, robot):
    gait = replace(dynamic.gait, bounds=dynamic.gait.bounds | {"torque": 0.1})
    assert any("torque" in text for text in verify(gait, robot, SPARSE).problems)


def _worst(gait, change):
    return replace(gait, certificate=gait.certificate | {"worst": change(gait.certificate["worst"])})


@pytest.mark.parametrize(
    "change",
    [
        lambda worst: [],
        lambda worst: 3,
        lambda worst: [*worst, {"constraint": 1}],
        lambda worst: [item | {"violation": None} for item in worst],
        lambda worst: worst[1:],
        lambda worst: [item | {"violation": item["violation"] - 0.02} for item in worst],
    ],
)
def test_a_certificate_that_does_not_match_is_found(dynamic, robot, change):
    verdict = verify(_worst(dynamic.gait, change), robot, SPARSE)
    assert any("certificate" in text for text in verdict.problems), verdict.problems


def test_a_certificate_that_matches_is_no_problem(dynamic, robot):
    verdict = verify(dynamic.gait, robot, SPARSE)
    assert verdict.ok, verdict.problems
    assert verdict.as_dict()["bounds"] == dynamic.gait.bounds


@pytest.mark.parametrize("key", ["joints", "torque", "wrench"])
def test_what_is_not_a_number_is_a_problem(dynamic, robot, key):
    verdict = verify(_changed(dynamic.gait, 2, **{key: _add(2, np.nan)}), robot, SPARSE)
    assert any("nan" in text for text in verdict.problems), verdict.problems


@pytest.mark.filterwarnings("error")
def test_ground_that_bears_nothing_is_a_problem(dynamic, robot):
    verdict = verify(_changed(dynamic.gait, 0, wrench=lambda table: 0.0 * table), robot, SPARSE)
    assert any("ZMP margin: not a number" in text for text in verdict.problems)
