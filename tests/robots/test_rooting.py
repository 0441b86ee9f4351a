from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from tests.robots.samples import bhr_text, build, build_model, card_data

from gaitsmith.robots.rooting import root_at, turn_frame

Array = Any
CLOSE = 1e-9  # of numbers near 1 that are computed in another order

# Root, spine and waist above the pelvis; two joints on one body, a slide, frames, defaults, a mesh, excludes and pairs.
TREE = """<mujoco><compiler angle="degree"/>
<default><joint damping="0.3" armature="0.01"/>
<default class="odd"><geom density="700"/><joint damping="0.7"/></default></default>
<asset><mesh name="wedge" vertex="0 0 0  .1 0 0  0 .1 0  0 0 .1"/></asset>
<worldbody><body name="chest" pos="1 2 3" euler="10 20 30" childclass="odd"><freejoint name="float"/>
  <geom name="shell" size=".1"/><geom type="mesh" mesh="wedge"/><site name="eye" pos=".1 0 0"/>
  <body name="arm" pos="0 .2 0"><joint name="shoulder" axis="1 1 0"/><geom name="hand" size=".05"/></body>
  <frame euler="0 0 40"><body name="spine" pos="0 .05 -.2" euler="5 0 0">
    <joint name="bend" axis="0 1 .2" pos=".01 .02 .03" range="-40 30" springref="5" stiffness="3"/>
    <joint name="twist" axis="0 0 1" range="-50 60"/>
    <inertial pos=".01 0 0" mass="2" fullinertia=".02 .03 .04 .001 .002 .003"/>
    <frame pos="0 0 -.1"><body name="lift" pos=".02 0 0"><joint name="rise" type="slide" axis="0 .3 1" range="-.1 .2"/>
      <geom name="disc" size=".06" pos=".01 .02 0"/>
      <body name="pelvis" pos="0 .01 -.1" axisangle="0 0 1 25">
        <frame euler="0 30 0"><joint name="waist" axis="1 0 0" pos="0 0 .02" range="-20 70"/></frame>
        <geom name="bowl" size=".09" pos=".03 0 0"/>
        <body name="leg" pos="0 .1 -.1"><joint name="hip"/><geom name="shin" size=".04" pos="0 0 -.2"/></body>
      </body></body></frame></body></frame></body></worldbody>
<contact><exclude body1="chest" body2="leg"/><pair geom1="hand" geom2="shin" condim="1"/></contact>
<actuator><motor name="m" joint="bend" gear="7"/></actuator></mujoco>"""


def forward(model: mujoco.MjModel, torso: str, state: dict[str, tuple[float, float, float]], motion: Array) -> Any:
    """Forward dynamics with joint angles, rates and torques by name, and pose and velocity of one body."""
    model.opt.disableflags = mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    model.opt.enableflags = mujoco.mjtEnableBit.mjENBL_ENERGY
    data = mujoco.MjData(model)
    for name, (angle, rate, torque) in state.items():
        joint = data.joint(name)
        joint.qpos[0], joint.qvel[0], joint.qfrc_applied[0] = angle, rate, torque
    data.qpos[:7], data.qvel[:6] = motion[:7], motion[7:]
    mujoco.mj_forward(model, data)
    return data


def body_motion(model: mujoco.MjModel, data: mujoco.MjData, name: str) -> Array:
    """Pose and velocity of a body as those of a free joint."""
    body, velocity = model.body(name).id, np.zeros(6)
    mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, body, velocity, 0)
    turn = data.xmat[body].reshape(3, 3)
    return np.concatenate([data.xpos[body], data.xquat[body], velocity[3:], turn.T @ velocity[:3]])


@pytest.mark.parametrize("torso", ["pelvis", "lift", "spine", "leg", "arm"])
def test_any_body_may_be_the_root_of_the_same_robot(torso: str) -> None:
    before = mujoco.MjSpec.from_string(TREE).compile()
    spec, notes = mujoco.MjSpec.from_string(TREE), []
    root_at(spec, torso, "model.xml", notes)
    spec.body(torso).add_freejoint(name="float")
    after = spec.compile()
    assert "chest" in notes[0]
    assert (after.nexclude, after.npair, after.nu, after.nsite) == (1, 1, 1, 1)
    assert {after.geom(i).name for i in range(after.ngeom)} == {before.geom(i).name for i in range(before.ngeom)}
    joints = [before.joint(i).name for i in range(1, before.njnt)]
    for name in joints:
        for field in ("range", "armature", "damping", "stiffness", "limited"):
            assert getattr(after.joint(name), field) == pytest.approx(getattr(before.joint(name), field)), name
    random = np.random.default_rng(1)
    for _ in range(5):
        state = {name: tuple(random.normal(scale=0.5, size=3)) for name in joints}
        turn = random.normal(size=4)
        motion = np.concatenate([random.normal(size=3), turn / np.linalg.norm(turn), random.normal(size=6)])
        old = forward(before, "chest", state, motion)
        new = forward(after, torso, state, body_motion(before, old, torso))
        assert new.energy == pytest.approx(old.energy, abs=CLOSE)
        assert new.subtree_com[0] == pytest.approx(old.subtree_com[0], abs=CLOSE)
        assert new.site("eye").xpos == pytest.approx(old.site("eye").xpos, abs=CLOSE)
        for name in joints:
            assert new.joint(name).qacc == pytest.approx(old.joint(name).qacc, abs=1e3 * CLOSE), name
        for name in ("hand", "shin", "bowl", "disc", "shell"):
            assert new.geom(name).xpos == pytest.approx(old.geom(name).xpos, abs=CLOSE), name


@pytest.mark.parametrize("torso", ["chest", "spine"])
def test_a_turned_frame_leaves_the_robot_where_it_is(torso: str) -> None:
    specs = [mujoco.MjSpec.from_string(TREE) for _ in range(2)]
    turn = np.array([0.5, 0.1, -0.7, 0.2]) / np.linalg.norm([0.5, 0.1, -0.7, 0.2])
    for spec in specs:
        root_at(spec, torso, "model.xml", [])
        if not spec.body(torso).joints:
            spec.body(torso).add_freejoint(name="float")
    turn_frame(specs[1], specs[1].body(torso), list(turn), "model.xml")
    before, after = (spec.compile() for spec in specs)
    random = np.random.default_rng(2)
    state = {before.joint(i).name: tuple(random.normal(scale=0.5, size=3)) for i in range(1, before.njnt)}
    motion = np.concatenate([[0.1, 0.2, 0.3, 1.0, 0.0, 0.0, 0.0], random.normal(size=6)])
    old = forward(before, torso, state, motion)
    spin = np.empty(3)
    mujoco.mju_rotVecQuat(spin, motion[10:], turn * [1, -1, -1, -1])
    new = forward(after, torso, state, np.concatenate([motion[:3], turn, motion[7:10], spin]))
    assert new.energy == pytest.approx(old.energy, abs=CLOSE)
    assert new.subtree_com[0] == pytest.approx(old.subtree_com[0], abs=CLOSE)
    for name in state:
        assert new.joint(name).qacc == pytest.approx(old.joint(name).qacc, abs=1e3 * CLOSE), name
    for name in ("hand", "shin", "bowl", "disc", "shell"):
        assert new.geom(name).xpos == pytest.approx(old.geom(name).xpos, abs=CLOSE), name


def test_a_card_names_the_torso_below_the_root(tmp_path: Path) -> None:
    above = """<body name="chest" pos="0 0 1.2"><freejoint/><inertial pos="0 0 0" mass="3" diaginertia=".1 .1 .1"/>
      <body name="torso" pos="0 0 -0.5"><joint name="waist" axis="0 0 1" range="-1 1"/>"""
    text = bhr_text().replace('<body name="torso" pos="0 0 0.7">\n      <freejoint name="root"/>', above)
    data = card_data()
    data["mass"] += 3.0
    data["limits"]["waist"] = {"position": [-0.9, 1.0], "velocity": 3.0, "torque": 20.0}
    robot = build_model(text.replace("</worldbody>", "</body></worldbody>"), tmp_path, data)
    model = robot.model
    assert model.body("torso").parentid == 0
    assert model.body("chest").parentid == model.body("torso").id
    assert model.joint("waist").bodyid == model.body("chest").id
    assert robot.position_low[robot.joint_names.index("waist")] == -0.9
    assert any("rooted" in note for note in robot.notes)
    assert robot.legs[0].hip_anchor == pytest.approx(build(card_data()).legs[0].hip_anchor)


def test_a_card_turns_the_torso_frame(tmp_path: Path) -> None:
    start = bhr_text().index('<site name="imu"')
    end = bhr_text().index("</worldbody>")
    last = bhr_text().rindex("</body>", 0, end)
    text = bhr_text()[:start] + '<frame quat="0 0 0 1">' + bhr_text()[start:last] + "</frame>" + bhr_text()[last:]
    backward = card_data() | {"torso_frame": {"rpy": [0.0, 0.0, np.pi]}}
    robot, plain = build_model(text, tmp_path, backward), build(card_data())
    for field in ("body_pos", "body_ipos", "site_pos", "geom_pos", "jnt_axis", "body_inertia"):
        assert getattr(robot.model, field)[2:] == pytest.approx(getattr(plain.model, field)[2:], abs=CLOSE), field
    assert robot.imu_position == pytest.approx(plain.imu_position)
    assert robot.imu_rotation == pytest.approx(plain.imu_rotation, abs=CLOSE)
