"""A model without a card: what is welded, left out or coupled, and that the rest is the same robot."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from gaitsmith.errors import BadInput
from gaitsmith.robots.model_file import ModelFile, open_model

ROUNDING = 1e-9
BODY = """
<mujoco><compiler angle="radian" autolimits="true"/>
  <default><default class="looks"><geom contype="0" conaffinity="0" group="2" mass="0"/></default></default>
  <asset><mesh name="hull" file="there/../none.stl"/></asset>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="torso"><freejoint/><inertial pos="0 0 .1" mass="5" diaginertia=".1 .1 .1"/>
      <geom class="looks" type="mesh" mesh="hull"/>
      <geom size=".1"/>
      <frame euler="0 .4 .1" pos=".1 0 0">
        <body name="arm" pos="0 .2 .1" euler=".3 .2 .1">
          <joint name="lift" axis="1 .2 0" pos="0 .01 .02" range="-1 2"/>
          <joint name="twist" axis="0 0 1" pos=".02 0 0" range=".5 1.5" ref=".2"/>
          <joint name="slide" type="slide" axis="0 1 1" range="-.1 .1"/>
          <geom size=".05" pos="0 0 .1"/>
          <body name="hand" pos="0 0 .2"><joint name="grip" axis="0 1 0"/><geom size=".03" mass=".2"/>
            <body name="nail" pos="0 0 .05"><geom size=".01" mass=".1"/></body></body>
        </body>
      </frame>
    </body>
  </worldbody>
  EXTRA
</mujoco>
"""
KEY = '<keyframe><key qpos="0 0 1 1 0 0 0 .7 .9 5 .3"/></keyframe>'


def opened(folder: Path, extra: str = "", **arguments: object) -> ModelFile:
    (folder / "m.xml").write_text(BODY.replace("EXTRA", extra))
    return open_model(folder / "m.xml", **arguments)  # type: ignore[arg-type]


def placed(file: ModelFile, **angles: float) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Pose of every body with the torso at the origin."""
    data = mujoco.MjData(file.model)
    for name, angle in angles.items():
        data.qpos[file.model.joint(name).qposadr[0]] = angle
    data.qpos[:3] = 0.0
    mujoco.mj_kinematics(file.model, data)
    return {file.model.body(b).name: (data.xpos[b].copy(), data.xmat[b].copy()) for b in range(1, file.model.nbody)}


@pytest.mark.parametrize(
    "welded", [["lift"], ["twist"], ["slide"], ["twist", "lift"], ["lift", "twist", "slide", "grip"]]
)
def test_a_welded_joint_stays_at_its_angle(tmp_path: Path, welded: list[str]) -> None:
    free = opened(tmp_path)
    angles = {"lift": 0.4, "twist": 1.1, "slide": 0.05, "grip": -0.7}
    fixed = opened(tmp_path, weld=welded, home={name: angles[name] for name in welded})
    assert set(fixed.limits) == set(angles) - set(welded)
    rest = {name: angle for name, angle in angles.items() if name not in welded}
    for name, (position, rotation) in placed(free, **angles).items():
        assert placed(fixed, **rest)[name][0] == pytest.approx(position, abs=ROUNDING), name
        assert placed(fixed, **rest)[name][1] == pytest.approx(rotation, abs=ROUNDING), name
    assert fixed.model.body_mass.sum() == pytest.approx(free.model.body_mass.sum())
    assert any("welded" in note for note in fixed.notes)


def test_a_reference_angle_moves_the_frame_not_the_joint(tmp_path: Path) -> None:
    (tmp_path / "plain.xml").write_text(BODY.replace("EXTRA", ""))
    spec = mujoco.MjSpec.from_string(BODY.replace("EXTRA", ""))
    for geom in [geom for geom in spec.geoms if geom.meshname]:
        spec.delete(geom)
    spec.delete(spec.meshes[0])
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qpos[:] = [0, 0, 0, 1, 0, 0, 0, 0.4, 1.1, 0.05, -0.7]
    mujoco.mj_kinematics(model, data)
    found = placed(opened(tmp_path), lift=0.4, twist=1.1, slide=0.05, grip=-0.7)
    for name, (position, rotation) in found.items():
        assert data.body(name).xpos == pytest.approx(position, abs=ROUNDING)
        assert data.body(name).xmat == pytest.approx(rotation, abs=ROUNDING)


def test_home_is_given_or_the_keyframe_or_off_the_stops(tmp_path: Path) -> None:
    assert opened(tmp_path).home == {"lift": 0.0, "twist": 1.0, "slide": 0.0, "grip": 0.0}
    keyed = opened(tmp_path, KEY, home={"lift": 0.1}).home
    assert keyed == {"lift": 0.1, "twist": 0.9, "slide": 0.0, "grip": 0.3}  # 5 is outside the slide's range
    for home in ({"lift": 3.0}, {"nobody": 0.0}):
        with pytest.raises(BadInput, match="home"):
            opened(tmp_path, home=home)


def test_ignored_bodies_go_with_what_hangs_on_them(tmp_path: Path) -> None:
    file = opened(tmp_path, '<contact><exclude body1="hand" body2="torso"/></contact>', ignore=["hand"])
    assert [file.model.body(b).name for b in range(1, file.model.nbody)] == ["torso", "arm"]
    assert "grip" not in file.limits
    assert any("hand, nail" in note for note in file.notes)
    for name in ("torso", "nobody", "world"):
        with pytest.raises(BadInput, match="ignore"):
            opened(tmp_path, ignore=[name])


COUPLED = {
    "joint": ('<equality><joint joint1="grip" joint2="lift"/></equality>', {"grip", "lift"}),
    "inactive": ('<equality><joint joint1="grip" joint2="lift" active="false"/></equality>', set()),
    "loop": ('<equality><connect body1="hand" body2="arm" anchor="0 0 0"/></equality>', {"grip"}),
    "tendon": ('<tendon><fixed stiffness="3"><joint joint="lift" coef="1"/></fixed></tendon>', {"lift"}),
    "measured": ('<tendon><fixed name="t"><joint joint="lift" coef="1"/></fixed></tendon>', set()),
    "pulled": (
        '<tendon><fixed name="t"><joint joint="lift" coef="1"/></fixed></tendon>'
        '<actuator><motor tendon="t"/></actuator>',
        {"lift"},
    ),
}


@pytest.mark.parametrize("case", COUPLED)
def test_coupled_joints_are_welded_outside_the_legs_and_refused_inside(tmp_path: Path, case: str) -> None:
    extra, names = COUPLED[case]
    assert set(opened(tmp_path, extra).coupled) == names
    outside = opened(tmp_path, extra, legs=["slide"])
    assert set(outside.limits) == {"lift", "twist", "slide", "grip"} - names
    assert any("coupled" in note for note in outside.notes) == bool(names)
    for name in names:
        with pytest.raises(BadInput, match=f"joint {name}"):
            opened(tmp_path, extra, legs=[name])
    assert opened(tmp_path, extra, weld=["lift", "grip"], legs=["twist"]).coupled == {}


def test_other_bodies_of_a_scene_are_not_the_robot(tmp_path: Path) -> None:
    text = BODY.replace("EXTRA", "").replace(
        '<body name="torso">',
        '<body name="ball" pos="2 0 0"><freejoint/><geom size=".1"/></body><body/><body name="torso">',
    )
    (tmp_path / "m.xml").write_text(text)
    file = open_model(tmp_path / "m.xml")
    assert file.root == "torso"
    assert "ball" not in [body.name for body in file.spec.bodies]
    assert file.scene is not None
    assert [body.name for body in file.scene.worldbody.bodies] == ["ball"]
    (tmp_path / "m.xml").write_text(text.replace('size=".1"', 'size="-.1"'))
    alone = open_model(tmp_path / "m.xml")
    assert alone.scene is None
    assert any("MuJoCo refuses, ball" in note and "size" in note for note in alone.notes)


def test_torque_limits_are_what_the_actuators_can_give(tmp_path: Path) -> None:
    drives = (
        '<actuator><motor joint="lift" gear="3" ctrlrange="-2 2"/><position joint="twist" kp="9" ctrlrange="-1 1"/>'
        '<position joint="grip" kp="9" forcerange="-4 5"/><velocity joint="grip" forcerange="-1 1"/></actuator>'
    )
    limits = opened(tmp_path, drives).limits
    assert [limits[name].torque for name in ("lift", "twist", "slide", "grip")] == [6.0, None, None, 5.0]
    assert limits["lift"].position == (-1.0, 2.0)
    assert limits["grip"].position is None


def test_looks_are_never_read_but_what_collides_must_be_there(tmp_path: Path) -> None:
    assert list(opened(tmp_path).files) == ["m.xml"]
    text = BODY.replace("EXTRA", "").replace('class="looks" type="mesh"', 'type="mesh"')
    (tmp_path / "m.xml").write_text(text)
    with pytest.raises(BadInput, match=r"mesh file: got 'there/\.\./none\.stl'"):
        open_model(tmp_path / "m.xml")


def test_a_file_too_large_to_be_a_model_is_refused_unread(tmp_path: Path) -> None:
    with open(tmp_path / "robot.xml", "wb") as file:
        file.truncate(10**12)  # takes no room on the disk; in memory it would
    with pytest.raises(BadInput, match="expected at most"):
        open_model(tmp_path / "robot.xml")
