from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import mujoco
import numpy as np
import pytest
from tests.robots.samples import build_model, card_data

from gaitsmith.errors import BadInput
from gaitsmith.robots import Robot, describe, load_robot

AGREEMENT = 1e-9  # relative; MuJoCo diagonalises the URDF's inertias, which rounds


def numbers(values: Any) -> str:
    return " ".join(repr(float(value)) for value in values)


def as_urdf(robot: Robot, tilt: float = 0.0) -> Element:
    """A URDF with the robot's tree; armature aside. Feet carry fixed massless links `left_sole`, `right_sole`."""
    model = robot.model
    root = Element("robot", {"name": "twin"})
    SubElement(root, "material", {"name": "grey"})
    for body in range(1, model.nbody):
        link = SubElement(root, "link", {"name": model.body(body).name})
        rotation = np.empty(9)
        mujoco.mju_quat2Mat(rotation, model.body_iquat[body])
        # An inertial frame that is turned must give the same body.
        turned = np.array([[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]])
        axes = turned.T @ rotation.reshape(3, 3)
        inertia = axes @ np.diag(model.body_inertia[body]) @ axes.T
        inertial = SubElement(link, "inertial")
        SubElement(inertial, "origin", {"xyz": numbers(model.body_ipos[body]), "rpy": f"{tilt} 0 0"})
        SubElement(inertial, "mass", {"value": repr(float(model.body_mass[body]))})
        entries = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}
        SubElement(inertial, "inertia", {name: repr(float(inertia[at])) for name, at in entries.items()})
        visual = SubElement(SubElement(link, "visual"), "geometry")
        SubElement(visual, "mesh", {"filename": "package://nowhere/looks.dae"})
        shape = SubElement(SubElement(link, "collision"), "geometry")
        SubElement(shape, "cylinder", {"radius": "0.03", "length": "0.1"})
        if body == 1:
            continue
        index = int(model.body_jntadr[body])
        joint = SubElement(root, "joint", {"name": model.joint(index).name, "type": "revolute"})
        SubElement(joint, "origin", {"xyz": numbers(model.body_pos[body]), "rpy": "0 0 0"})
        SubElement(joint, "parent", {"link": model.body(int(model.body_parentid[body])).name})
        SubElement(joint, "child", {"link": model.body(body).name})
        SubElement(joint, "axis", {"xyz": numbers(model.jnt_axis[index])})
        low, high = model.jnt_range[index]
        limit = {"lower": repr(float(low)), "upper": repr(float(high)), "effort": "200", "velocity": "12"}
        SubElement(joint, "limit", limit)
    for leg in robot.legs:
        SubElement(root, "link", {"name": leg.sole_site})
        joint = SubElement(root, "joint", {"name": f"{leg.name}_fixed", "type": "fixed"})
        SubElement(joint, "origin", {"xyz": numbers(leg.sole_position), "rpy": "0 0 0"})
        SubElement(joint, "parent", {"link": model.body(leg.sole_body).name})
        SubElement(joint, "child", {"link": leg.sole_site})
    return root


def urdf_card() -> dict[str, Any]:
    """BHR-B2's card for a URDF: soles on their fixed links, no IMU site."""
    data = card_data()
    del data["imu_site"]
    for leg in data["legs"]:
        leg |= {"sole_body": leg.pop("sole_site"), "sole_position": [0.0, 0.0, 0.0]}
    return data


def build_urdf(root: Element, folder: Path) -> Robot:
    return build_model(ElementTree.tostring(root), folder, urdf_card())


@pytest.fixture(scope="module")
def bhr() -> Robot:
    return load_robot("bhr_b2")


def mass_matrix(robot: Robot, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    model = robot.make_spec().compile()
    model.dof_armature[:] = 0.0
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = q, v
    mujoco.mj_forward(model, data)
    matrix = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, matrix)
    return matrix, data.qfrc_bias.copy()


@pytest.mark.parametrize("tilt", [0.0, 0.3])
def test_urdf_equals_mjcf(bhr: Robot, tmp_path: Path, tilt: float) -> None:
    twin = build_urdf(as_urdf(bhr, tilt), tmp_path)
    assert twin.mass == pytest.approx(bhr.mass, rel=1e-12)
    assert twin.joint_names == bhr.joint_names
    random = np.random.default_rng(1)
    for _ in range(5):
        q = np.concatenate([random.normal(size=7), random.uniform(bhr.position_low, bhr.position_high)])
        q[3:7] /= np.linalg.norm(q[3:7])
        v = random.normal(size=14)
        for ours, theirs in zip(mass_matrix(twin, q, v), mass_matrix(bhr, q, v), strict=True):
            assert np.abs(ours - theirs).max() <= AGREEMENT * np.abs(theirs).max()
        places = []
        for robot in (bhr, twin):
            data = mujoco.MjData(robot.model)
            data.qpos[:] = q
            mujoco.mj_kinematics(robot.model, data)
            places.append(np.array([data.site(leg.sole_site).xpos for leg in robot.legs]))
        assert places[0] == pytest.approx(places[1], abs=1e-9)


def test_what_the_importer_drops_is_restored(bhr: Robot, tmp_path: Path) -> None:
    twin = build_urdf(as_urdf(bhr), tmp_path)
    model = twin.model
    assert model.body_mass[twin.torso_body] == 29.3
    assert (model.nq, model.nv, model.nu) == (15, 14, 8)
    assert model.body(twin.legs[0].sole_body).name == "left_sole"
    assert describe(twin)["legs"][0]["sole_frame"] == "left_sole"
    assert model.site("left_sole").id >= 0
    assert model.actuator_ctrlrange[:, 1].tolist() == twin.torque_limit.tolist()
    assert not model.jnt_actfrclimited.any()
    assert twin.imu_position.tolist() == [0.0, 0.0, 0.0]
    assert any("free joint" in note for note in twin.notes)
    bits = {model.body(int(model.geom_bodyid[g])).name: int(model.geom_contype[g]) for g in range(model.ngeom)}
    assert (bits["torso"], bits["left_foot"], bits["right_foot"]) == (0, 2, 4)


def test_a_massless_world_link_is_the_world(bhr: Robot, tmp_path: Path) -> None:
    root = as_urdf(bhr)
    SubElement(root, "link", {"name": "world"})
    joint = SubElement(root, "joint", {"name": "anchor", "type": "fixed"})
    SubElement(joint, "parent", {"link": "world"})
    SubElement(joint, "child", {"link": "torso"})
    assert build_urdf(root, tmp_path).mass == pytest.approx(bhr.mass)


def test_warnings_of_the_engine_are_notes(bhr: Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    root = as_urdf(bhr)
    for limit in root.iter("limit"):
        limit.set("upper", limit.get("lower", ""))
    assert any("equal lower and upper limits" in note for note in build_urdf(root, tmp_path).notes)
    assert [path.name for path in tmp_path.iterdir()] == ["model.xml"]


def edited(root: Element, case: str) -> None:
    """Change a good URDF into a bad one."""
    knee = next(joint for joint in root.findall("joint") if joint.get("name") == "left_knee")
    foot = next(link for link in root.findall("link") if link.get("name") == "left_foot")
    inertial = foot.find("inertial")
    assert inertial is not None
    mass = inertial.find("mass")
    assert mass is not None
    child = knee.find("child")
    assert child is not None
    match case:
        case "mimic":
            SubElement(knee, "mimic", {"joint": "right_knee"})
        case "planar" | "floating" | "magic":
            knee.set("type", case)
        case "negative mass":
            mass.set("value", "-0.635")
        case "other mass":
            mass.set("value", "0.935")
        case "mass in words":
            mass.set("value", "heavy")
        case "no inertia":
            foot.remove(inertial)
        case "two roots":
            SubElement(root, "link", {"name": "lonely"})
        case "loop":
            child.set("link", "torso")
        case "ring":
            for name, parent in (("a", "b"), ("b", "a")):
                SubElement(root, "link", {"name": name})
                joint = SubElement(root, "joint", {"name": f"ring_{name}", "type": "fixed"})
                SubElement(joint, "parent", {"link": parent})
                SubElement(joint, "child", {"link": name})
        case "no child":
            knee.remove(child)
        case "unknown link":
            child.set("link", "nobody")
        case "same link twice":
            SubElement(root, "link", {"name": "torso"})
        case "mesh outside" | "mesh missing":
            name = "package://robot/../secret.stl" if case == "mesh outside" else "package://robot/none.stl"
            SubElement(SubElement(SubElement(foot, "collision"), "geometry"), "mesh", {"filename": name})
        case "no shape":
            SubElement(foot, "collision")
        case "empty":
            root[:] = []
        case "long chain":
            for i in range(400):
                SubElement(root, "link", {"name": f"chain{i}"})


# What is wrong must be named: another check further on may refuse the file too, in words that help nobody.
CASES = {
    "mimic": "move independently",
    "planar": "planar",
    "floating": "floating",
    "magic": "magic",
    "negative mass": "kilograms",
    "other mass": "mass",
    "mass in words": "kilograms",
    "no inertia": "mass",
    "two roots": "exactly one link without a parent",
    "loop": "every link hangs from the root link",
    "ring": "every link hangs from the root link",
    "no child": "a parent and a child link",
    "unknown link": "a parent and a child link",
    "same link twice": "names that all differ",
    "mesh outside": "below the card's folder",
    "mesh missing": "mesh",
    "no shape": "one shape among",
    "empty": "links",
    "long chain": "links",
}


@pytest.mark.parametrize("case", CASES)
def test_bad_urdf_is_refused(bhr: Robot, tmp_path: Path, case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    root = as_urdf(bhr)
    edited(root, case)
    with pytest.raises(BadInput, match=CASES[case]) as caught:
        build_urdf(root, tmp_path)
    assert "\n" not in str(caught.value)
    assert [path.name for path in tmp_path.iterdir()] == ["model.xml"]
