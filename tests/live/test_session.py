"""Two processes: whatever comes over the network, the walk goes on; it ends with the page, and loses nothing."""

from __future__ import annotations

import contextlib
import os
import random
import time

import msgspec.msgpack
import pytest
import viser
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from gaitsmith.errors import BadInput
from gaitsmith.live.session import Session, token_for
from gaitsmith.live.wishes import Kind
from gaitsmith.robots import load_robot

CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": [1.0, 0.0, 0.0, 0.0],
    "position": [1.0, 1.0, 1.0],
    "fov": 0.8,
    "near": 0.1,
    "far": 100.0,
    "image_height": 480,
    "image_width": 640,
    "look_at": [0.0, 0.0, 0.0],
    "up_direction": [0.0, 0.0, 1.0],
}


def joined(address):
    """A browser's connection, as far as the server can tell."""
    made = connect("ws" + address[4:], subprotocols=[f"viser-v{viser.__version__}"], max_queue=1, open_timeout=30)
    made.send(msgspec.msgpack.encode(CAMERA))
    return made


def resident(pid):
    with open(f"/proc/{pid}/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def until(condition, seconds=60.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)


def test_a_flood_of_nonsense_and_a_browser_that_never_reads_do_not_disturb_the_walk(steered):
    page, rng = steered.page, random.Random(1)
    until(lambda: page.frame["live.time"] > 1.5)
    slider = page.controls._sliders["speed_x"]._impl.uuid
    mute = joined(steered.address)
    nonsense = [
        *({"updates": {"value": value}} for value in (float("nan"), 1e300, -1e9, "x", None, [[1]], {"a": 1})),
        *({"updates": {name: 1.0}} for name in ("uuid", "removed", "update_cb")),
    ]
    messages = [msgspec.msgpack.encode({"type": "GuiUpdateMessage", "uuid": slider, **m}) for m in nonsense]
    messages += [rng.randbytes(rng.randrange(1, 400)) for _ in range(50)]
    process = steered.session.walk._process.pid
    began, before = page.frame["live.time"], resident(process)
    sent = 0
    with contextlib.suppress(ConnectionClosed), joined(steered.address) as client:
        client.socket.settimeout(2.0)
        end = time.monotonic() + 2.0
        while time.monotonic() < end:
            with contextlib.suppress(TimeoutError):
                client.send(rng.choice(messages))
                sent += 1
    assert sent > 100
    until(lambda: page.frame["live.time"] > began + 1.0)
    assert page.frame["live.over"] == 0.0
    assert steered.session._server.guard.refused > 50
    low, high = load_robot("thbip_ii").card.gait_limits.speed_x
    assert low <= page.controls.gait["speed_x"] <= high
    assert resident(process) < before + 20.0
    mute.close()


def test_a_recording_that_goes_on_when_the_page_ends_is_a_whole_run(tmp_path):
    with pytest.raises(BadInput, match="speed"):
        Session({"robot": "bhr_b2", "speed": [99.0, 0.0]}, load_robot("bhr_b2"), "127.0.0.1", 0, str(tmp_path))
    made = Session({"robot": "bhr_b2", "duration": 1e6}, load_robot("bhr_b2"), "127.0.0.1", 0, str(tmp_path))
    made._desk.ask(Kind.RECORD, 1.0)
    began = time.monotonic()

    def enough():
        if made.page.words.get("recording") and made.page.frame["live.time"] > 0.5:
            raise KeyboardInterrupt
        assert time.monotonic() < began + 60.0

    with pytest.raises(KeyboardInterrupt):
        made.run(enough)
    folders = made.close()
    assert not made.walk.alive
    assert len(folders) == 1
    assert {file.name for file in tmp_path.glob("*/*")} == {"log.mcap", "scenario.toml", "summary.json"}


def test_only_another_address_than_this_machine_s_own_needs_a_token():
    assert token_for("127.0.0.1") == token_for("localhost") == ""
    assert len(token_for("0.0.0.0")) > 16
    assert token_for("0.0.0.0") != token_for("0.0.0.0")
