"""Places of the centre of mass and the torso: MuJoCo's, planned for, stored, verified and proved."""

from dataclasses import replace

import numpy as np
import pytest

from gaitsmith.synthesis import Planner
from gaitsmith.synthesis.files.gait_file import claims_hash, gait_document, gait_of
from gaitsmith.synthesis.gaits.full_state import StateFinder
from gaitsmith.synthesis.gaits.gait import follow
from gaitsmith.synthesis.motions.biped import standing
from gaitsmith.synthesis.motions.motion import At, Limit, Motion, Phase, State
from gaitsmith.synthesis.proof.borders import conditions
from gaitsmith.synthesis.proof.rigorous import proof_of
from gaitsmith.synthesis.proof.verify import verify

SPARSE = 40  # instants a phase
PLACES = {"com_x": 0.02, "com_y": -0.045, "torso_z": 0.34}


@pytest.fixture(scope="module")
def motion(planner):
    rest = standing(planner.biped)
    still = np.zeros(planner.biped.joints)
    limits = (Limit("com_vy", -0.2, 0.2), Limit("torso_x", -0.02, 0.05))
    phase = Phase("over one foot", 1.0, "right", "flat", (0.0, -0.065), (0.0, 0.065), 3, limits)
    wanted = tuple(At(1, name, value) for name, value in PLACES.items())
    return Motion("places", (phase,), (State(0, rest, still, still), *wanted, State(1, None, still, still)))


@pytest.fixture(scope="module")
def placed(planner, motion):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("GAITSMITH_CC", "none")  # a compiler takes longer than it saves here
        made = Planner(planner.biped.robot)
        assert made.suited(motion).functions.compiled is False
        return made


@pytest.fixture(scope="module")
def gait(placed, motion):
    found = placed.plan(motion)
    assert found.gait is not None, found.reason
    return found.gait


def test_a_motion_with_places_has_functions_of_its_own(planner, placed, motion):
    assert planner.suited(replace(motion, phases=(replace(motion.phases[0], limits=()),), conditions=())) is planner
    assert placed.suited(motion) is placed.suited(motion) is not placed


@pytest.mark.parametrize(("support", "side"), [("right", 1.0), ("left", -1.0)])
def test_the_places_of_a_point_are_mujocos(placed, robot, motion, support, side):
    made = placed.suited(motion)
    layout, rng, finder = made.functions.layout, np.random.default_rng(5), StateFinder(robot)
    q, v = rng.uniform(-0.3, 0.3, (2, layout.joints))
    z = np.zeros((layout.inputs, 1))
    z[layout.position :][: layout.joints, 0], z[layout.velocity :][: layout.joints, 0] = q, v
    o = made.functions.evaluate(z, np.zeros((3, 1)), side)[:, 0]
    if side < 0.0:
        q, v = made.biped.mirrored(q), made.biped.mirrored(v)
    finder.find(support, (0.0, 0.0), q, v, np.zeros_like(q))
    image = (1.0, side, 1.0)
    for first, real in (
        (layout.com, finder.centre_of_mass()),
        (layout.momentum, finder.centre_velocity()),
        (layout.body, finder.data.xpos[robot.torso_body]),
    ):
        np.testing.assert_allclose(o[first : first + 3] * image, real, atol=1e-9)


def test_places_that_are_asked_for_are_met_stored_and_proved(gait, robot):
    read = gait_of(gait_document(gait))
    asked = {item.quantity: item.value for item in read.motion.conditions if isinstance(item, At)}
    assert asked == PLACES
    assert verify(read, robot, SPARSE).ok
    assert not proof_of(read, robot)[1]


@pytest.mark.parametrize(
    "forged",
    [
        {"conditions": (At(1, "com_y", -0.044),)},
        {"conditions": (At(1, "torso_z", 0.342),)},
        {"limits": (Limit("com_vy", -0.01, 0.2),)},
    ],
)
def test_places_that_are_not_met_are_no_proof(gait, robot, forged):
    phase = gait.motion.phases[0]
    motion = replace(gait.motion, conditions=forged.get("conditions", ()))
    motion = replace(motion, phases=(replace(phase, limits=forged.get("limits", ())),))
    changed = replace(gait, motion=motion)
    changed.certificate["claims"] = claims_hash(changed)
    name = next(iter(forged.values()))[0].quantity
    assert any(name in problem for problem in verify(changed, robot, SPARSE).problems)
    if "limits" in forged:
        assert any(name in problem for problem in proof_of(changed, robot)[1])


def test_places_move_with_a_gait_that_follows(gait, planner, robot):
    """In the mirror image, and elsewhere, the same conditions hold."""
    biped = planner.biped
    image = follow(gait, gait, True, biped.partner, biped.sign)
    began = [tuple(replace(piece, start=piece.start - gait.duration) for piece in group) for group in image.pieces]
    image = replace(image, pieces=tuple(began))
    for _, wanted, found, allowed in conditions(image, biped, StateFinder(robot)):
        assert abs(wanted - found) < allowed
