"""For all times: enclosures hold what MuJoCo finds at instants, and what lies between instants is found."""

from dataclasses import replace

import numpy as np
import pytest

from gaitsmith.errors import BadInput
from gaitsmith.synthesis import verify
from gaitsmith.synthesis.gaits.full_state import StateFinder
from gaitsmith.synthesis.motions.biped import biped_from
from gaitsmith.synthesis.proof.box import Box, box_from, stability
from gaitsmith.synthesis.proof.certificate import ranked
from gaitsmith.synthesis.proof.definitions import phase_bounds
from gaitsmith.synthesis.proof.dynamics import EnclosedRobot
from gaitsmith.synthesis.proof.enclosure import enclose, first_stretches
from gaitsmith.synthesis.proof.measured import Errors, measure
from gaitsmith.synthesis.proof.rigorous import proof_of, prove
from gaitsmith.synthesis.proof.taylor import Taylor


@pytest.fixture(scope="module")
def engine(robot):
    return EnclosedRobot(robot)


@pytest.mark.parametrize("support", ["left", "right"])
def test_equations_are_mujocos(robot, engine, support):
    rng, n = np.random.default_rng(0), len(robot.joint_names)
    q, v, a = (size * rng.normal(size=n) for size in (0.4, 2.0, 10.0))
    torque, wrench = rng.normal(size=n), 30.0 * rng.normal(size=12)
    states = tuple(Taylor.constant(values, 1) for values in (q, v, a))
    motions = engine.motions(support, (0.1, -0.05), *states)
    both = {
        name: tuple(Taylor.constant(wrench[k : k + 3], 1) for k in (first, first + 3))
        for name, first in (("left", 0), ("right", 6))
    }
    left = engine.residual(motions, engine.inertial(motions), both, states, Taylor.constant(torque, 1))
    finder = StateFinder(robot)
    finder.find(support, (0.1, -0.05), q, v, a)
    wanted = finder.residual(torque, wrench)
    wanted[3:6] = finder.data.xmat[robot.torso_body].reshape(3, 3) @ wanted[3:6]
    assert np.abs(left.c[0, :, 0] - wanted).max() < 1e-11
    assert left.r.max() < 1e-7


@pytest.mark.parametrize("index", range(5))
def test_enclosures_hold_every_instant(dynamic, robot, engine, index):
    gait, biped = dynamic.gait, biped_from(robot)
    stretches = first_stretches(gait, index)[::3]
    inside = enclose(gait, biped, engine, index, stretches)
    ours = phase_bounds(inside.measured, biped, gait.bounds, gait.motion, index)
    share = 0.37
    times = inside.middles + 0.5 * share * inside.spans
    found = measure(gait, biped, StateFinder(robot), index, times, Errors())
    theirs = phase_bounds(found, biped, gait.bounds, gait.motion, index)
    powers = share ** np.arange(len(inside.residual.c))
    for one, two in zip(ours, theirs, strict=True):
        assert (one.name, one.low, one.high) == (two.name, two.low, two.high)
        assert (np.abs(powers @ one.value.c - two.value) <= one.value.r + 1e-11 * one.span).all(), one.name


def test_a_limit_passed_between_instants_is_found(dynamic, robot):
    """A velocity limit just below the true peak, which no instant of a coarse grid meets."""
    sparse = next(w for w in ranked(verify(dynamic.gait, robot, 50).worst) if w.constraint == "left_knee velocity")
    peak = next(r for r in prove(dynamic.gait, robot) if r.constraint == "left_knee velocity")
    most = max(abs(peak.low), abs(peak.high))
    assert most > abs(sparse.value)
    limit = 0.5 * (most + abs(sparse.value))
    gait = replace(dynamic.gait, bounds=dynamic.gait.bounds | {"velocity": limit / abs(sparse.limit)})
    proof, problems = proof_of(gait, robot)
    assert not proof["ok"]
    assert any("left_knee velocity" in text for text in problems)


def test_stability_is_proved_for_a_box_and_not_beyond(dynamic, robot):
    small = stability(dynamic.gait, robot, Box(0.02, (0.5, 1.0), 0.002))
    assert small["proved"]
    margins = {item["constraint"]: item["margin"] for item in small["constraints"]}
    zmp = verify(dynamic.gait, robot, 100).hull_margin / 1e3
    assert 0.0 < margins["ZMP"] < zmp
    large = stability(dynamic.gait, robot, Box(0.3, (0.05, 1.0), 0.05))
    open_ = {item["constraint"] for item in large["constraints"] if item["unproved"]}
    assert {"ZMP", "friction"} <= open_
    assert all(span["from"] < span["to"] for item in large["constraints"] for span in item["unproved"])


def test_without_errors_the_boxs_zmp_is_the_files(dynamic, robot):
    none = stability(dynamic.gait, robot, Box())
    zmp = next(item["margin"] for item in none["constraints"] if item["constraint"] == "ZMP")
    assert zmp == pytest.approx(verify(dynamic.gait, robot, 200).hull_margin / 1e3, abs=2e-3)


@pytest.mark.parametrize("text", ["", "mass", "mass=2", "mass=a", "friction=.5", "friction=1:.5", "mass=.1,mass=.1"])
def test_boxes_are_checked(text):
    with pytest.raises(BadInput, match="--box"):
        box_from(text)


def test_a_box_is_read():
    assert box_from("mass=.05,friction=.5:1,foothold=.01") == Box(0.05, (0.5, 1.0), 0.01)
