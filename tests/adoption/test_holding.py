"""What motors cannot hold while the robot stands is welded outside the legs, and is the reason of a fall inside."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.adoption.made_up import MadeUp

from gaitsmith.adoption import adopting
from gaitsmith.adoption.anatomy import find_anatomy
from gaitsmith.adoption.holding import held_loads, too_weak, unlike_limits, why_weak
from gaitsmith.adoption.options import AdoptOptions
from gaitsmith.robots import Robot


def loaded(made: MadeUp, folder: Path, scene: str = "") -> Robot:
    """The robot as adoption would test it."""
    folder.mkdir()
    (folder / "walker.xml").write_text(made.text())
    if scene:
        (folder / "place.xml").write_text(scene)
    seen: list[Robot] = []

    def examine(robot: Robot, *_: object, **__: object) -> None:
        seen.append(robot)
        raise KeyboardInterrupt

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(adopting, "examine", examine)
        with pytest.raises(KeyboardInterrupt):
            adopting.adopt(AdoptOptions(model=str(folder / "walker.xml"), out=str(folder / "out")))
    return seen[0]


def test_weak_joints_outside_the_legs_are_welded(tmp_path: Path) -> None:
    strong = loaded(MadeUp(arm_strength=40.0), tmp_path / "strong")
    load = held_loads(strong)["Ls0"]
    assert load == pytest.approx(4 * 9.81 * 0.22, rel=0.3)  # an arm of 4 kg, stretched forward
    assert not too_weak(strong)
    weak = loaded(MadeUp(arm_strength=0.8 * load), tmp_path / "weak")
    assert set(strong.joint_names) - set(weak.joint_names) == {"Ls0", "Rs0"}
    assert any(note.startswith("welded at home, as the card says: Ls0 -1.5") for note in weak.notes)


def test_weak_legs_are_named(tmp_path: Path) -> None:
    assert not why_weak(loaded(MadeUp(), tmp_path / "strong"))
    words = why_weak(loaded(MadeUp(strength=3.0), tmp_path / "weak"))
    assert words.startswith("leg motors too weak for its weight: ")
    assert "lk gives 3 of " in words


def test_limits_that_are_not_mirrored_are_told() -> None:
    for turned in ((), ("pitch", "roll")):
        made = MadeUp(reversed_joints=turned, turned=1.0)
        model = made.model()
        anatomy = find_anatomy(model, "made_up.xml")
        assert unlike_limits(model, anatomy) == ""
        model.jnt_range[anatomy.legs[0].knee] = [-1.0, 0.5]
        assert unlike_limits(model, anatomy).startswith("left and right limits differ: lk -1 to 0.5 but rk ")


def test_a_scene_beside_the_model_says_what_collides(tmp_path: Path) -> None:
    pairs = "".join(f'<pair geom1="{side}_sole" geom2="floor"/>' for side in "lr")
    floor = '<worldbody><geom name="floor" type="plane" size="0 0 1"/></worldbody>'
    scene = f'<mujoco><include file="walker.xml"/>{floor}<contact>{pairs}</contact></mujoco>'
    robot = loaded(MadeUp(sole="paired"), tmp_path / "in", scene)
    assert {leg.sole.kind for leg in robot.legs} == {"rectangle"}
    assert robot.model_path.name == "place.xml"
