"""Legs, roles, torso and forward direction are found whatever the model's author chose."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.adoption.made_up import MadeUp

from gaitsmith.adoption.anatomy import Anatomy, Flags, find_anatomy
from gaitsmith.adoption.refusals import Asked
from gaitsmith.adoption.soles import find_sole
from gaitsmith.errors import BadInput


def found(made: MadeUp, **flags: object) -> tuple[Anatomy, list[list[str]]]:
    model = made.model()
    coupled = {made.names.get(name, name): "equality joint" for name in made.coupled}
    anatomy = find_anatomy(model, "made_up.xml", coupled, Flags(**flags))  # type: ignore[arg-type]
    return anatomy, [[model.joint(j).name for j in leg.joints] for leg in anatomy.legs]


CHANGES = {
    "plain": MadeUp(),
    "roll first": MadeUp(hip=("roll", "pitch", "yaw")),
    "pitch first": MadeUp(hip=("pitch", "roll", "yaw")),
    "ankle roll before pitch": MadeUp(ankle=("roll", "pitch")),
    "no hip yaw": MadeUp(hip=("roll", "pitch"), ankle=("pitch",), sole="line"),
    "slanted": MadeUp(slant=0.6),
    "slanted the other way": MadeUp(slant=-0.6, hip=("roll", "yaw", "pitch")),
    "reversed": MadeUp(reversed_joints=("pitch",)),
    "all reversed": MadeUp(reversed_joints=("pitch", "roll", "yaw"), slant=0.3),
    "turned": MadeUp(turned=math.pi),
    "sideways": MadeUp(turned=math.pi / 2),
    "askew": MadeUp(turned=0.4),
    "waist": MadeUp(waist=1),
    "three waist joints": MadeUp(waist=3, turned=math.pi),
    "right leg first": MadeUp(sides=(-1, 1)),
    "trapezoid": MadeUp(sole="trapezoid"),
    "no shape": MadeUp(sole="none"),
    "toes": MadeUp(toes=True),
    "bent": MadeUp(bend=0.5),
    "half": MadeUp(scale=0.5),
}


@pytest.mark.parametrize("change", CHANGES)
def test_same_legs_and_roles_after_every_change(change: str) -> None:
    made = CHANGES[change]
    anatomy, joints = found(made)
    own = [f"h{k}" for k in range(len(made.hip))] + ["k"] + [f"a{k}" for k in range(len(made.ankle))]
    assert joints == [[f"l{name}" for name in own], [f"r{name}" for name in own]]
    for leg in anatomy.legs:
        assert leg.roles == (*made.hip, "pitch", *made.ankle)
        assert leg.joints.index(leg.knee) == len(made.hip)
        assert leg.roles[leg.joints.index(leg.ankle_pitch)] == "pitch"
        assert (leg.ankle_roll >= 0) == ("roll" in made.ankle)
        assert len(leg.toes) == made.toes


@pytest.mark.parametrize("change", CHANGES)
def test_torso_and_its_axes(change: str) -> None:
    made = CHANGES[change]
    anatomy, _ = found(made)
    model = made.model()
    assert model.body(anatomy.torso).name == "pelvis"
    c, s = math.cos(made.turned), math.sin(made.turned)
    turned = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    assert np.allclose(anatomy.axes, turned, atol=1e-6)


def test_flags_name_the_feet_and_a_body_that_is_none_is_refused() -> None:
    _, joints = found(MadeUp(extra_legs=1), feet=("l_ankle1", "r_ankle1"))
    assert [names[0] for names in joints] == ["lh0", "rh0"]
    with pytest.raises(BadInput, match="--feet"):
        found(MadeUp(), feet=("l_ankle1", "nothing"))
    with pytest.raises(BadInput, match="--torso"):
        found(MadeUp(), torso="l_shank")


def test_a_model_in_millimetres_is_refused() -> None:
    with pytest.raises(BadInput, match=r"got '\d{3} m', .*a model in other units than metres"):
        find_anatomy(MadeUp(scale=1000.0).model(), "made_up.xml")


def test_a_foot_without_shapes_below_an_ankle_with_one_is_the_foot() -> None:
    anatomy = find_anatomy(MadeUp(sole="none", ankle_ball=True).model(), "made_up.xml")
    assert [leg.roles[-2:] for leg in anatomy.legs] == [("pitch", "roll")] * 2
    assert not any(leg.shapes for leg in anatomy.legs)


def test_several_pairs_of_legs_are_asked_for_and_a_single_one_is_taken() -> None:
    with pytest.raises(Asked, match="4 limbs on the ground") as caught:
        found(MadeUp(extra_legs=1))
    assert caught.value.flag == "--feet"
    for feet in zip(caught.value.candidates[::2], caught.value.candidates[1::2], strict=True):
        assert len(found(MadeUp(extra_legs=1), feet=feet)[1]) == 2
    _, joints = found(MadeUp(tail=True))
    assert [names[0] for names in joints] == ["lh0", "rh0"]


@pytest.mark.parametrize(
    ("made", "words"),
    [
        (MadeUp(sides=(1,)), "one leg"),
        (MadeUp(ankle=()), "ankle"),
        (MadeUp(sole="stilt"), "half-way up the leg"),
        (MadeUp(coupled=("lk", "la0")), "coupled"),
    ],
)
def test_what_is_no_biped_is_refused_in_a_sentence_that_says_what_can_walk(made: MadeUp, words: str) -> None:
    with pytest.raises(BadInput) as caught:
        found(made)
    assert words in str(caught.value)
    assert "two legs" in str(caught.value)
    assert "\n" not in str(caught.value)


@given(
    hip=st.permutations(("roll", "pitch", "yaw")),
    ankle=st.permutations(("pitch", "roll")),
    slant=st.floats(-0.65, 0.65),
    turned=st.floats(-math.pi, math.pi),
    waist=st.integers(0, 3),
    backward=st.sets(st.sampled_from(("roll", "pitch", "yaw"))),
    sole=st.sampled_from(("box", "trapezoid", "line")),
    scale=st.floats(0.3, 1.5),
    mirrored=st.booleans(),
)
@settings(max_examples=60)
def test_legs_roles_and_axes_do_not_depend_on_how_the_model_was_drawn(
    hip: list[str],
    ankle: list[str],
    slant: float,
    turned: float,
    waist: int,
    backward: set[str],
    sole: str,
    scale: float,
    mirrored: bool,
) -> None:
    sides = (-1, 1) if mirrored else (1, -1)
    made = MadeUp(tuple(hip), tuple(ankle), slant, tuple(backward), turned, waist, sole, scale=scale, sides=sides)
    anatomy, joints = found(made)
    assert [names[0][0] for names in joints] == ["l", "r"]
    assert all(leg.roles == (*hip, "pitch", *ankle) for leg in anatomy.legs)
    assert np.allclose(anatomy.axes[:2, 0], [math.cos(turned), math.sin(turned)], atol=0.1)
    kinds = {"box": ("rectangle", 0.06, 0.04), "trapezoid": ("polygon", 0.05, 0.03), "line": ("line", 0.06, 0.0)}
    for leg in anatomy.legs:
        sole_found = find_sole(leg, anatomy, "made_up.xml")
        kind, heel, half_width = kinds[sole]
        assert sole_found.kind == kind
        assert (sole_found.toe, sole_found.half_width) == pytest.approx((0.12, half_width), abs=1e-3)
        assert sole_found.heel == pytest.approx(heel, abs=1e-3)
