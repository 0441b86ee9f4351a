"""Joints by name and mirrored postures in motions: planned, stored, mirrored, and each of them looked at."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from gaitsmith.errors import BadInput
from gaitsmith.synthesis.files.gait_file import gait_document, gait_of
from gaitsmith.synthesis.files.motion_file import read_motion
from gaitsmith.synthesis.gaits.gait import follow
from gaitsmith.synthesis.motions.motion import At, Limit, Same
from gaitsmith.synthesis.motions.quantities import RATE
from gaitsmith.synthesis.proof.rigorous import proof_of
from gaitsmith.synthesis.proof.verify import verify

EXAMPLE = Path(__file__).parents[2] / "examples" / "motions" / "sway.toml"
SPARSE = 40  # instants a phase


@pytest.fixture(scope="module")
def gait(planner):
    found = planner.plan(*read_motion(EXAMPLE, planner.biped))
    assert found.gait is not None, found.reason
    return found.gait


def with_motion(gait, **changes):
    return replace(gait, motion=replace(gait.motion, **changes))


def test_what_is_asked_of_joints_is_stored_verified_and_proved(gait, robot):
    read = gait_of(gait_document(gait))
    assert [vars(item) for item in read.motion.conditions if isinstance(item, (At, Same))] == [
        vars(item) for item in gait.motion.conditions if isinstance(item, (At, Same))
    ]
    assert [phase.limits for phase in read.motion.phases] == [phase.limits for phase in gait.motion.phases]
    assert verify(read, robot, SPARSE).ok
    assert not proof_of(read, robot)[1]


@pytest.mark.parametrize(
    ("quantity", "value"),
    [("left_hip_roll.angle", 0.1001), ("right_knee.acceleration", 0.02), ("left_knee.velocity", 0.01)],
)
def test_a_joint_that_does_otherwise_is_not_verified(gait, robot, quantity, value):
    border = 1 if quantity.startswith("left_hip") else 2
    other = with_motion(gait, conditions=(At(border, quantity, value),))
    assert any(text.startswith(f"{quantity}: ") for text in verify(other, robot, 2).problems)


def test_a_posture_is_the_mirror_image_and_not_the_same(gait, robot):
    plain = with_motion(gait, conditions=(Same(2, 1),))
    image = with_motion(gait, conditions=(Same(2, 1, mirrored=True),))
    told = [any("position at border 2" in text for text in verify(each, robot, 2).problems) for each in (plain, image)]
    assert told == [True, False]


@pytest.mark.parametrize("what", ["angle", "velocity", "acceleration", "torque"])
def test_a_limit_of_a_joint_that_is_exceeded_is_named(gait, robot, what):
    limit = Limit(f"left_knee.{what}", -1e-3, {"angle": 0.5}.get(what, 1e-3))
    phases = (replace(gait.motion.phases[0], limits=(limit,)), *gait.motion.phases[1:])
    problems = verify(with_motion(gait, phases=phases), robot, SPARSE).problems
    assert any(text.startswith(f"left_knee.{what}: ") for text in problems), problems


def test_the_mirror_image_of_a_motion_is_planned_alike(gait, planner, tmp_path):
    """With the left foot as support every row is that of the other leg's joint."""
    text = EXAMPLE.read_text()
    for one, two in (("right", "left"), ("-0.065]", "0.065]")):
        text = text.replace(one, "@").replace(two, one).replace("@", two)
    file = tmp_path / "image.toml"
    file.write_text(text.replace("angle = 0.1 }", "angle = -0.1 }").replace("--0.065", "-0.065"))
    motion, settings = read_motion(file, planner.biped)
    assert motion.phases[0].foothold == (0.0, 0.065)
    found = planner.plan(motion, settings)
    assert found.gait is not None, found.reason
    assert found.gait.certificate["objective"] == pytest.approx(gait.certificate["objective"], rel=1e-6)


def test_limits_and_conditions_follow_into_the_mirror_image(gait, planner):
    partner, sign = planner.biped.partner, planner.biped.sign
    image = follow(gait, gait, True, partner, sign).motion
    limit, condition = image.phases[0].limits[0], next(item for item in image.conditions if isinstance(item, At))
    assert (limit.quantity, limit.low, limit.high) == ("right_hip_roll.velocity", -0.4, 0.4)
    assert (condition.quantity, condition.value) == ("right_hip_roll.angle", -0.1)


def test_joints_that_are_not_there_are_named(gait, planner, tmp_path):
    file = tmp_path / "own.toml"
    for old, new, words in (
        ("left_hip_roll = { angle", "left_arm = { angle", r"conditions\[1\].joints: got 'left_arm', .*--free NAME"),
        ("left_knee = { angle", "waist = { angle", r"phases\[1\].joints: got 'waist'"),
        ("mirrored = true", "mirrored = false\n\n[[conditions]]\nafter = 'back'\nmirrored = true", "same_as beside it"),
    ):
        file.write_text(EXAMPLE.read_text().replace(old, new, 1))
        with pytest.raises(BadInput, match=words):
            read_motion(file, planner.biped)
    document = gait_document(gait)
    document["phases"][0]["limits"][0]["quantity"] = "wing.angle"
    with pytest.raises(BadInput, match=r"phases\[0\].limits\[0\].quantity: got 'wing'"):
        gait_of(document)


def test_what_weighs_more_is_spared_and_the_weights_are_those_of_j(gait, planner, robot):
    motion, settings = read_motion(EXAMPLE, planner.biped)
    found = planner.plan(motion, settings.model_copy(update={"effort_weights": {"right_knee": 5.0, "left_knee": 0.2}}))
    assert found.gait is not None, found.reason
    assert verify(gait_of(gait_document(found.gait)), robot, 2).ok
    weighed = found.gait.certificate
    names = gait.joint_names
    efforts = []
    for item in (gait, found.gait):
        torques = np.hstack([item.torques(k, t) for k, t in enumerate(_instants(item))])
        efforts.append(np.sum(torques**2, axis=1))
    idlest = {**weighed["effort_weights"], names[int(np.argmin(efforts[1]))]: 1.001}
    for change in ({"right_knee": 1.0}, {"right_knee": -5.0}, {"wing": 2.0}, [1.0], idlest):
        other = replace(found.gait, certificate=weighed | {"effort_weights": change})
        assert not verify(other, robot, 2).ok
    before, after = (each[[names.index("right_knee"), names.index("left_knee")]] for each in efforts)
    assert after[0] < before[0]
    assert after[1] > before[1]


def test_a_phase_may_bound_torque_rates_more_than_the_others(gait, planner, robot):
    first = gait.motion.phases[0]
    reached = float(np.abs(gait.torque_rates(0, _instants(gait)[0])).max())
    limit = Limit(RATE, high=0.7 * reached)
    asked = replace(first, limits=(*first.limits, limit))
    named = verify(with_motion(gait, phases=(asked, *gait.motion.phases[1:])), robot, SPARSE).problems
    assert any("torque rate: " in text for text in named), named
    motion, settings = read_motion(EXAMPLE, planner.biped)
    phase = motion.phases[0]
    phases = (replace(phase, limits=(*phase.limits, limit)), *motion.phases[1:])
    found = planner.plan(replace(motion, phases=phases), settings)
    assert found.gait is not None, found.reason
    read = gait_of(gait_document(found.gait))
    assert verify(read, robot, SPARSE).ok
    assert np.abs(read.torque_rates(0, _instants(read)[0])).max() <= 0.7 * reached


def _instants(gait):
    borders = gait.motion.borders
    return [np.linspace(one, two, 50) for one, two in pairwise(borders)]
