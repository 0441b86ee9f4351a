from __future__ import annotations

import json
import shutil
from pathlib import Path

import mujoco
import numpy as np
import pytest
from tests.robots.samples import BHR, MODELS, bhr_text, build, build_model, card_data, changed

from gaitsmith.errors import BadInput
from gaitsmith.robots import Robot, describe, load_robot, robot_names

# Table I of Han 2023: mass, then the inertia about the link's centre of mass.
TABLE = {
    "torso": (29.3, (1.131, 0.536, 0.684)),
    "hip": (1.046, (0.0008, 0.001, 0.0009)),
    "femur": (2.035, (0.015, 0.015, 0.002)),
    "tibia": (1.583, (0.0123, 0.0128, 0.0009)),
    "foot": (0.635, (0.0001, 0.0007, 0.0008)),
}
ROUNDING = 1e-12


@pytest.fixture(scope="module")
def bhr() -> Robot:
    return load_robot("bhr_b2")


def at_angles(robot: Robot, **angles: float) -> mujoco.MjData:
    """The robot upright with its hips at the origin; angles by the joint's name without its side."""
    data = mujoco.MjData(robot.model)
    data.qpos[:7] = [0, 0, 0, 1, 0, 0, 0]
    for index, name in enumerate(robot.joint_names):
        data.qpos[7 + index] = angles.get(name.split("_", 1)[1], 0.0)
    mujoco.mj_kinematics(robot.model, data)
    return data


def test_bhr_is_table_one(bhr: Robot) -> None:
    model = bhr.model
    assert bhr.mass == pytest.approx(39.898, abs=1e-9)
    for body in range(1, model.nbody):
        mass, inertia = TABLE[model.body(body).name.split("_")[-1]]
        assert model.body_mass[body] == mass
        assert np.abs(model.body_iquat[body][1:]).max() == 0.0 or sorted(inertia, reverse=True) == pytest.approx(
            model.body_inertia[body]
        )
        rotation = np.empty(9)
        mujoco.mju_quat2Mat(rotation, model.body_iquat[body])
        about = rotation.reshape(3, 3) @ np.diag(model.body_inertia[body]) @ rotation.reshape(3, 3).T
        assert about == pytest.approx(np.diag(inertia), abs=ROUNDING)
    assert model.dof_armature[:6].tolist() == [0.0] * 6
    assert model.dof_armature[6:] == pytest.approx(1e-4 * 17.43**2, rel=0.02)  # the card rounds 0.0304 to 0.03


def test_bhr_joint_order_is_equation_16(bhr: Robot) -> None:
    per_leg = ["hip_roll", "hip_pitch", "knee", "ankle"]
    assert list(bhr.joint_names) == [f"{side}_{joint}" for side in ("right", "left") for joint in per_leg]
    assert bhr.joint_dofs.tolist() == list(range(6, 14))
    assert bhr.torque_limit.tolist() == [100, 150, 200, 80] * 2
    assert [leg.name for leg in bhr.legs] == ["left", "right"]
    assert bhr.legs[0].joint_indices.tolist() == [4, 5, 6, 7]
    assert (bhr.legs[1].knee, bhr.legs[1].ankle_pitch, bhr.legs[1].ankle_roll) == (2, 3, -1)
    assert [leg.side for leg in bhr.legs] == [1, -1]


def test_bhr_lengths(bhr: Robot) -> None:
    straight = at_angles(bhr)
    for leg in bhr.legs:
        assert leg.hip_anchor == pytest.approx([0.0, leg.side * 0.175 / 2, 0.0])
        sole = straight.site(leg.sole_site).xpos
        assert sole == pytest.approx([0.0, leg.side * 0.0875, -0.7645])
    assert bhr.hip_midpoint == pytest.approx(np.zeros(3))


@pytest.mark.parametrize("height", [0.40, 0.48, 0.70, 0.74])
def test_bhr_reaches_every_height_with_flat_feet(bhr: Robot, height: float) -> None:
    half = np.arccos((height - 0.0645) / 0.7)
    angles = {"hip_pitch": -half, "knee": 2 * half, "ankle": -half}
    data = at_angles(bhr, **angles)
    for index, name in enumerate(bhr.joint_names):
        assert bhr.position_low[index] <= data.qpos[7 + index] <= bhr.position_high[index], name
    for leg in bhr.legs:
        assert data.site(leg.sole_site).xpos[[0, 2]] == pytest.approx([0.0, -height], abs=1e-9)
        assert data.site(leg.sole_site).xmat.reshape(3, 3) == pytest.approx(np.eye(3), abs=1e-9)


def test_bhr_contact_shapes(bhr: Robot) -> None:
    spec = bhr.make_spec()
    spec.worldbody.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[1, 1, 1])
    model = spec.compile()
    data = mujoco.MjData(model)

    def touching(height: float, spread: float, knee: float = 0.0) -> set[frozenset[str]]:
        mujoco.mj_resetData(model, data)
        data.qpos[2] = height
        data.qpos[[7, 11]] = spread, -spread
        data.qpos[[8, 9, 10]] = -knee / 2, knee, -knee / 2
        mujoco.mj_forward(model, data)
        return {frozenset(model.geom(g).name for g in contact.geom) for contact in data.contact}

    feet = {frozenset((f"{side}_foot", "floor")) for side in ("left", "right")}
    assert touching(0.7645 - 1e-4, 0.0) == feet
    assert touching(0.7645 + 1e-4, 0.0) == set()
    assert data.ncon == 0
    touching(0.7645 - 1e-4, 0.0)
    ends = np.sort([contact.pos[0] for contact in data.contact])
    assert ends == pytest.approx([-0.07, -0.07, 0.12, 0.12], abs=1e-3)
    crossed = touching(0.9, 0.11)
    assert frozenset(("left_foot", "right_foot")) in crossed
    assert touching(0.9, -0.3) == set()
    assert touching(0.9, 0.0, knee=2.4) == set()
    assert frozenset(("torso", "floor")) in touching(-0.2, 0.0)


def test_make_spec_has_the_same_indices(bhr: Robot) -> None:
    first, second = bhr.make_spec(), bhr.make_spec()
    first.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[1, 1, 1])
    model = first.compile()
    assert [model.joint(j).name for j in range(1, model.njnt)] == list(bhr.joint_names)
    assert model.body(bhr.torso_body).name == "torso"
    assert second.compile().ngeom == bhr.model.ngeom == model.ngeom - 1


def test_arrays_are_read_only(bhr: Robot) -> None:
    with pytest.raises(ValueError, match="read-only"):
        bhr.torque_limit[0] = 1e9
    with pytest.raises(AttributeError):
        bhr.mass = 1.0  # type: ignore[misc]


def test_describe_is_the_json_contract(bhr: Robot) -> None:
    shown = json.loads(json.dumps(describe(bhr), allow_nan=False))
    assert {"model_path", "mass", "joints", "legs", "limits", "assumptions"} <= set(shown)
    assert shown["joints"] == list(bhr.joint_names)
    assert set(shown["legs"][0]) == {"name", "joints", "sole_frame", "sole"}
    assert shown["legs"][0]["sole"] == {"kind": "line", "heel": 0.07, "toe": 0.12, "half_width": 0.0}
    file = mujoco.MjModel.from_xml_path(shown["model_path"])
    for leg in shown["legs"]:
        assert file.site(leg["sole_frame"]).id >= 0
    assert [file.joint(j).name for j in range(1, file.njnt)] == shown["joints"]
    assert set(shown["limits"]["left_knee"]) == {"position", "velocity", "torque"}
    for name, limits in shown["limits"].items():
        assert file.joint(name).range.tolist() == limits["position"]
        assert file.actuator(name).ctrlrange[1] == limits["torque"]


def test_other_robots_load_the_same_way() -> None:
    six = load_robot(MODELS / "six_joint_legs.toml")
    arms = load_robot(str(MODELS / "with_arms.toml"))
    assert six.mass == arms.mass == pytest.approx(18.0)
    assert (len(six.joint_names), len(arms.joint_names)) == (12, 18)
    for robot in (six, arms):
        assert [len(leg.joints) for leg in robot.legs] == [6, 6]
        assert robot.joint_names[robot.legs[0].ankle_roll] == "left_ankle_roll"
        assert robot.imu_position.tolist() == [0.02, 0.0, 0.1]
    assert arms.torque_limit[-1] == 15.0


def test_names_and_paths(tmp_path: Path) -> None:
    assert robot_names() == ("bhr_b2", "thbip_ii")
    shutil.copytree(BHR, tmp_path / "copy")
    robot = load_robot(tmp_path / "copy")
    assert robot.content_hash == load_robot("bhr_b2").content_hash
    assert robot.model_path == (tmp_path / "copy" / "bhr_b2.xml").resolve()
    text = bhr_text()
    (tmp_path / "copy" / "bhr_b2.xml").write_text(text.replace("<mujoco", "<!-- a change --><mujoco"))
    assert load_robot(tmp_path / "copy").content_hash != robot.content_hash
    for unknown in ("asimo", "", ".", "nul\0", "x" * 5000, tmp_path, tmp_path / "copy" / "bhr_b2.xml", "../bhr_b2"):
        with pytest.raises(BadInput, match=r"^robot: .*bhr_b2"):
            load_robot(unknown)


def test_sole_placed_by_body_and_rpy_equals_the_site(tmp_path: Path) -> None:
    data = card_data()
    for leg in data["legs"]:
        del leg["sole_site"]
        leg |= {"sole_body": f"{leg['name']}_foot", "sole_position": [0.0, 0.0, -0.0645], "sole_rpy": [0.1, 0.2, 0.3]}
    text = (
        bhr_text()
        .replace('<site name="left_sole"', '<site name="l"')
        .replace('<site name="right_sole"', '<site name="r"')
    )
    robot = build_model(text, tmp_path, data)
    (cr, cp, cy), (sr, sp, sy) = np.cos([0.1, 0.2, 0.3]), np.sin([0.1, 0.2, 0.3])
    roll = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    pitch = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    yaw = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    assert robot.legs[0].sole_rotation == pytest.approx(yaw @ pitch @ roll)
    assert robot.legs[0].sole_position.tolist() == [0.0, 0.0, -0.0645]
    assert describe(robot)["legs"][0]["sole_frame"] == "left_sole"
    assert robot.model.site("left_sole").id >= 0
    tipped = changed(data, "legs", 0, "sole_rpy", value=[3.14, 0.0, 0.0])
    with pytest.raises(BadInput, match="x forward and z up"):
        build_model(text, tmp_path, tipped)


def test_legs_that_are_swapped_left_for_right_are_refused() -> None:
    data = card_data()
    for leg in data["legs"]:
        leg["name"] = "left" if leg["name"] == "right" else "right"
    with pytest.raises(BadInput, match="the left hip at the larger y"):
        build(data)


def test_names_of_shipped_robots_may_be_written_with_dashes() -> None:
    assert load_robot("thbip-ii").content_hash == load_robot("thbip_ii").content_hash


@pytest.mark.parametrize("name", ["=head", "he\u00a0ad", "head\n", " head"])
def test_names_of_the_model_are_plain_text(name: str, tmp_path: Path) -> None:
    text = bhr_text().replace('<site name="imu"', f'<site name="{name}"/><site name="imu"')
    with pytest.raises(BadInput, match="printable"):
        build_model(text, tmp_path)


def test_a_scene_keeps_its_other_bodies_behind_the_robot(tmp_path: Path, bhr: Robot) -> None:
    ball = '<worldbody><body name="ball" pos="2 0 0.2"><joint type="ball"/>'
    ball += '<inertial pos="0 0 0" mass="3" diaginertia="0.01 0.01 0.01"/><geom size="0.1 0.1"/></body>'
    robot = build_model(bhr_text().replace("<worldbody>", ball), tmp_path)
    assert robot.mass == bhr.mass
    assert robot.joint_names == bhr.joint_names
    model = robot.make_spec().compile()
    assert [model.body(b).name for b in range(model.nbody)][bhr.model.nbody :] == ["ball"]
    assert model.nq == bhr.model.nq + 4
    assert model.body_mass[: bhr.model.nbody].tolist() == bhr.model.body_mass.tolist()
    assert model.body("ball").pos.tolist() == [2.0, 0.0, 0.2]
    assert robot.make_spec().compile().nbody == model.nbody


def test_meshes_are_found_from_the_file_that_names_them(tmp_path: Path) -> None:
    import struct

    corners = ((0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1))
    stl = bytes(80) + struct.pack("<I", 4)
    for face in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)):
        stl += bytes(12) + b"".join(struct.pack("<3f", *corners[k]) for k in face) + bytes(2)
    (tmp_path / "robot" / "meshes").mkdir(parents=True)
    (tmp_path / "robot" / "model").mkdir()
    (tmp_path / "robot" / "meshes" / "tip.stl").write_bytes(stl)
    (tmp_path / "secret.stl").write_bytes(stl)
    part = '<mujocoinclude><asset><mesh name="tip" file="NAME"/></asset></mujocoinclude>'
    text = bhr_text().replace('<freejoint name="root"/>', '<freejoint name="root"/><geom type="mesh" mesh="tip"/>')
    text = text.replace("<worldbody>", '<include file="parts/shapes.xml"/><worldbody>')
    (tmp_path / "robot" / "model" / "parts").mkdir()
    (tmp_path / "robot" / "model" / "model.xml").write_text(text)
    shapes = tmp_path / "robot" / "model" / "parts" / "shapes.xml"
    data = card_data() | {"model": "model/model.xml"}
    for name in ("../../meshes/tip.stl", "../meshes/tip.stl", "meshes/tip.stl", "package://any/robot/meshes/tip.stl"):
        shapes.write_text(part.replace("NAME", name))
        assert build(data, tmp_path / "robot").model.nmesh == 1
    for name in ("../../../secret.stl", str(tmp_path / "secret.stl"), "package://x/../secret.stl"):
        shapes.write_text(part.replace("NAME", name))
        with pytest.raises(BadInput, match="below the card's folder"):
            build(data, tmp_path / "robot")


def test_a_torso_above_the_waist_is_told_where_the_legs_meet(tmp_path: Path) -> None:
    text = bhr_text()
    head, tail = text.split('<body name="torso" pos="0 0 0.7">\n      <freejoint name="root"/>')
    chest = (
        '<body name="chest" pos="0 0 0.7"><freejoint name="root"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
    )
    waist = '<body name="torso"><joint name="waist" axis="0 0 1" range="-1 1" actuatorfrcrange="-50 50"/>'
    body, rest = tail.rsplit("</worldbody>", 1)
    text = f"{head}{chest}{waist}{body}</body></worldbody>{rest}"
    data = card_data() | {"mass": 40.898}
    assert "waist" in build_model(text, tmp_path, data).joint_names
    data.pop("imu_site")
    with pytest.raises(BadInput, match="torso: got 'chest', expected the body where the legs meet, torso"):
        build_model(text, tmp_path, data | {"torso": "chest"})
