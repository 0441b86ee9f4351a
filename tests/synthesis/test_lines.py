"""Line soles: gaits of a robot whose ankles cannot roll. The lean about the line that stands is driven by no joint."""

from dataclasses import replace

import numpy as np
import pytest

from gaitsmith.control import Controller
from gaitsmith.errors import BadInput
from gaitsmith.robots import load_robot
from gaitsmith.simulation.plant import Plant
from gaitsmith.synthesis import Planner, Request, StepParameters, answer
from gaitsmith.synthesis.files.gait_file import gait_document, gait_of, require_robot
from gaitsmith.synthesis.gaits.full_state import StateFinder
from gaitsmith.synthesis.gaits.gait import ROLL, unrolled
from gaitsmith.synthesis.gaits.support import hull, inside
from gaitsmith.synthesis.gaits.walkable import walkable
from gaitsmith.synthesis.motions.biped import standing
from gaitsmith.synthesis.motions.catalogue import cyclic, start
from gaitsmith.synthesis.motions.motion import Motion
from gaitsmith.synthesis.proof.measured import Errors, measure
from gaitsmith.synthesis.proof.quantities import quantity
from gaitsmith.synthesis.proof.rigorous import prove
from gaitsmith.synthesis.proof.verify import verify
from gaitsmith.synthesis.requests.asked import stride
from gaitsmith.synthesis.requests.request import leaning

STEP = StepParameters.sized(0.7645, 0.12, 0.4)
UPRIGHT = 0.98  # cosine of the torso's tilt: 11 degrees, of which the plan has 7
DEFORMED = 1e-5  # rad: of a lean that no longer obeys its equation of motion


@pytest.fixture(scope="module")
def robot():
    return load_robot("bhr_b2")


@pytest.fixture(scope="module")
def planner(robot):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("GAITSMITH_CC", "none")  # a compiler takes longer than it saves here
        made = Planner(robot)
        assert made.functions.compiled is False
        return made


@pytest.fixture(scope="module")
def gait(planner):
    found = answer(planner, Request("cyclic", STEP)).gait
    assert found is not None
    return found


def test_a_gait_on_lines_agrees_with_physics_at_all_times(gait, robot):
    verdict = verify(gait, robot)
    assert verdict.ok, verdict.problems
    assert verdict.zmp_margin > 10.0
    open_ = [item for item in prove(gait, robot) if not item.ok]
    assert not open_, open_


def test_a_start_on_lines_leads_to_the_gait_and_is_proved(gait, planner, robot):
    """It ends as the gait begins: joints, lean and its rate agree, and the foot that will be lifted bears nothing."""
    goal = tuple(values[:, 0] for values in gait.joints(0, np.array([0.0])))
    found = planner.plan(start(planner.biped, STEP, standing(planner.biped), goal)).gait
    assert found is not None
    assert not verify(found, robot).problems
    open_ = [item for item in prove(found, robot) if not item.ok]
    assert not open_, open_
    last, end, begin = len(found.pieces) - 1, np.array([found.duration]), np.array([0.0])
    for now, then in zip(found.joints(last, end), gait.joints(0, begin), strict=True):
        assert np.allclose(now, then, atol=1e-6)
    assert np.allclose(found.roots(last, end)[:, ROLL], gait.roots(0, begin)[:, ROLL], atol=1e-5)
    assert np.abs(found.wrenches(last, end)[:6]).max() < 1e-6 * planner.biped.weight


def test_a_stop_on_lines_begins_with_the_lean_of_its_gait(gait, planner):
    """Its conditions fix what the joints leave open: with another lean or rate the sole is not where and as it is."""
    conditions = leaning(planner.biped, gait)
    turned = [replace(piece, root=piece.root + np.eye(1, piece.root.shape[1], 0) * 0.01) for piece in gait.pieces[0]]
    faster = [replace(piece, root=piece.root + np.eye(1, piece.root.shape[1], 1) * 0.01) for piece in gait.pieces[0]]
    assert [(item.quantity, item.border) for item in conditions] == [("sole_z", 0), ("ankle_vz", 0)]
    for pieces, same in ((gait.pieces[0], (True, True)), (turned, (False, None)), (faster, (True, False))):
        measured = measure(replace(gait, pieces=(tuple(pieces), *gait.pieces[1:])), planner.biped.whole,
                           StateFinder(planner.biped.robot), 0, np.array([0.0]), Errors())  # fmt: skip
        for item, agrees in zip(conditions, same, strict=True):
            value = quantity(measured, planner.biped.whole, gait.motion.phases[0], item.quantity)
            assert agrees is None or bool(abs(float(value[0]) - item.value) < 1e-6) == agrees


def test_no_lean_but_the_right_one_is_accepted(gait, robot):
    """The equation of motion of the lean is checked, since no torque makes up for what is wrong with it."""
    bump = np.array([0.0, 0.0, 0.0, 64.0, -192.0, 192.0, -64.0])  # and two derivatives zero at both ends
    pieces = [list(group) for group in gait.pieces]
    root = pieces[0][0].root.copy()
    root[0, : len(bump)] += DEFORMED * bump
    pieces[0][0] = replace(pieces[0][0], root=root)
    changed = replace(gait, pieces=tuple(map(tuple, pieces)))
    problems = " ".join(verify(changed, robot).problems)
    assert "dynamics residual" in problems


def test_the_file_keeps_leans_and_is_refused_without_them(gait, robot):
    again = gait_of(gait_document(gait))
    times = np.linspace(0.0, 0.1, 7)
    assert np.array_equal(again.roots(0, times), gait.roots(0, times))
    require_robot(again, robot)
    document = gait_document(gait)
    del document["phases"][1]["sections"][0]["root"]
    with pytest.raises(BadInput, match="root"):
        require_robot(gait_of(document), robot)


def test_the_next_step_leans_the_other_way(gait, planner):
    two = unrolled(gait, planner.biped.partner, planner.biped.sign, 2)
    phases, times = len(gait.motion.phases), np.linspace(0.0, 0.13, 5)
    assert np.allclose(two.roots(phases, gait.duration + times)[:, ROLL], -gait.roots(0, times)[:, ROLL], atol=1e-12)


def test_a_leaning_robot_turns_about_its_line(robot):
    """Velocities and accelerations are the derivatives of positions; the line itself stays."""
    finder, rng, h = StateFinder(robot), np.random.default_rng(1), 1e-5
    q, v, a = 0.3 * rng.normal(size=(3, len(robot.joint_names)))
    lean = np.array([0.1, -0.7, 2.0])

    def at(t):
        joints = q + t * v + 0.5 * t * t * a, v + t * a, a
        root = np.zeros((3, 6))
        root[:, ROLL] = lean[0] + t * lean[1] + 0.5 * t * t * lean[2], lean[1] + t * lean[2], lean[2]
        state = finder.find("right", (0.2, -0.1), *joints, root)
        return state, [finder.foot("right", np.array([x, 0.0, 0.0])) for x in (-0.07, 0.12)]

    (before, _), (now, line), (after, _) = (at(t) for t in (-h, 0.0, h))
    assert np.allclose((after.position[:3] - before.position[:3]) / (2.0 * h), now.velocity[:3], atol=1e-8)
    assert np.allclose((after.velocity - before.velocity) / (2.0 * h), now.acceleration, atol=1e-6)
    for x, (place, speed, pull, *_) in zip((-0.07, 0.12), line, strict=True):
        assert np.allclose(place, (0.2 + x, -0.1, 0.0), atol=1e-12)
        assert np.allclose([speed, pull], 0.0, atol=1e-10)


@pytest.mark.parametrize("push", [(0.0, 0.0, 0.0), (0.0, 40.0, 0.0)])
def test_it_walks_as_planned_and_is_not_thrown_by_a_push_aside(gait, robot, push):
    """No CoP keeps it upright sideways: footholds do. 4 N·s from the right, where its line could not bear a moment."""
    plan, controller, plant = walkable([gait], robot), Controller(robot), Plant(robot)
    plant.reset(*plan.start)
    controller.load(plan)
    controller.follow()
    begin, least = float(plant.q[0]), 1.0
    for tick in range(6000):
        plant.measure(controller.measurement)
        torque = controller.tick()
        plant.push(np.array(push if 2000 <= tick < 2100 else (0.0, 0.0, 0.0)))
        plant.step(torque)
        x, y = plant.q[4:6]
        least = min(least, 1.0 - 2.0 * (x * x + y * y))
    assert least > UPRIGHT
    assert float(plant.q[0]) - begin == pytest.approx(6.0 * plan.speed, rel=0.02)


def test_the_margin_of_a_line_is_the_way_to_its_ends():
    line = hull(np.array([(-0.1, 0.02), (0.2, 0.02)]))
    assert np.allclose(inside(line, np.array([(0.0, 0.15, 0.3), (0.02, 0.02, 0.02)])), (0.1, 0.05, -0.1))


def test_what_lines_cannot_do_is_refused(planner):
    with pytest.raises(BadInput, match="lines"):
        answer(planner, Request("kick"))
    motion = cyclic(planner.biped, STEP)
    turned = tuple(replace(p, contact="heel") if p.name == "load" else p for p in motion.phases)
    with pytest.raises(BadInput, match=r"phases\[2\].contact"):
        planner.plan(Motion("turned", turned, cyclic=True))


def test_steps_on_lines_take_the_cards_period(planner):
    usual = planner.biped.usual_period
    assert stride(0.3, None, None, 0.76, usual) == pytest.approx((0.12, 0.4))
    assert stride(0.3, None, 0.5, 0.76, usual) == pytest.approx((0.15, 0.5))
    assert stride(None, None, None, 0.39, usual) == pytest.approx((0.06, 0.4))
