"""Motions in which both feet leave the ground: no joint drives the body then, and no contact holds it."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from gaitsmith.errors import BadInput
from gaitsmith.splines.polynomial import hermite, polynomial
from gaitsmith.synthesis import Planner
from gaitsmith.synthesis.gaits.full_state import StateFinder
from gaitsmith.synthesis.gaits.gait import Gait, Piece
from gaitsmith.synthesis.motions.biped import biped_from, standing
from gaitsmith.synthesis.motions.catalogue import jump
from gaitsmith.synthesis.motions.contacts import check_contacts
from gaitsmith.synthesis.motions.parameters import JumpParameters
from gaitsmith.synthesis.motions.settings import Bounds, Settings
from gaitsmith.synthesis.program.transcription import Transcription
from gaitsmith.synthesis.proof.dynamics import EnclosedRobot
from gaitsmith.synthesis.proof.enclosure import enclose, first_stretches
from gaitsmith.synthesis.proof.measured import Errors, measure
from gaitsmith.synthesis.solution.passive import with_roots

SOLVED = 1e-9  # of the weight
BETWEEN = 1e-6  # of the weight, between the nodes: what `verify` allows


@pytest.fixture(scope="module")
def flying(robot):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("GAITSMITH_CC", "none")  # a compiler takes longer than it saves here
        made = Planner(robot)
        made = made.suited(jump(made.biped, JumpParameters(), standing(made.biped)))
        assert made.functions.compiled is False
        return made


@pytest.fixture(scope="module")
def motion(flying):
    return jump(flying.biped, JumpParameters(), standing(flying.biped))


def test_a_flying_point_is_that_of_mujoco(flying, robot):
    """Torques, what the root would need, the centre of mass and the momenta, with the support sole anywhere."""
    layout, rng, finder = flying.functions.layout, np.random.default_rng(3), StateFinder(robot)
    q, v, a = rng.uniform(-0.3, 0.3, (3, layout.joints))
    root = rng.uniform(-0.3, 0.3, (3, 6))
    z = np.zeros((layout.inputs, 1))
    for first, joints, pose in zip(
        (layout.position, layout.velocity, layout.acceleration), (q, v, a), root, strict=True
    ):
        z[first : first + layout.joints, 0] = joints
        z[first + layout.pose : first + layout.pose + 6, 0] = pose
    o = flying.functions.evaluate(z, np.zeros((3, 1)))[:, 0]
    finder.find("right", (0.0, 0.0), q, v, a, root)
    place, _, _, rotation, *_ = finder.foot("right", np.zeros(3))
    force, moment = o[layout.force : layout.force + 3], o[layout.moment : layout.moment + 3]
    wrench = np.concatenate([np.zeros(6), force, moment - np.cross(place, force)])
    assert np.abs(finder.residual(o[: layout.joints], wrench)).max() < 1e-8
    assert np.allclose(o[layout.own : layout.own + 3], place, atol=1e-12)
    assert np.allclose(
        o[layout.own + 3 : layout.own + 6], (rotation[1, 0], -rotation[2, 0], rotation[2, 1]), atol=1e-12
    )
    model, data = robot.model, finder.data
    mujoco.mj_subtreeVel(model, data)
    com, speed, spin = data.subtree_com[0], data.subtree_linvel[0], data.subtree_angmom[0] / robot.mass
    assert np.allclose(o[layout.com : layout.com + 3], com, atol=1e-10)
    assert np.allclose(o[layout.momentum : layout.momentum + 3], speed, atol=1e-10)
    assert np.allclose(o[layout.spin : layout.spin + 3], spin + np.cross(com, speed), atol=1e-10)


def thrown(biped, duration, bend=0.0):
    """A flight by a motionless robot, and its parabola; its knees bend and stretch by ``bend`` rad in between."""
    gravity, q0 = biped.weight / biped.robot.mass, standing(biped)
    middle = q0 + bend * np.array(["knee" in name for name in biped.names])
    states = [np.array([q, 0.0 * q, 0.0 * q]) for q in (q0, middle, q0)]
    speed, pieces = 0.5 * gravity * duration, []
    for k in range(2):
        begin, h = 0.5 * k * duration, 0.5 * duration
        root = np.zeros((6, 3))
        height = speed * begin - 0.5 * gravity * begin**2
        root[2] = height, (speed - gravity * begin) * h, -0.5 * gravity * h**2
        pieces.append((begin, h, hermite(h, *states[k : k + 2]), root))
    return pieces


def test_a_thrown_robot_needs_no_torque_and_no_ground(robot, motion):
    """A parabola obeys the equations at all times, by MuJoCo and in the proof; another one does not."""
    biped = biped_from(robot)
    phase = replace(motion.phases[1], duration=0.2)
    alone = replace(motion, phases=(phase,), conditions=())
    for share, agrees in ((1.0, True), (0.99, False)):
        none = np.zeros((len(robot.joint_names), 1)), np.zeros((12, 1))
        pieces = tuple(Piece(a, h, q, *none, share * root) for a, h, q, root in thrown(biped, 0.2))
        bounds = Settings().sized(biped).bounds.model_dump()
        gait = Gait(robot.card.name, "", robot.joint_names, alone, (pieces,), bounds, 5)
        errors = Errors()
        numbers = measure(gait, biped, StateFinder(robot), 0, np.linspace(0.0, 0.2, 9), errors)
        assert (errors.residual < SOLVED) == agrees
        assert numbers.own[2, 4] == pytest.approx(share * 9.81 * 0.2**2 / 8.0)
        enclosed = enclose(gait, biped, EnclosedRobot(robot), 0, first_stretches(gait, 0))
        assert (enclosed.residual.size.max() / biped.weight < SOLVED) == agrees
        assert np.abs(enclosed.measured.own[2].c[0]).max() == pytest.approx(numbers.own[2].max(), rel=0.02)


def test_the_body_answers_to_what_the_legs_do_in_flight(flying, motion):
    """The support sole's motion is solved from all six equations of motion, between ends that agree."""
    layout, biped = flying.functions.layout, flying.biped
    trans = Transcription(biped, motion, Settings().sized(biped))
    local = []
    for begin, h, joints, root in thrown(biped, 2.0 * motion.phases[1].duration, bend=0.05):
        whole = np.zeros((layout.coordinates, 6))
        whole[: layout.joints], whole[layout.pose :, :3] = joints, root
        local.append((begin, h, whole))
    still = [(0.0, 1.0, np.zeros((layout.coordinates, 6)))]
    solved = with_roots(trans, flying.functions, [still, local[:1], local[1:], still])
    worst = {}
    for name, phases in (("before", [local[:1], local[1:]]), ("after", solved[1:3])):
        gaps = []
        for ((_, h, coefficients),) in phases:
            s = np.linspace(0.0, 1.0, 23)
            z = np.zeros((layout.inputs, len(s)))
            z[: layout.wrench] = polynomial(coefficients, s, h).reshape(layout.wrench, -1)
            o = flying.functions.evaluate(z, np.zeros((3, len(s))))
            gaps.append(np.abs(o[layout.force : layout.force + 6]).max() / biped.weight)
        worst[name] = max(gaps)
    assert worst["before"] > 0.05
    assert worst["after"] < BETWEEN


def test_what_a_flight_cannot_be_is_refused(flying, motion):
    keys = ("support_at", "other_at")
    air = replace(motion.phases[0], contact="air", other=None)
    with pytest.raises(BadInput, match="both feet flat"):
        check_contacts((air, *motion.phases[1:]), False, keys)
    with pytest.raises(BadInput, match="at the start and at the end"):
        check_contacts(motion.phases[1:], False, keys)
    with pytest.raises(BadInput, match="order"):
        flying.plan(motion, Settings(order=4, bounds=Bounds()))
