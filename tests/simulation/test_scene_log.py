"""The log shows itself: a robot that moves in programs of others, in schemas that they publish."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import foxglove.messages
import mujoco
import numpy as np
import pytest
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from mcap.reader import make_reader

from gaitsmith import load_robot, read_log
from gaitsmith.cli import main
from gaitsmith.log import Log, protobuf
from gaitsmith.simulation.scene_log import SceneLog, positions
from gaitsmith.simulation.shapes_log import body_entity, body_points, cloud

ROBOT = load_robot("bhr_b2")
BODIES = sorted({ROBOT.model.body(int(body)).name for body in ROBOT.model.geom_bodyid})
TOPICS = {"/tf": "FrameTransforms", "/joint_states": "JointStates", "/robot": "SceneUpdate", "/steps": "SceneUpdate"}
TOPICS |= {f"/points/{name}": "PointCloud" for name in BODIES}


@cache
def decoder(schema: str) -> Any:
    """The message class of a schema as Foxglove's own library has it."""
    pool = descriptor_pool.DescriptorPool()
    known = getattr(foxglove.messages, schema).get_schema()
    for file in descriptor_pb2.FileDescriptorSet.FromString(known.data).file:
        pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName(known.name))


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("scene") / "run"
    words = ["walk", "--duration", "2", "--rest-before", "0.4", "--speed", "0.3", "--terrain", "boxes:0.01"]
    assert main([*words, "--no-figures", "--out", str(folder)]) == 0
    return folder


@pytest.fixture(scope="module")
def log(run: Path) -> Log:
    return read_log(run / "log.mcap")


@pytest.fixture(scope="module")
def seen(run: Path) -> dict[str, list[tuple[int, Any]]]:
    """Time and message of every topic that is drawn, as a public reader finds them."""
    found: dict[str, list[tuple[int, Any]]] = {}
    with (run / "log.mcap").open("rb") as file:
        for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages():
            if channel.topic in TOPICS:
                assert schema is not None
                made = getattr(foxglove.messages, TOPICS[channel.topic]).get_schema()
                assert (schema.name, schema.encoding, schema.data) == (made.name, made.encoding, made.data)
                content = decoder(TOPICS[channel.topic]).FromString(message.data)
                found.setdefault(channel.topic, []).append((message.log_time, content))
    return found


def row_at(log: Log, stamp: int) -> int:
    return int(np.argmin(np.abs(log.time - stamp / 1e9)))


def test_bodies_and_joints_are_where_the_rows_say(seen: dict[str, list[tuple[int, Any]]], log: Log) -> None:
    data = mujoco.MjData(ROBOT.model)
    where = positions(log, ROBOT)
    assert 25 <= len(seen["/tf"]) / log.time[-1] <= 35
    assert np.ptp(np.diff([stamp for stamp, _ in seen["/tf"]])) < 2, "evenly, across chunks too"
    for (stamp, transforms), (_, states) in zip(seen["/tf"], seen["/joint_states"], strict=True):
        row = row_at(log, stamp)
        data.qpos[:] = where[row]
        mujoco.mj_kinematics(ROBOT.model, data)
        for body, transform in enumerate(transforms.transforms, 1):
            told, turn = transform.translation, transform.rotation
            assert (transform.parent_frame_id, transform.child_frame_id) == ("world", ROBOT.model.body(body).name)
            np.testing.assert_array_equal([told.x, told.y, told.z], data.xpos[body])
            np.testing.assert_array_equal([turn.w, turn.x, turn.y, turn.z], data.xquat[body])
            assert transform.timestamp.seconds * 10**9 + transform.timestamp.nanos == stamp
        assert [joint.name for joint in states.joints] == list(ROBOT.joint_names)
        for joint in states.joints:
            assert joint.position == log.column(f"joint_position.{joint.name}")[row]
            assert joint.velocity == log.column(f"joint_velocity.{joint.name}")[row]
            assert joint.effort == log.column(f"torque.{joint.name}")[row]


def test_arrows_are_as_long_as_the_forces_and_marks_where_soles_land(
    seen: dict[str, list[tuple[int, Any]]], log: Log
) -> None:
    weight, lands = ROBOT.mass * 9.81, list[float]()
    touchdowns = np.flatnonzero(np.diff(log.column("step_count")) > 0) + 1
    for stamp, update in seen["/steps"]:
        row = row_at(log, stamp)
        forces, foothold = update.entities
        for leg, arrow in zip(ROBOT.legs, forces.arrows, strict=True):
            expected = 0.6 * ROBOT.card.gait.height * log.column(f"true.{leg.name}_force")[row] / weight
            assert arrow.shaft_length == pytest.approx(expected, rel=1e-3)
            assert arrow.pose.position.x == log.column(f"true.{leg.name}_sole_x")[row]
        (mark,) = foothold.cubes
        assert (mark.size.x > 0.0) == (log.column("mode")[row] == 1.0)
        later = touchdowns[touchdowns > row]
        if mark.size.x and len(later) and log.time[later[0]] - log.time[row] < 0.04:
            landed = ROBOT.legs[1 - int(log.column("stance")[row])]
            middle = 0.5 * (landed.sole.toe - landed.sole.heel)
            lands.append(mark.pose.position.x - middle - log.column(f"true.{landed.name}_sole_x")[later[0]])
    assert lands
    assert np.abs(lands).max() < 0.03


def test_every_body_with_a_shape_and_the_ground_are_drawn_once(seen: dict[str, list[tuple[int, Any]]]) -> None:
    ((_, update),) = seen["/robot"]
    named = {entity.id: entity for entity in update.entities}
    shaped = {ROBOT.model.body(int(body)).name for body in ROBOT.model.geom_bodyid}
    assert shaped | {"ground"} == set(named)
    assert all(entity.frame_id == name for name, entity in named.items() if name != "ground")
    foot = named["left_foot"]
    assert len(foot.cylinders) == 1
    assert len(foot.spheres) == 2, "a capsule's ends"
    assert len(named["ground"].cubes) > 20


def test_the_model_goes_with_the_log_and_ticks_have_times(run: Path, log: Log) -> None:
    with (run / "log.mcap").open("rb") as file:
        reader = make_reader(file)
        (attached,) = reader.iter_attachments()
        laps = [json.loads(message.data) for _, _, message in reader.iter_messages(topics="/tick_times")]
    assert attached.data == ROBOT.model_path.read_bytes()
    assert sum(lap["ticks"] for lap in laps) == 2000
    assert all(0.0 < lap["median"] <= lap["p99"] <= lap["max"] for lap in laps if lap["ticks"])


def test_a_cut_log_that_is_repaired_still_moves(run: Path, tmp_path: Path) -> None:
    content = (run / "log.mcap").read_bytes()
    (tmp_path / "log.mcap").write_bytes(content[: len(content) - 400])
    assert main(["log", "check", str(tmp_path / "log.mcap")]) == 0
    counts = []
    for path in (run / "log.mcap", tmp_path / "log.mcap"):
        with path.open("rb") as file:
            reader = make_reader(file, validate_crcs=True)
            summary = reader.get_summary()
            assert summary is not None
            assert summary.statistics is not None
            topics = {summary.channels[k].topic: n for k, n in summary.statistics.channel_message_counts.items()}
            read = dict.fromkeys(topics, 0)
            for _, channel, _ in reader.iter_messages():
                read[channel.topic] += 1
            assert read == topics
            assert len(list(reader.iter_attachments())) == 1
            counts.append(topics)
    assert counts[0] == counts[1]


def test_a_bare_body_is_a_rod_and_a_fine_mesh_its_hull(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    ball = rng.standard_normal((5000, 3))
    ball /= np.linalg.norm(ball, axis=1, keepdims=True)
    corners = " ".join(f"{x:.6f}" for x in (0.1 * ball).ravel())
    triangles = " ".join(str(k) for k in rng.permutation(5000)[:4998])
    text = f"""<mujoco><asset><mesh name="ball" vertex="{corners}" face="{triangles}"/></asset><worldbody>
      <body name="bare"><joint/><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>
        <body name="end" pos="0 0 -0.4"><joint/><geom type="mesh" mesh="ball"/></body></body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    robot: Any = SimpleNamespace(model=model, card=SimpleNamespace(gait=SimpleNamespace(height=0.7)))
    made = []
    for body in (1, 2):
        form = body_entity(robot, body, model.body(body).name)
        assert form is not None
        content = protobuf.filled(protobuf.message(2, form), np.zeros((1, 0)), np.zeros(1, np.uint64)).tobytes()
        made.append(decoder("SceneUpdate").FromString(content).entities[0])
    (rod,) = made[0].cylinders
    assert (rod.size.z, rod.pose.position.z) == (pytest.approx(0.4), pytest.approx(-0.2))
    (hull,) = made[1].triangles
    points = np.array([(p.x, p.y, p.z) for p in hull.points])
    assert len(hull.indices) % 3 == 0
    assert max(hull.indices) < len(points)
    assert np.linalg.norm(points, axis=1).max() < 0.2


def test_points_move_with_their_bodies(seen: dict[str, list[tuple[int, Any]]]) -> None:
    for name in BODIES:
        ((_, points),) = seen[f"/points/{name}"]
        assert points.frame_id == name, "the transforms' frame: no set-up"
        assert [(field.name, field.offset, field.type) for field in points.fields] == [
            ("x", 0, 7),
            ("y", 4, 7),
            ("z", 8, 7),
        ]
        assert points.pose.orientation.w == 1.0
        told = np.frombuffer(points.data, "<f4").reshape(-1, points.point_stride // 4)
        np.testing.assert_allclose(told, body_points(ROBOT, ROBOT.model.body(name).id), atol=1e-6)


@pytest.mark.parametrize("shape", ["box", "sphere", "ellipsoid", "cylinder", "capsule"])
def test_points_lie_on_their_shapes(shape: str) -> None:
    placed = f'<geom type="{shape}" size="0.1 0.2 0.3" pos="0.3 0.1 0.2" euler="20 40 60"/>'
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody><body><joint/>{placed}</body></worldbody></mujoco>")
    robot: Any = SimpleNamespace(model=model)
    points, turned = body_points(robot, 1), np.zeros(9)
    mujoco.mju_quat2Mat(turned, model.geom_quat[0])
    middle = model.geom_pos[0]
    local = (points - middle) @ turned.reshape(3, 3)
    if shape == "capsule":  # rays of the engine miss its seams
        local[:, 2] -= np.clip(local[:, 2], -0.2, 0.2)
        np.testing.assert_allclose(np.linalg.norm(local, axis=1), 0.1)
    else:
        for way in points - middle:
            start = middle + 3.0 * way
            meets = mujoco.mju_rayGeom(middle, turned, model.geom_size[0], start, -3.0 * way, model.geom_type[0])
            assert meets == pytest.approx(2.0 / 3.0, abs=1e-6), "a ray to the middle meets the shape there"
    assert np.ptp((points - middle) @ turned.reshape(3, 3), axis=0).min() > 0.19, "all around"


def test_a_cloud_of_a_bare_body_is_its_rod() -> None:
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><worldbody><body><joint/><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>
        <body pos="0 0 -0.4"><joint/><geom size="0.1"/></body></body></worldbody></mujoco>"""
    )
    robot: Any = SimpleNamespace(model=model, card=SimpleNamespace(gait=SimpleNamespace(height=0.7)))
    points = body_points(robot, 1)
    assert np.ptp(points, axis=0).tolist() == [0.0, 0.0, pytest.approx(0.4)]
    form = protobuf.filled(cloud("bare", points), np.zeros((1, 0)), np.zeros(1, np.uint64)).tobytes()
    assert decoder("PointCloud").FromString(form).frame_id == "bare"


def test_a_robot_without_a_readable_model_has_no_attachment(tmp_path: Path) -> None:
    scene = SceneLog(replace(ROBOT, model_path=tmp_path / "gone.xml"), ("time",), 0.004)
    assert scene.attachment is None
