"""Soles that meet the ground, and those that do not."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import mujoco
import pytest
from tests.robots.samples import MODELS, bhr_text, build, build_model, card_data, changed
from tests.robots.test_urdf import as_urdf, build_urdf

from gaitsmith.errors import BadInput
from gaitsmith.kinematics.posture import standing_posture
from gaitsmith.robots import load_robot
from gaitsmith.robots.footing import below_soles, check_soles


@pytest.mark.parametrize("name", ["bhr_b2", "thbip_ii", str(MODELS / "with_arms.toml")])
def test_soles_of_good_robots_meet_the_ground(name: str) -> None:
    check_soles(load_robot(name))


@pytest.mark.parametrize(
    ("entry", "value", "reason"),
    [("toe", 0.3, "at the toe"), ("heel", 0.2, "at the heel"), ("half_width", 0.1, "edge")],
)
def test_soles_larger_than_their_shapes_are_refused(entry: str, value: float, reason: str) -> None:
    path = MODELS / "with_arms.toml"
    robot = build(changed(card_data(path), "legs", 0, "sole", entry, value=value), MODELS)
    with pytest.raises(BadInput, match=rf"legs\[0\]\.sole: got '\d+ mm without a shape .*{reason}"):
        check_soles(robot)


@pytest.mark.parametrize(("shift", "reason"), [(0.02, "shapes below"), (-0.02, "no shape reaches")])
def test_sole_frames_off_their_shapes_are_refused(tmp_path: Path, shift: float, reason: str) -> None:
    text = bhr_text()
    place = text.index("pos=", text.index('<site name="left_sole"'))
    moved = f'{text[:place]}pos="0 0 {-0.0645 + shift}"{text[text.index(chr(34), place + 5) + 1 :]}'
    with pytest.raises(BadInput, match=reason):
        check_soles(build_model(moved, tmp_path))


def test_feet_without_shapes_are_refused(tmp_path: Path) -> None:
    root = as_urdf(load_robot("bhr_b2"))
    for link in root.iter("link"):
        if "foot" in link.get("name", ""):
            for shape in link.findall("collision"):
                link.remove(shape)
    with pytest.raises(BadInput, match="no shape that collides"):
        check_soles(build_urdf(root, tmp_path))


def test_shapes_fixed_above_or_below_the_soles_link_are_the_foot(tmp_path: Path) -> None:
    root = as_urdf(load_robot("bhr_b2"))
    for link in root.iter("link"):
        if "foot" in link.get("name", ""):
            for shape in link.iter("cylinder"):
                shape.tag, shape.attrib = "box", {"size": "0.2 0.06 0.129"}
            for origin in link.findall("collision"):
                ElementTree.SubElement(origin, "origin", {"xyz": "0.025 0 0"})
    robot = build_urdf(root, tmp_path)
    assert robot.model.body(robot.legs[0].sole_body).name == "left_sole"
    check_soles(robot)


def test_soles_that_collide_only_in_a_pair_with_the_ground_are_soles(tmp_path: Path) -> None:
    text = bhr_text().replace("<worldbody>", '<worldbody><geom name="floor" type="plane" size="1 1 1"/>')
    pairs = "".join(f'<pair geom1="floor" geom2="{side}_foot"/>' for side in ("left", "right"))
    for side in ("left", "right"):
        text = text.replace(f'<geom name="{side}_foot"', f'<geom name="{side}_foot" contype="0" conaffinity="0"')
    robot = build_model(text.replace("</mujoco>", f"<contact>{pairs}</contact></mujoco>"), tmp_path)
    check_soles(robot)
    assert robot.model.npair == 0
    assert isinstance(robot.make_spec(), mujoco.MjSpec)


def test_a_body_that_reaches_below_the_soles_is_named(tmp_path: Path) -> None:
    robot = load_robot("bhr_b2")
    gait = robot.card.gait
    q = standing_posture(robot, gait.height, gait.width)
    assert below_soles(robot, q) == {}
    shank = robot.model.body(robot.model.body_parentid[robot.legs[0].sole_body]).name
    text = bhr_text()
    end = text.index(">", text.index(f'<body name="{shank}"')) + 1
    ball = '<geom type="sphere" size="0.1" pos="0 0 -0.35" mass="0"/>'
    low = below_soles(build_model(text[:end] + ball + text[end:], tmp_path), q)
    assert list(low) == [shank]
    assert 0.0 < low[shank] < 0.1
