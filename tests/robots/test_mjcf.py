from __future__ import annotations

import re
import struct
from pathlib import Path

import numpy as np
import pytest
from tests.robots.samples import bhr_text, build_model, card_data

from gaitsmith.errors import BadInput
from gaitsmith.robots import Robot

TEXT = bhr_text()
END = "</mujoco>"
TORSO = '<freejoint name="root"/>'

REFUSED = {
    "tendon": (END, '<tendon><fixed stiffness="9"><joint joint="left_knee" coef="1"/></fixed></tendon>'),
    "closed loop": (END, '<equality><connect body1="left_foot" body2="right_foot" anchor="0 0 0"/></equality>'),
    "plugin": (END, '<extension><plugin plugin="mujoco.pid"/></extension>'),
    "ball joint": ('<joint name="left_knee" class="knee"/>', '<joint name="left_knee" type="ball"/>'),
    "missing joint": ('<joint name="left_knee" class="knee"/>', ""),
    "joint without name": ('<joint name="left_knee" class="knee"/>', '<joint class="knee"/>'),
    "planar root": (TORSO, '<joint name="x" type="slide"/>'),
    "negative mass": ('mass="29.3"', 'mass="-29.3"'),
    "negative geom mass": ('<geom name="torso"', '<geom mass="-1" name="torso"'),
    "zero mass": ('mass="1.046" diaginertia="0.0008 0.001 0.0009"', 'mass="0" diaginertia="0 0 0"'),
    "impossible inertia": ('diaginertia="1.131 0.536 0.684"', 'diaginertia="9 0.536 0.684"'),
    "not a number": ('mass="29.3"', 'mass="nan"'),
    "infinite": ('mass="29.3"', 'mass="1e400"'),
    "text for a number": ('mass="29.3"', 'mass="heavy"'),
    "other mass than the card's": ('mass="29.3"', 'mass="30.3"'),
    "floating by gravity compensation": ('<body name="torso"', '<body name="torso" gravcomp="1"'),
    "replicate": (TORSO, TORSO + '<replicate count="1000000000"><geom size="1"/></replicate>'),
    "composite": (TORSO, TORSO + '<composite type="particle" count="1000 1000 1000"/>'),
    "mesh builtin": (END, '<asset><mesh name="m" builtin="sphere" params="99"/></asset>'),
    "mesh outside": (TORSO, f'<geom type="mesh" mesh="m"/>{TORSO}', '<asset><mesh name="m" file="../m.stl"/></asset>'),
    "mesh missing": (TORSO, f'<geom type="mesh" mesh="m"/>{TORSO}', '<asset><mesh name="m" file="m.stl"/></asset>'),
    "body actuator": (END, '<actuator><adhesion name="t" body="left_foot" ctrlrange="0 1"/></actuator>'),
    "unknown attribute": ('mass="29.3"', 'mass="29.3" colour="red"'),
    "unknown class": ('class="knee"', 'class="elbow"'),
    "duplicate name": ('"left_knee" class', '"right_knee" class'),
    "no site": ('<site name="left_sole"', '<site name="sole"'),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_represented_is_refused(tmp_path: Path, case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    old, new, *more = REFUSED[case]
    text = TEXT.replace(old, new + old if old in (END,) else new, 1).replace(END, "".join(more) + END)
    assert text != TEXT
    with pytest.raises(BadInput) as caught:
        build_model(text, tmp_path)
    assert "\n" not in str(caught.value)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["model.xml"]


def same_motion(first: Robot, second: Robot) -> None:
    for name in (
        "body_mass",
        "body_inertia",
        "body_ipos",
        "jnt_axis",
        "jnt_range",
        "dof_armature",
        "actuator_ctrlrange",
    ):
        assert getattr(first.model, name) == pytest.approx(getattr(second.model, name), abs=1e-12), name


def test_left_out_parts_are_named(tmp_path: Path) -> None:
    extra = (
        '<size memory="1E"/><option gravity="0 0 9" density="1000"/><visual/><statistic extent="2"/>'
        '<keyframe><key qpos="1"/></keyframe><sensor><gyro site="imu"/></sensor>'
        '<asset><hfield name="h" nrow="100000" ncol="100000" size="1 1 1 1"/></asset>'
        '<worldbody><geom type="hfield" hfield="h"/></worldbody>'
        '<asset><texture name="t" type="2d" file="/etc/passwd"/><material name="m" texture="t"/></asset>'
    )
    text = TEXT.replace(END, extra + END).replace(TORSO, TORSO + '<light pos="0 0 1"/>')
    robot = build_model(text, tmp_path)
    same_motion(robot, build_model(TEXT, tmp_path))
    assert robot.model.opt.gravity.tolist() == [0.0, 0.0, -9.81]
    for kind in ("size", "option", "keyframe", "sensor", "texture", "light", "hfield"):
        assert kind in robot.notes[0]


def test_free_joint_motors_and_floor(tmp_path: Path) -> None:
    plain = build_model(TEXT, tmp_path)
    text = TEXT.replace(TORSO, "").replace("<worldbody>", '<worldbody><geom type="plane" size="1 1 1"/>')
    text = re.sub(r"<actuator>.*</actuator>", "", text, flags=re.DOTALL)
    robot = build_model(text, tmp_path)
    robot.model.actuator_ctrlrange[:] = plain.model.actuator_ctrlrange
    same_motion(robot, plain)
    assert any("assumed, the model gives none: torque limit" in note for note in robot.notes)
    assert robot.model.nq == 15
    assert robot.model.ngeom == plain.model.ngeom
    assert {"free joint", "torque motors", "shapes fixed"} <= {
        phrase for phrase in ("free joint", "torque motors", "shapes fixed") for note in robot.notes if phrase in note
    }


def test_actuators_become_plain_motors_in_joint_order(tmp_path: Path) -> None:
    lines = re.findall(r"    <motor name=.*\n", TEXT)
    servo = '    <position joint="left_knee" kp="50" gear="3" forcerange="-70 70"/>\n'
    text = TEXT.replace("".join(lines), "".join(reversed(lines))).replace(lines[6], servo)
    text = text.replace('<motor gear="1"/>', '<motor gear="7" forcerange="-99 99"/>')
    robot = build_model(text, tmp_path)
    model = robot.model
    assert model.actuator_gear.tolist() == [[1, 0, 0, 0, 0, 0]] * 8
    assert not model.actuator_forcelimited.any()
    assert model.actuator_gainprm[:, 0].tolist() == [1.0] * 8
    assert not model.actuator_biasprm.any()
    assert [model.actuator(a).name for a in range(8)] == list(robot.joint_names)
    assert model.actuator_trnid[:, 0].tolist() == list(range(1, 9))
    assert any("replaced" in note for note in robot.notes)


def test_degrees_are_converted(tmp_path: Path) -> None:
    def degrees(match: re.Match[str]) -> str:
        return 'range="' + " ".join(repr(float(np.degrees(float(n)))) for n in match[1].split()) + '"'

    text = re.sub(r' range="([^"]*)"', lambda m: " " + degrees(m), TEXT).replace('angle="radian"', 'angle="degree"')
    same_motion(build_model(text, tmp_path), build_model(TEXT, tmp_path))


def test_meshes_below_the_card_are_used(tmp_path: Path) -> None:
    corners = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]], dtype=np.float32)
    faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    stl = bytes(80) + struct.pack("<I", 4)
    for face in faces:
        stl += struct.pack("<3f", 0, 0, 0) + b"".join(corners[i].tobytes() for i in face) + b"\0\0"
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "tip.stl").write_bytes(stl)
    text = TEXT.replace('angle="radian"', 'angle="radian" meshdir="meshes"')
    text = text.replace(END, '<asset><mesh file="tip.stl"/></asset>' + END)
    text = text.replace(TORSO, TORSO + '<geom type="mesh" mesh="tip" contype="0"/>')
    robot = build_model(text, tmp_path)
    assert robot.model.nmesh == 1
    assert robot.make_spec().compile().nmesh == 1
    (tmp_path / "meshes" / "tip.stl").write_bytes(stl[:-20])
    robot = build_model(text, tmp_path)
    assert robot.model.nmesh == 0
    assert any("left out the shape of torso" in note for note in robot.notes)


def test_root_element_is_known(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="root element"):
        build_model("<sdf/>", tmp_path, card_data())
