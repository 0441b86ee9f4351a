"""Turns: footholds that are turned, planned on flat soles and on edges, and the same wherever the motion points."""

import math
from dataclasses import replace

import numpy as np
import pytest

from gaitsmith.control import Controller
from gaitsmith.errors import BadInput
from gaitsmith.simulation.plant import Plant
from gaitsmith.synthesis.files.gait_file import gait_document, gait_of
from gaitsmith.synthesis.gaits.full_state import StateFinder
from gaitsmith.synthesis.gaits.gait import follow
from gaitsmith.synthesis.gaits.unrolled import UnrolledGait
from gaitsmith.synthesis.gaits.walkable import walkable
from gaitsmith.synthesis.motions.biped import biped_from
from gaitsmith.synthesis.motions.contacts import check_contacts
from gaitsmith.synthesis.motions.motion import At, Unloaded, about_vertical
from gaitsmith.synthesis.motions.parameters import StepParameters
from gaitsmith.synthesis.motions.turning import turn_cycle, turn_start, turn_stop
from gaitsmith.synthesis.proof.borders import conditions
from gaitsmith.synthesis.proof.rigorous import proof_of
from gaitsmith.synthesis.proof.verify import verify

TURN = math.radians(15.0)
GAP = 0.02
KEYS = ("foothold", "other_foothold")


@pytest.fixture(scope="module")
def gait(planner):
    found = planner.plan(turn_cycle(planner.biped, StepParameters(0.0, 1.0, turn=TURN), GAP))
    assert found.gait is not None, found.reason
    return found.gait


@pytest.fixture(scope="module")
def on_edges(planner):
    """An arc whose feet land on their heels and leave from their toes."""
    motion = turn_cycle(planner.biped, StepParameters(0.1, 1.0, turn=math.radians(12.0)), GAP)
    phases, pitches = [], []
    for phase in motion.phases:
        if phase.double:  # load, unload: the foot that landed turns about its heel, then the other about its toe
            heel = phase.name == "load"
            edge = replace(phase, name="edge", duration=0.09, contact="heel" if heel else "toe", sections=2)
            flat = replace(phase, duration=0.06, sections=1)
            phases += [edge, flat] if heel else [flat, edge]
            pitches += [At(len(phases) - 2, "foot_pitch", -0.1)] if heel else [At(len(phases), "foot_pitch", 0.15)]
        else:
            phases.append(phase)
    found = planner.plan(replace(motion, phases=tuple(phases), conditions=tuple(pitches)))
    assert found.gait is not None, found.reason
    return found.gait


@pytest.mark.parametrize("angle", [TURN, -TURN])
@pytest.mark.parametrize("length", [0.0, 0.1])
def test_every_foothold_is_turned_against_the_one_before_and_clear_of_it(planner, angle, length):
    biped, step, rest = planner.biped, StepParameters(length, 1.0, turn=angle), np.zeros(12)
    state = rest, rest, rest
    sole, motions = biped.sole("left"), [turn_cycle(biped, step, GAP)]
    motions += [make(biped, step, rest, state, GAP) for make in (turn_start, turn_stop)]
    for motion in motions:
        check_contacts(motion.phases, motion.cyclic, KEYS)
        for phase in motion.phases:
            if phase.double and phase.name != "weight shift":
                assert abs(phase.bend) == pytest.approx(TURN)
                other = phase.straight.other
                ends = np.array([(sole.toe, 0.0, 0.0), (-sole.heel, 0.0, 0.0)]) @ about_vertical(phase.bend).T
                aside = phase.side * (other[1] - phase.foothold[1]) + ends[:, 1]
                assert aside.min() > 2.0 * sole.half_width + GAP


def test_turns_are_verified_and_an_arc_is_proved_for_all_times(gait, on_edges, robot):
    for found in (gait, on_edges):
        verdict = verify(gait_of(gait_document(found)), robot, 40)
        assert verdict.ok, verdict.problems
    assert not proof_of(on_edges, robot)[1]


def test_a_turn_goes_on_turned_and_its_steps_join_in_the_world(gait, robot):
    biped = biped_from(robot)
    after = follow(gait, gait, False, biped.partner, biped.sign)
    first = after.motion.phases[0]
    assert first.heading - gait.motion.phases[0].heading == pytest.approx(2.0 * TURN)
    long = UnrolledGait(gait, robot, 12)
    before, beyond = long.at(np.array([3.9999999, 7.0])), long.at(np.array([4.0000001, 3.0]))
    np.testing.assert_allclose(before.position[0], beyond.position[0], atol=1e-5)
    np.testing.assert_allclose(before.wrench[0], beyond.wrench[0], atol=1e-3)
    yaws = [2.0 * math.atan2(q[6], q[3]) for q in (beyond.position[1], before.position[1])]
    assert math.remainder(yaws[1] - yaws[0] - 4.0 * TURN, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)


def test_a_foot_that_is_turned_otherwise_is_not_verified(gait, robot):
    """Its contact points are elsewhere, and the motion's headings contradict each other."""
    phases = list(gait.motion.phases)
    spoilt = [replace(p, other_heading=p.other_heading + 0.01) if p.double else p for p in phases]
    with pytest.raises(BadInput, match="heading"):
        check_contacts(tuple(spoilt), True, KEYS)
    other = replace(gait, motion=replace(gait.motion, phases=tuple(spoilt)))
    assert any("closure position" in text for text in verify(other, robot, 20).problems)


def test_a_foot_that_should_bear_nothing_is_looked_at(gait, robot):
    loaded = replace(gait, motion=replace(gait.motion, conditions=(Unloaded(3), Unloaded(4))))
    told = conditions(loaded, biped_from(robot), StateFinder(robot))
    assert [abs(found - wanted) <= allowed for _, wanted, found, allowed in told] == [False, True]


def test_a_turn_is_walked(gait, robot):
    controller, plan = Controller(robot), walkable([gait], robot)
    plant = Plant(robot)
    plant.reset(*plan.start)
    controller.load(plan)
    controller.follow()
    yaw, turned = None, 0.0
    for _ in range(round(6.0 / plant.control_step)):
        plant.measure(controller.measurement)
        plant.step(controller.tick())
        now = math.atan2(plant.torso_rotation[1, 0], plant.torso_rotation[0, 0])
        turned, yaw = turned + math.remainder(now - (yaw or now), 2.0 * math.pi), now
    assert plant.torso_rotation[2, 2] > math.cos(0.25)
    assert turned == pytest.approx(6.0 * TURN, abs=0.1)
    assert plan.way(6.0).heading == pytest.approx(6.0 * TURN)
