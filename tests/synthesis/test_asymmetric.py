"""A robot whose halves differ, with a joint outside its legs: a stride planned on the real model, the joint held."""

from importlib import resources

import numpy as np
import pytest

from gaitsmith.errors import BadInput
from gaitsmith.robots import load_robot
from gaitsmith.synthesis import Planner, StepParameters, verify
from gaitsmith.synthesis.gaits.walkable import walkable
from gaitsmith.synthesis.motions.biped import biped_from
from gaitsmith.synthesis.motions.catalogue import cyclic
from gaitsmith.synthesis.motions.contacts import check_contacts
from gaitsmith.synthesis.motions.motion import Phase

ARM = """<body name="arm" pos="0 0.1 0.2"><joint name="swing" axis="0 1 0" range="-1 1"/>
<inertial pos="0 0 -0.1" mass="0.3" diaginertia="0.001 0.001 0.0001"/></body>
"""
LIMIT = "swing = { position = [-1.0, 1.0], velocity = 8.0, torque = 2.0 }\n"


def _with_arm(folder, torque="2.0"):
    """THBIP-II with an arm on one side only."""
    source = resources.files("gaitsmith.robots") / "thbip_ii"
    head, leg, tail = (source / "thbip_ii.xml").read_text().partition('<body name="right_hip_yaw"')
    (folder / "thbip_ii.xml").write_text(head + ARM + leg + tail)
    card = (source / "card.toml").read_text().replace("mass = 18.0", "mass = 18.3")
    (folder / "card.toml").write_text(card.replace("[limits]\n", "[limits]\n" + LIMIT.replace("2.0 }", torque + " }")))
    return load_robot(folder)


@pytest.fixture(scope="module")
def lopsided(tmp_path_factory):
    return _with_arm(tmp_path_factory.mktemp("lopsided"))


@pytest.fixture(scope="module")
def gait(lopsided):
    planner = Planner(lopsided)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("GAITSMITH_CC", "none")  # once is not worth compiling
        found = planner.plan(cyclic(planner.biped, StepParameters(0.2, 0.5)))
    assert found.status == "solved", found.reason
    return found.gait


def test_left_and_right_are_found_by_where_they_lie(lopsided):
    biped = biped_from(lopsided)
    names = lopsided.joint_names
    swapped = {name: names[partner] for name, partner in zip(names, biped.partner, strict=True)}
    assert swapped.pop("swing") == "swing"
    for name, other in swapped.items():
        assert other == (name.replace("left", "right") if "left" in name else name.replace("right", "left"))


@pytest.mark.parametrize(("support", "other"), [("right", (0.1, 0.065)), ("left", (0.0, -0.065))])
def test_a_cycle_ends_on_the_feet_it_begins_on(support, other):
    begin = Phase("shift", 0.5, "right", "flat", (0.0, -0.065), (0.0, 0.065))
    swing = Phase("swing", 0.5, "right", "air", (0.0, -0.065))
    place = (0.0, -0.065) if support == "right" else (0.1, 0.065)
    phases = (begin, swing, Phase("end", 0.5, "right", "flat", (0.0, -0.065), (0.1, 0.065)))
    phases += (Phase("change", 0.5, support, "flat", place, other),)
    with pytest.raises(BadInput, match="at the start"):
        check_contacts(phases, True, ("support_at", "other_at"))


def test_the_difference_is_measured_and_only_legs_and_freed_joints_move(lopsided):
    held, freed = biped_from(lopsided, ()), biped_from(lopsided, ("swing",))
    assert 0.001 < held.asymmetry < 0.5
    assert (held.joints, len(held.held), freed.joints) == (12, 1, 13)
    with pytest.raises(BadInput, match="outside the legs: swing"):
        biped_from(lopsided, ("left_knee",))


def test_both_steps_are_planned_and_hold_on_the_real_model(gait, lopsided):
    assert [phase.support for phase in gait.motion.phases[::5]] == ["right", "left"]
    assert not gait.motion.mirrored
    verdict = verify(gait, lopsided, 100)
    assert verdict.ok, verdict.problems


def test_the_held_joint_stays_and_bears_its_load(gait, lopsided):
    arm = lopsided.joint_names.index("swing")
    q, v, _ = gait.joints(0, np.linspace(0.0, 0.1, 5))
    assert np.ptp(q[arm]) == np.abs(v[arm]).max() == 0.0
    assert 0.01 < np.abs(gait.torques(0, np.linspace(0.0, 0.1, 5))[arm]).max() < 2.0
    assert "swing torque" in {item["constraint"] for item in gait.certificate["worst"]}


def test_a_stride_is_walked_in_whole_strides(gait, lopsided):
    plan = walkable([gait], lopsided, 6)
    assert abs(plan.way(plan.duration).x - 6 * 0.2) < 1e-6
    with pytest.raises(BadInput, match="even number"):
        walkable([gait], lopsided, 3)
