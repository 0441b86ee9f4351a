"""A stance foot that rises on its toe while the other one swings: forces, planned, stored, proved, laid out."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gaitsmith.errors import BadInput
from gaitsmith.planned.evaluate import make_plan_sample
from gaitsmith.planned.table import COM
from gaitsmith.simulation import run_episode
from gaitsmith.simulation.planned_run import completed
from gaitsmith.simulation.scenario import make_scenario
from gaitsmith.synthesis import write_gait
from gaitsmith.synthesis.files.gait_file import claims_hash, gait_document, gait_of, require_robot
from gaitsmith.synthesis.files.motion_file import read_motion
from gaitsmith.synthesis.gaits.full_state import StateFinder
from gaitsmith.synthesis.gaits.walkable import walkable
from gaitsmith.synthesis.motions.motion import Phase
from gaitsmith.synthesis.proof.rigorous import proof_of
from gaitsmith.synthesis.proof.verify import verify
from gaitsmith.whole_body.reference import FLAT, NONE, TOE

EXAMPLE = Path(__file__).parents[2] / "examples" / "motions" / "heel_off.toml"
SPARSE, OFF = 40, 2  # instants a phase; the phase on the toe


@pytest.fixture(scope="module")
def tipping(suited_planner):
    return suited_planner(EXAMPLE)


@pytest.fixture(scope="module")
def gait(tipping):
    found = tipping.plan(*read_motion(EXAMPLE, tipping.biped))
    assert found.gait is not None, found.reason
    return found.gait


@pytest.mark.parametrize(("support", "side"), [("right", 1.0), ("left", -1.0)])
def test_forces_about_the_toe_are_those_of_mujoco(tipping, robot, support, side):
    layout, rng, finder = tipping.functions.layout, np.random.default_rng(4), StateFinder(robot)
    n, c = layout.joints, layout.coordinates
    q, v, a = rng.uniform(-0.3, 0.3, (3, n))
    pitch, rate, pull = 0.2, 0.7, -1.1
    z = np.zeros((layout.inputs, 1))
    for k, values in enumerate((q, v, a)):
        z[k * c : k * c + n, 0], z[k * c + layout.pose, 0] = values, (pitch, rate, pull)[k]
    o = tipping.functions.evaluate(z, np.zeros((3, 1)), side)[:, 0]
    reach, s, co = robot.legs[0].sole.toe, np.sin(pitch), np.cos(pitch)
    root = np.zeros((3, 6))  # of a sole that turns about its toe's edge
    root[:, 0] = reach * np.array([1.0 - co, s * rate, s * pull + co * rate**2])
    root[:, 2] = reach * np.array([s, co * rate, co * pull - s * rate**2])
    root[:, 4] = pitch, rate, pull
    if side < 0.0:
        q, v, a = (tipping.biped.mirrored(values) for values in (q, v, a))
    finder.find(support, (0.0, 0.0), q, v, a, root)
    image = np.array([1.0, side, 1.0, side, 1.0, side])
    force, moment = (o[layout.force : layout.force + 6] * image).reshape(2, 3)
    place = finder.foot(support, np.zeros(3))[0]
    wrench = np.zeros(12)
    wrench[6:] = [*force, *(moment - np.cross(place, force))]
    wrench = wrench if support == "right" else np.roll(wrench, 6)
    torque = o[:n] if side > 0.0 else tipping.biped.mirrored(o[:n])
    assert np.abs(finder.residual(torque, wrench)).max() < 1e-9 * tipping.biped.weight
    toe = np.array([reach, 0.0, 0.0])
    assert o[layout.edge] == pytest.approx((moment - np.cross(toe, force))[1], abs=1e-9)


def test_the_heel_rises_before_the_other_foot_lands_and_the_toe_stays(gait, robot):
    phase, borders, finder = gait.motion.phases[OFF], gait.motion.borders, StateFinder(robot)
    times = np.linspace(*borders[OFF : OFF + 2], 7)
    (q, v, a), root = gait.joints(OFF, times), gait.roots(OFF, times)
    reach, pitch = robot.legs[1].sole.toe, []
    for k in range(len(times)):
        finder.find(phase.support, phase.stand, q[:, k], v[:, k], a[:, k], root[..., k])
        toe, speed, _, rotation, _, _ = finder.foot(phase.support, np.array([reach, 0.0, 0.0]))
        np.testing.assert_allclose(toe, (phase.foothold[0] + reach, phase.foothold[1], 0.0), atol=1e-9)
        assert np.abs(speed).max() < 1e-8
        pitch.append(-rotation[2, 0])
    assert pitch[0] == pytest.approx(0.0, abs=1e-9)
    assert np.all(np.diff(pitch) > 0.0)
    assert pitch[-1] > 0.1
    landed = finder.foot(phase.other_foot, np.zeros(3))
    np.testing.assert_allclose(landed[0], (*gait.motion.phases[OFF + 1].foothold, 0.0), atol=1e-6)
    assert np.abs(landed[1]).max() < 1e-6


def test_it_is_stored_verified_and_proved(gait, robot):
    read = gait_of(gait_document(gait))
    require_robot(read, robot)
    assert [phase.tips for phase in read.motion.phases] == [False, False, True, False]
    assert verify(read, robot, SPARSE).ok
    assert not proof_of(read, robot)[1]


def test_a_toe_that_slides_is_no_proof(gait, robot):
    pieces = list(gait.pieces)
    pieces[OFF] = tuple(replace(piece, root=piece.root * np.array([[0.5], *[[1.0]] * 5])) for piece in pieces[OFF])
    forged = replace(gait, pieces=tuple(pieces))
    assert any("closure" in problem for problem in verify(forged, robot, SPARSE).problems)
    assert any("closure" in problem for problem in proof_of(forged, robot)[1])


def test_a_foot_that_lies_flat_in_the_file_does_not_move(gait, robot):
    phases = list(gait.motion.phases)
    phases[OFF] = replace(phases[OFF], support_contact="flat")
    forged = replace(gait, motion=replace(gait.motion, phases=tuple(phases)))
    forged.certificate["claims"] = claims_hash(forged)
    with pytest.raises(BadInput):
        require_robot(gait_of(gait_document(forged)), robot)


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ('contact = "toe"\nsupport_at', 'contact = "flat"\nsupport_at', "contact"),  # the foot on its toe lies down
        ('duration = 0.4\nsupport = "right"', 'duration = 0.4\nsupport = "right"\nsupport_contact = "toe"', "support"),
        ("other_at = [0.0, -0.065]", "other_at = [0.02, -0.065]", "other_at"),  # it slides
    ],
)
def test_what_no_foot_can_do_is_refused(tipping, tmp_path, old, new, named):
    text = EXAMPLE.read_text()
    assert old in text
    (tmp_path / "motion.toml").write_text(text.replace(old, new, 1))
    with pytest.raises(BadInput) as refused:
        read_motion(tmp_path / "motion.toml", tipping.biped)
    assert named in refused.value.field


def test_the_foot_that_lands_becomes_the_support_once_it_has_a_place(gait, robot):
    """Its place is told by a first section relative to the sole on its toe; the curves go on across all of them."""
    table = walkable([gait], robot, 2).table
    rows = [int(k) for k in table.sequence]
    right, left = (robot.legs.index(next(leg for leg in robot.legs if leg.name == name)) for name in ("right", "left"))
    alone = [k for k in rows if table.contact[k, right] == TOE and table.contact[k, left] == NONE]
    landed = [k for k in rows if table.contact[k, right] == TOE and table.contact[k, left] == FLAT]
    assert alone
    assert table.support[landed[0]] == right
    assert table.support[landed[-1]] == left
    step = np.array([0.15, 0.13, 0.0])
    np.testing.assert_allclose(table.place[landed[0], left, :3], step, atol=1e-9)
    np.testing.assert_allclose(table.place[landed[-1], right, :3], -step, atol=1e-9)
    ends = make_plan_sample(2, len(gait.joint_names)).basis[0] * 0.0 + 1.0
    signs = (-1.0) ** np.arange(len(ends))
    first = rows.index(landed[0])
    before, after = table.motion[rows[first - 1]], table.motion[landed[0]]
    np.testing.assert_allclose((ends @ before)[COM : COM + 3], (signs @ after)[COM : COM + 3], atol=1e-7)
    switch = next(k for k in range(first, len(rows)) if table.support[rows[k]] == left)
    before, after = table.motion[rows[switch - 1]], table.motion[rows[switch]]
    np.testing.assert_allclose((ends @ before)[COM : COM + 3], (signs @ after)[COM : COM + 3] + step, atol=1e-7)


def test_it_is_walked(gait, robot, tmp_path):
    write_gait(tmp_path / "gait.json", gait)
    scenario = make_scenario(completed({"gait": [str(tmp_path / "gait.json")], "duration": 3.3, "cycles": 4}))
    summary = run_episode(scenario, robot=robot, record=False).summary
    assert not summary.fell
    assert summary.tracking.distance == pytest.approx(summary.tracking.planned_distance, rel=0.05)
    assert max(summary.tracking.tilt_deg.values()) < 4.0


def test_a_phase_says_what_its_support_does():
    assert not Phase("a", 1.0, "left", "air", (0.0, 0.0)).tips
    assert Phase("a", 1.0, "left", "air", (0.0, 0.0), support_contact="toe").tips
