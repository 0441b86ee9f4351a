"""Soles are what touches the ground, whatever shape the foot has and however it is tilted at the zero pose."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.adoption.made_up import TRAPEZOID, MadeUp

from gaitsmith.adoption.anatomy import find_anatomy
from gaitsmith.adoption.soles import GivenSole, SoleFound, find_sole, measured_sole, rocking
from gaitsmith.errors import BadInput
from gaitsmith.robots.sole import Sole

NEAR = 1e-4  # m


def soles(made: MadeUp) -> list[SoleFound]:
    anatomy = find_anatomy(made.model(), "made_up.xml")
    return [find_sole(leg, anatomy, "made_up.xml") for leg in anatomy.legs]


@pytest.mark.parametrize("traits", [{}, {"turned": 2.0}, {"waist": 2}, {"slant": 0.5}, {"bend": 0.6}])
def test_box(traits: dict[str, float]) -> None:
    for sole in soles(MadeUp(**traits)):  # type: ignore[arg-type]
        assert sole.kind == "rectangle"
        assert (sole.heel, sole.toe, sole.half_width) == pytest.approx((0.06, 0.12, 0.04), abs=NEAR)
        bend = traits.get("bend", 0.0)
        assert sole.axes[2, 2] == pytest.approx(math.cos(bend), abs=1e-3)


@pytest.mark.parametrize("traits", [{}, {"turned": math.pi}, {"waist": 1}, {"reversed_joints": ("pitch", "roll")}])
def test_trapezoid_is_a_polygon_counter_clockwise(traits: dict[str, object]) -> None:
    for sole in soles(MadeUp(sole="trapezoid", **traits)):  # type: ignore[arg-type]
        assert sole.kind == "polygon"
        corners = {tuple(np.round(point, 4)) for point in sole.points}
        assert corners == {(x, y) for x, y in TRAPEZOID}
        x, y = sole.points.T
        assert x @ np.roll(y, -1) - y @ np.roll(x, -1) > 0.0


def test_capsule_is_a_line() -> None:
    for sole in soles(MadeUp(sole="line")):
        assert (sole.kind, sole.heel, sole.toe) == ("line", pytest.approx(0.06), pytest.approx(0.12))


def test_a_foot_without_ankle_roll_has_a_line_whatever_its_shape() -> None:
    for shape in ("box", "trapezoid"):
        assert {sole.kind for sole in soles(MadeUp(ankle=("pitch",), sole=shape))} == {"line"}


def test_wide_feet_without_ankle_roll_are_noted() -> None:
    for made, noted in ((MadeUp(ankle=("pitch",)), ["a foot 8 cm wide"]), (MadeUp(ankle=("pitch",), sole="line"), [])):
        anatomy = find_anatomy(made.model(), "made_up.xml")
        notes = rocking([find_sole(leg, anatomy, "made_up.xml") for leg in anatomy.legs])
        assert [note[:16] for note in notes] == noted


def test_a_ball_is_refused() -> None:
    with pytest.raises(BadInput, match="in a point"):
        soles(MadeUp(sole="ball"))


def test_measured_sole_is_below_the_ankle() -> None:
    anatomy = find_anatomy(MadeUp(sole="none").model(), "made_up.xml")
    sole = measured_sole(anatomy.legs[0], anatomy, GivenSole(0.05, 0.15, 0.04, 0.06))
    assert np.allclose(anatomy.legs[0].ankle - sole.position, [0.0, 0.0, 0.06])
    assert sole.entry() == {"kind": "rectangle", "heel": 0.05, "toe": 0.15, "half_width": 0.04}


def test_a_wheel_is_refused() -> None:
    with pytest.raises(BadInput, match="a wheel"):
        soles(MadeUp(ankle=("pitch",), sole="wheel"))


def test_corners_are_written_so_that_the_card_can_be_read() -> None:
    points = np.array([[-0.05, -0.03], [0.0, -0.03003], [0.1, -0.03], [0.10002, -0.02999], [0.12, 0.0], [-0.05, 0.03]])
    sole = SoleFound("polygon", points, 1, np.zeros(3), np.eye(3), "made up")
    assert len(Sole.model_validate(sole.entry()).corners) == 4


def test_round_soles_keep_their_mirror_image() -> None:
    anatomy = find_anatomy(MadeUp(sole="disc").model(), "made_up.xml")
    left, right = (find_sole(leg, anatomy, "made_up.xml") for leg in anatomy.legs)
    assert left.kind == "polygon"
    assert {tuple(p) for p in np.round(left.points, 9)} == {(x, -y) for x, y in np.round(right.points, 9)}
