"""Only the page's own controls reach the page, and only those who may open it do."""

from __future__ import annotations

import asyncio
import math
from types import SimpleNamespace

import msgspec.msgpack
import pytest
from websockets import Headers

from gaitsmith.live.guard import Guard, acceptable

UPDATE = {"type": "GuiUpdateMessage", "uuid": "u", "updates": {"value": 0.5}}
CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": [1.0, 0.0, 0.0, 0.0],
    "position": [1.0, 1.0, 1.0],
    "look_at": [0.0, 0.0, 0.0],
    "up_direction": [0.0, 0.0, 1.0],
    "fov": 0.8,
}


def packed(content):
    return msgspec.msgpack.encode(content)


@pytest.mark.parametrize("content", [UPDATE, CAMERA, {"type": "CommandTriggerMessage", "uuid": "u"}])
def test_what_controls_send_is_let_through(content):
    assert acceptable(packed(content))


@pytest.mark.parametrize(
    "content",
    [
        UPDATE | {"updates": {"value": math.nan}},
        UPDATE | {"updates": {"value": math.inf}},
        UPDATE | {"updates": {"value": "x" * 1000}},
        UPDATE | {"updates": {"update_cb": []}},
        UPDATE | {"updates": {"value": 1.0, "uuid": "other"}},
        UPDATE | {"updates": {"value": [[[[[1.0]]]]]}},
        CAMERA | {"position": [1.0, 2.0]},
        CAMERA | {"wxyz": "up"},
        {"type": "ShareUrlRequest"},
        {"type": "FileTransferStartUpload", "name": "/etc/passwd"},
        {"type": "RunJavascriptMessage", "source": "alert(1)"},
        {"type": 3},
        [1, 2, 3],
        "word",
    ],
)
def test_nonsense_is_not(content):
    assert not acceptable(packed(content))


@pytest.mark.parametrize("message", [b"", b"\xc1", b"\x91" * 5000, packed(UPDATE | {"pad": "x" * 20_000})])
def test_bytes_that_mean_nothing_are_not(message):
    assert not acceptable(message)


def test_a_flood_waits_and_nonsense_is_counted(monkeypatch):
    messages = iter([b"\xc1"] * 700 + [packed(UPDATE)] * 300)
    slept = []

    async def recv():
        return next(messages)

    async def sleep(seconds):
        slept.append(seconds)

    async def take(connection):
        return [await connection.recv() for _ in range(300)]

    guard = Guard("", local=True)
    monkeypatch.setattr(asyncio, "sleep", sleep)
    asyncio.run(guard.handler(take)(SimpleNamespace(recv=recv)))
    assert guard.refused == 700
    assert len(slept) > 800  # all but the first hundred waited for their turn


@pytest.mark.parametrize(
    ("token", "path", "headers", "welcome"),
    [
        ("", "/", {"Host": "localhost:8080"}, True),
        ("", "/", {"Host": "127.0.0.1:8080", "Origin": "http://127.0.0.1:8080"}, True),
        ("", "/", {"Host": "[::1]:8080"}, True),
        ("", "/", {"Host": "evil.example:8080"}, False),
        ("", "/", {"Host": "localhost:8080", "Origin": "http://evil.example"}, False),
        ("secret", "/", {"Host": "10.0.0.1:8080"}, False),
        ("secret", "/?token=wrong", {"Host": "10.0.0.1:8080"}, False),
        ("secret", "/?token=secret", {"Host": "10.0.0.1:8080"}, True),
        ("secret", "/", {"Host": "10.0.0.1:8080", "Cookie": "gaitsmith=secret"}, True),
        ("secret", "/", {"Host": "10.0.0.1:8080", "Cookie": "gaitsmith=; other=secret"}, False),
        ("secret", "/?token=secret", {"Host": "10.0.0.1:8080", "Origin": "http://evil.example"}, False),
    ],
)
def test_who_may_open_the_page(token, path, headers, welcome):
    guard = Guard(token, local=not token)
    request = SimpleNamespace(path=path, headers=Headers(headers))
    page = SimpleNamespace(headers=Headers(), status_code=200)
    answer = guard.answer(lambda _connection, _request: page)(None, request)
    assert (answer is page) == welcome
    assert guard.turned_away == (not welcome)
    assert (answer.status_code == 200) == welcome
    assert ("Set-Cookie" in page.headers) == (welcome and bool(token))
