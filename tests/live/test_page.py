"""The page shows what the loop has handed over, and asks only for what its controls allow; nobody needs to look."""

from __future__ import annotations

import asyncio
import http.client
import math
import socket
from types import SimpleNamespace

import numpy as np
import pytest
from tests.live.bench import Bench

from gaitsmith.errors import BadInput
from gaitsmith.live.desk import Desk
from gaitsmith.live.handover import Note, Ring
from gaitsmith.live.page import Page, make_frame
from gaitsmith.live.scene import OVERLAYS
from gaitsmith.live.server import Server, listen
from gaitsmith.live.walker import REGION
from gaitsmith.live.wishes import Kind
from gaitsmith.simulation.terrain import parse_terrain


class Shown:
    """A page beside a loop, in one process."""

    def __init__(self, folder):
        self.bench = Bench(folder, robot="thbip_ii", speed=[0.2, 0.0])
        simulation, walker = self.bench.walker.simulation, self.bench.walker
        self.robot = simulation.robot
        frame = make_frame(list(simulation.columns.names), self.robot, 0)
        frames = Ring(len(frame.row), 512, walker.frames.name)
        self.server = Server(listen("127.0.0.1", 0), "", "test")
        self.desk = Desk(self.bench.wishes, clock=lambda: self.now)
        self.now = 0.0
        scenario = {"robot": "thbip_ii", "speed": (0.2, 0.0)}
        self.page = Page(self.server, self.robot, frame, frames, Note(walker.note.name), self.desk, scenario)

    def go(self, pictures):
        for _ in range(pictures):
            self.bench.ticks(33)
            self.bench.walker.publish(0.0)
            self.page.update()
            self.now += 0.033


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    made = Shown(tmp_path_factory.mktemp("runs"))
    made.go(60)
    yield made
    made.server.stop()
    made.bench.close()


def buffered(shown):
    return len(shown.server._viser._websock_server._broadcast_buffer.message_from_id)


def test_bodies_marks_charts_and_state_are_those_of_the_latest_frame(shown):
    plant, scene, history = shown.bench.walker.simulation.plant, shown.page.scene, shown.page.history
    torso = shown.robot.torso_body
    np.testing.assert_allclose(scene._bodies[torso].position, plant.q[:3], atol=1e-6)
    np.testing.assert_allclose(scene._com.position[2], plant.com[2], atol=1e-6)
    assert history.rows[-1, 0] == pytest.approx(plant.time)
    assert "Walking" in shown.page._state()
    assert "late ticks" in shown.page._state()


def test_the_zmp_lies_in_the_support_polygon_and_the_hull_is_that_of_the_bearing_soles(shown):
    for _ in range(10):
        shown.go(1)
        pose = shown.page.scene.pose
        if len(pose.support) < 3:
            continue
        edges = np.roll(pose.support, -1, axis=0) - pose.support
        away = pose.zmp - pose.support
        assert (edges[:, 0] * away[:, 1] - edges[:, 1] * away[:, 0]).min() > -1e-3
        corners = np.concatenate([s for s, bears in zip(pose.soles, pose.bears, strict=True) if bears])
        assert np.ptp(pose.support, axis=0) == pytest.approx(np.ptp(corners[:, :2], axis=0))


def test_a_browser_that_never_reads_lets_nothing_grow(shown):
    shown.go(30)
    before = buffered(shown)
    shown.go(80)
    assert buffered(shown) <= before + 5


@pytest.mark.parametrize("value", [math.nan, math.inf, "fast", None, True, [1.0]])
def test_what_is_no_number_leaves_the_gait_as_it_is(shown, value):
    before = dict(shown.page.controls.gait)
    shown.page.controls.set_gait("speed_x", value)
    assert shown.page.controls.gait == before


def test_numbers_are_held_within_the_card_s_limits_and_only_the_latest_is_handed_over(shown):
    controls, limits, written = shown.page.controls, shown.robot.card.gait_limits, shown.bench.wishes.written
    for k in range(1000):
        controls.set_gait("speed_x", 1e9 * (-1) ** k)
    controls.set_gait("nonsense", 1.0)
    assert controls.gait["speed_x"] == controls._sliders["speed_x"].value == limits.speed_x[0]
    shown.desk.hand_over()
    assert shown.bench.wishes.written == written + 1
    controls.halt()
    shown.go(3)
    assert shown.bench.walker.simulation.controller.gait.speed == (0.0, 0.0)
    for _ in range(100):
        controls._nudge("yaw_rate", 1)
    assert controls.gait["yaw_rate"] == limits.yaw_rate[1]


def test_wishes_that_come_too_fast_are_dropped_and_counted(shown):
    shown.desk.hand_over()
    dropped, written = shown.desk.dropped, shown.bench.wishes.written
    shown.now += 10.0
    for _ in range(100):
        shown.desk.ask(Kind.RESET)
    for _ in range(100):
        shown.desk.ask(Kind.PAUSE, 0.0)
    shown.desk.hand_over()
    assert shown.bench.wishes.written == written + 16
    assert shown.desk.dropped == dropped + 184


def test_overlays_can_be_hidden(shown):
    scene = shown.page.scene
    for name in OVERLAYS:
        scene.show_overlay(name, False)
        assert not scene._groups[name].visible
        scene.show_overlay(name, True)


GROUNDS = ("slope:5", "cross:4", "boxes:0.02", "ice:0.2,1,2", "stairs:0.02,0.3,0.5,3", "flat")


@pytest.mark.parametrize("terrain", GROUNDS)
def test_every_ground_is_drawn_block_by_block(shown, terrain):
    shown.page.scene.set_ground(terrain, 1, REGION)
    drawn = shown.server.scene.get_handle_by_name("/world/ground/blocks")
    blocks = parse_terrain(terrain, 1).blocks(REGION)
    assert (drawn is None) == (not blocks)
    if blocks:
        np.testing.assert_allclose(drawn.batched_positions, [block.centre for block in blocks], rtol=1e-6)
        assert np.linalg.norm(drawn.batched_wxyzs, axis=1) == pytest.approx(np.ones(len(blocks)))


def test_a_fall_is_told_with_its_reason(shown):
    shown.desk.ask(Kind.PUSH, 0.0, 40.0, 0.0)
    shown.go(60)
    assert "Fell at" in shown.page._state()
    shown.now += 10.0
    shown.desk.ask(Kind.RESET)
    shown.go(3)
    assert "Fell" not in shown.page._state()


def test_a_pulled_torso_is_pulled_where_the_hand_goes(shown):
    asyncio.run(_dragged(shown, [0.1, 0.0, 0.0], "update"))
    shown.go(2)
    force = shown.bench.walker._shoves.force
    assert force[0] > 1.0
    assert force[1] == force[2] == 0.0
    asyncio.run(_dragged(shown, [0.1, 0.0, 0.0], "end"))
    shown.go(3)
    assert not shown.bench.walker._shoves.force.any()


async def _dragged(shown, to, phase):
    entry = shown.page.scene._torso._impl.drag_cb[0]
    await entry.callback(SimpleNamespace(start_position=(0.0, 0.0, 0.0), end_position=to, phase=phase))


def test_a_port_in_use_and_a_foreign_address_are_one_clear_error():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(BadInput, match="in use"):
            listen("127.0.0.1", port)
    with pytest.raises(BadInput, match="--host"):
        listen("203.0.113.1", 0)


@pytest.mark.parametrize(("host", "status"), [("localhost", 200), ("evil.example", 403)])
def test_the_page_is_served_to_this_machine_only(shown, host, status):
    port = int(shown.server.address.rsplit(":", 1)[1].rstrip("/"))
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
    connection.request("GET", "/", headers={"Host": f"{host}:{port}"})
    answer = connection.getresponse()
    assert answer.status == status
    assert (len(answer.read()) > 10_000) == (status == 200)
    connection.close()
