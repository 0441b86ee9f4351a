"""Between the network and the page: who may open it, and which messages reach it.

A page that steers a robot must not be steered by another site in the same browser, by a stranger on the network, or by
nonsense. What is refused is counted; a client that sends too much waits, nobody else does.
"""

from __future__ import annotations

import asyncio
import hmac
import http
import math
from collections.abc import Awaitable, Callable
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs, urlsplit

import msgspec.msgpack
from websockets import Headers
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request, Response

_KINDS = {"ViewerCameraMessage", "GuiUpdateMessage", "CommandTriggerMessage", "SceneNodeDragMessage"}
_LARGEST = 16_384  # bytes of a message
_LONGEST = 200  # characters of a word in it
_DEEPEST = 3
_RATE, _BURST = 300.0, 100.0  # messages a second, and at once
_COOKIE = "gaitsmith"
_LOCAL = {"localhost", "127.0.0.1", "::1"}
_FORBIDDEN = "Open this page by the address that gaitsmith live has printed.\n"

Handler = Callable[[Any], Awaitable[None]]
Answer = Callable[[ServerConnection, Request], Response | None]


class Guard:
    """Lets in who knows the token, and passes on what the page's controls can say.

    Args:
        token: that the address must carry; empty for none.
        local: whether only the names of this machine are good addresses, so that no other name can be led here.

    Attributes:
        refused: messages that were thrown away.
        turned_away: requests that were not let in.
    """

    def __init__(self, token: str, local: bool) -> None:
        self._token, self._local = token, local
        self.refused, self.turned_away = 0, 0

    def answer(self, inner: Answer) -> Answer:
        """The server's answer to a request, after a look at who asks."""

        def answer(connection: ServerConnection, request: Request) -> Response | None:
            if not self._welcome(request):
                self.turned_away += 1
                headers = Headers(**{"Content-Type": "text/plain", "Content-Length": str(len(_FORBIDDEN))})
                return Response(http.HTTPStatus.FORBIDDEN, "Forbidden", headers, _FORBIDDEN.encode())
            response = inner(connection, request)
            if response is not None:
                response.headers["X-Frame-Options"] = "DENY"
                response.headers["Referrer-Policy"] = "no-referrer"
                if self._token:
                    response.headers["Set-Cookie"] = f"{_COOKIE}={self._token}; HttpOnly; SameSite=Strict; Path=/"
            return response

        return answer

    def _welcome(self, request: Request) -> bool:
        """Whether somebody may come in: by a good address, from this page, with the token."""
        host, origin = request.headers.get("Host", ""), request.headers.get("Origin")
        try:
            if self._local and urlsplit(f"//{host}").hostname not in _LOCAL:
                return False
            if origin is not None and urlsplit(origin).netloc != host:
                return False
            if not self._token:
                return True
            told = parse_qs(urlsplit(request.path).query).get("token", [""])
            cookies = SimpleCookie(request.headers.get("Cookie", ""))
        except (ValueError, CookieError):
            return False
        kept = cookies[_COOKIE].value if _COOKIE in cookies else ""
        return any(hmac.compare_digest(word.encode(), self._token.encode()) for word in (told[0], kept))

    def handler(self, inner: Handler) -> Handler:
        """The server's handler of a connection, behind a sieve."""

        async def handle(connection: ServerConnection) -> None:
            await inner(_Sieve(connection, self))

        return handle


class _Sieve:
    """A connection from which only good messages come, and not too many; all else is the connection's own."""

    def __init__(self, connection: ServerConnection, guard: Guard) -> None:
        self._connection, self._guard = connection, guard
        self._left, self._seen = _BURST, 0.0

    def __getattr__(self, name: str) -> Any:
        return getattr(self._connection, name)

    async def recv(self) -> bytes:
        """The next good message."""
        while True:
            message = await self._connection.recv()
            await self._slow_down()
            if isinstance(message, bytes) and acceptable(message):
                return message
            self._guard.refused += 1

    async def _slow_down(self) -> None:
        """Wait if there were too many messages; meanwhile the network holds the rest back."""
        now = asyncio.get_running_loop().time()
        self._left = min(_BURST, self._left + _RATE * (now - self._seen))
        self._seen = now
        if self._left < 1.0:
            await asyncio.sleep((1.0 - self._left) / _RATE)
        self._left -= 1.0


def acceptable(message: bytes) -> bool:
    """Whether a message is one that the page's controls send, and all its numbers are finite."""
    if len(message) > _LARGEST:
        return False
    try:
        content = msgspec.msgpack.decode(message)
    except (msgspec.MsgspecError, ValueError, RecursionError):
        return False
    if not isinstance(content, dict) or content.get("type") not in _KINDS or not _plain(content, _DEEPEST):
        return False
    if content["type"] == "GuiUpdateMessage":
        updates = content.get("updates")
        return isinstance(updates, dict) and set(updates) == {"value"} and isinstance(content.get("uuid"), str)
    return _complete(content)


_FIELDS = {
    "ViewerCameraMessage": {"wxyz": 4, "position": 3, "look_at": 3, "up_direction": 3},
    "SceneNodeDragMessage": {"start_position": 3, "end_position": 3, "start_screen_pos": 2, "end_screen_pos": 2},
}


def _complete(content: dict[str, Any]) -> bool:
    """Whether the vectors of a message have their lengths."""
    wanted = _FIELDS.get(content["type"], {})
    return all(_is_vector(content.get(name), size) for name, size in wanted.items())


def _is_vector(value: Any, size: int) -> bool:
    return isinstance(value, list) and len(value) == size and all(type(item) in (int, float) for item in value)


def _plain(value: Any, depth: int) -> bool:
    """Whether a value is made of finite numbers and short words, and not too deep."""
    if value is None or isinstance(value, bool):
        return True
    if isinstance(value, (int, float)):
        return math.isfinite(value) and abs(value) < 1e12
    if isinstance(value, str):
        return len(value) <= _LONGEST
    if depth == 0 or not isinstance(value, (list, dict)) or len(value) > 32:
        return False
    items = value.values() if isinstance(value, dict) else value
    return all(_plain(item, depth - 1) for item in items)
