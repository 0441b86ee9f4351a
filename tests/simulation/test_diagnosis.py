"""The likeliest cause of a fall is what came from outside, the latest first; a replay without it confirms it."""

from __future__ import annotations

import pytest

from gaitsmith.robots import load_robot
from gaitsmith.simulation import Scenario
from gaitsmith.simulation.diagnosis import suspects
from gaitsmith.simulation.disturbances import Push
from gaitsmith.simulation.limits import MISTAKEN
from gaitsmith.simulation.reactions import Reaction
from gaitsmith.simulation.replay import why

ROBOT = load_robot("bhr_b2")
LIMITS = [("foothold at its reach bound", 3.1), ("torque of left_knee saturated", 3.2)]


def kinds(scenario: Scenario, hits=LIMITS, pushes=(), reactions=(), place=0.0, fell=3.6):
    return [suspect.kind for suspect in suspects(scenario, hits, pushes, reactions, place, fell)]


def test_a_push_goes_before_the_limits_that_it_makes_the_robot_hit():
    pushed = Scenario(pushes=(Push(time=3.0, impulse=(0.0, 60.0, 0.0)),), speed=(0.3, 0.0))
    assert kinds(pushed, pushes=(3.0,)) == ["push", "command", "reach", "torque"]
    assert kinds(pushed, pushes=(None,))[0] == "command"


def test_a_push_long_ago_is_no_cause():
    pushed = Scenario(pushes=(Push(time=1.0, impulse=(0.0, 60.0, 0.0)),))
    assert "push" not in kinds(pushed, [("legs touching each other", 9.0)], pushes=(1.0,), fell=9.5)


def test_a_push_that_any_walk_withstands_comes_after_uneven_ground():
    both = {"terrain": "boxes:0.05", "state": "estimated"}
    for size, first in ((60.0, "push"), (3.0, "terrain")):
        scenario = Scenario(pushes=(Push(time=3.0, impulse=(0.0, size, 0.0)),), **both)
        found = suspects(scenario, LIMITS, (3.0,), (), 0.0, 3.6, ROBOT)
        assert [suspect.kind for suspect in found if suspect.kind in ("push", "terrain", "estimated")] == [
            first,
            *({"push", "terrain"} - {first}),
            "estimated",
        ]


@pytest.mark.parametrize(
    ("slip", "wrong", "blamed", "first"),
    [
        (None, 2.8, None, "estimated"),  # the speed was wrong before anything else
        (None, 3.4, None, "terrain"),  # it fell already
        (None, None, 2.9, "reading"),  # a good sensor was taken for broken
        (2.7, 2.8, None, "friction"),  # it slipped, and the speed was wrong for that
        (2.9, 2.8, None, "estimated"),
    ],
)
def test_an_estimate_that_is_wrong_goes_before_the_ground(slip, wrong, blamed, first):
    """On boxes, on a floor of 0.4: what was wrong first, and well before the fall at 3.6 s."""
    hits = [("left sole slipping", slip)] if slip else []
    hits += [(MISTAKEN, wrong)] if wrong else []
    reactions = [Reaction(time=blamed, component="left_knee.angle", type="stuck", reaction="x")] if blamed else []
    rough = {"terrain": "boxes:0.05", "friction": 0.4}
    hits = sorted(hits + LIMITS, key=lambda hit: hit[1])
    assert kinds(Scenario(state="estimated", **rough), hits, (), reactions)[0] == first
    assert kinds(Scenario(**rough), hits, (), reactions)[0] in ("friction", "terrain")


def test_a_walk_at_a_usual_speed_comes_after_the_limits_that_it_hit():
    """Half the speed saves many a walk whose motors are too weak: that is no cause as long as the speed is modest."""
    late = [*LIMITS, ("left sole slipping", 3.3)]
    for fields, last in (({"speed": 0.3}, True), ({"speed": 1.2}, False), ({"speed": 0.3, "lift": 0.15}, False)):
        found = [s.kind for s in suspects(Scenario(**fields), late, (), (), 0.0, 3.6, ROBOT)]
        assert sorted(found) == ["command", "reach", "slip", "torque"]
        assert found[-1 if last else 0] == "command"
        assert [kind for kind in found if kind != "command"] == ["reach", "torque", "slip"]


def test_the_latest_push_first():
    pushes = tuple(Push(time=time, impulse=(0.0, size, 0.0)) for time, size in ((2.0, 10.0), (3.0, 20.0)))
    found = suspects(Scenario(pushes=pushes), LIMITS, (2.0, 3.0), (), 0.0, 3.6)
    assert [suspect.what for suspect in found[:2]] == ["push of 20.0 N·s at 3.000 s", "push of 10.0 N·s at 2.000 s"]


@pytest.mark.parametrize(
    ("fields", "extra", "kind"),
    [
        ({"faults": ("gyro:stuck@3s,0.5s",)}, {}, "fault"),
        ({"terrain": "slope:12"}, {"place": 1.0}, "terrain"),
        ({"terrain": "ice:0.1,1,1"}, {"hits": [("left sole slipping", 3.0)]}, "friction"),
        ({"friction": 0.15}, {"hits": [("left sole slipping", 3.0), *LIMITS]}, "friction"),
        ({"torque_delay": 0.01}, {}, "delay"),
        ({"joint_friction": 5.0}, {}, "joint_friction"),
        ({"mass_factor": 0.8}, {}, "mass"),
        ({"state": "estimated"}, {}, "estimated"),
        ({"state": "estimated", "sensors": {"gyro": 0.5}}, {"hits": [(MISTAKEN, 2.0), *LIMITS]}, "noise"),
        ({"sensors": {"gyro": 0.5}}, {}, "reach"),
        ({}, {"reactions": [Reaction(time=3.0, component="gyro", type="stuck", reaction="x")]}, "reading"),
        ({}, {}, "reach"),
        ({}, {"hits": [("ZMP at the edge of the left sole", 3.0), ("left foot behind its target", 3.1)]}, "lag"),
        ({}, {"hits": []}, "none"),
    ],
)
def test_each_kind_is_found(fields, extra, kind):
    assert kinds(Scenario(**fields), **extra)[0] == kind


def test_a_slope_that_is_not_reached_is_no_cause():
    assert "terrain" not in kinds(Scenario(terrain="slope:12"), place=0.1)


def test_falls_of_known_cause_are_explained_and_confirmed():
    """A push, a dead motor, a torque that comes late: named first, and without it the robot stands."""
    known = {
        "push": {"pushes": (Push(time=2.0, impulse=(0.0, 90.0, 0.0)),), "torque_delay": 0.002},
        "fault": {"faults": ("left_knee.motor:dead@2s,1s",)},
        "delay": {"torque_delay": 0.03},
    }
    for kind, fields in known.items():
        verdict = why(Scenario(speed=(0.3, 0.0), duration=4.0, **fields), robot=ROBOT)
        assert verdict is not None, kind
        assert (verdict.kind, verdict.cause.confirmed) == (kind, True)
        assert verdict.trials[-1].stands
        assert verdict.fall.cause is not None


def test_a_run_that_stands_has_no_cause():
    assert why(Scenario(speed=(0.3, 0.0), duration=2.0), robot=ROBOT) is None
