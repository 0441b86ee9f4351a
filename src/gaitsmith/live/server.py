"""The web server behind the page: viser on one address of its own, behind the guard."""

from __future__ import annotations

import contextlib
import errno
import logging
import os
import socket
from collections.abc import Iterator
from typing import Any
from unittest import mock

from gaitsmith.errors import BadInput
from gaitsmith.files import reason

try:
    import rich
    import viser
    import websockets.asyncio.server

    from gaitsmith.live.guard import Guard
except ImportError as error:  # one line, whatever of it is missing
    raise BadInput(
        "gaitsmith live", f"no package {error.name}", "the extra live", "pip install 'gaitsmith[live]'"
    ) from None

LOOPBACK = "127.0.0.1"
_LOG = logging.getLogger("gaitsmith.live")
_LOG.setLevel(logging.CRITICAL + 1)  # what strangers send is counted, not printed


def listen(host: str, port: int) -> socket.socket:
    """A socket that listens; port 0 for any free one.

    Raises:
        BadInput: the port is in use, or the address is not one of this machine.
    """
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        return socket.create_server((host, port), family=family)
    except socket.gaierror as error:
        raise BadInput("--host", host, "a name or address of this machine", reason(error)) from None
    except OSError as error:
        if error.errno in (errno.EADDRINUSE, errno.EACCES):
            taken = "in use" if error.errno == errno.EADDRINUSE else "for the administrator alone"
            remedy = f"{port} is {taken}: choose another one, or --port 0 for any"
            raise BadInput("--port", port, f"a free port on {host}", remedy) from None
        raise BadInput("--host", host, "an address of this machine", os.strerror(error.errno or 0).lower()) from None


class Server:
    """A viser server.

    Args:
        listening: where it is to be found.
        token: that the address must carry; empty for none.

    Attributes:
        scene, gui: of viser.
        address: to open in a browser.
    """

    def __init__(self, listening: socket.socket, token: str, title: str) -> None:
        host, port = listening.getsockname()[:2]
        self.guard = Guard(token, local=host in (LOOPBACK, "::1"))
        rich.get_console().quiet = True  # viser tells of its start and end on standard output, the latter from a thread
        with _behind(self.guard, listening):
            self._viser = viser.ViserServer(host=host, port=port, label=title, verbose=False)
        self.scene: Any = self._viser.scene
        self.gui: Any = self._viser.gui
        self._viser.get_event_loop().set_exception_handler(self._failed)
        shown = "localhost" if host in (LOOPBACK, "::1", "0.0.0.0", "::") else host
        self.address = f"http://{shown}:{port}/" + (f"?token={token}" if token else "")

    def _failed(self, _loop: Any, _context: dict[str, Any]) -> None:
        """A message that a control could not use."""
        self.guard.refused += 1

    def set_camera(self, size: float) -> None:
        """Where a browser looks from at first: at a robot of this height of the hips, m, at the origin."""
        camera = self._viser.initial_camera
        camera.position, camera.look_at = (2.3 * size, -3.8 * size, 2.2 * size), (0.1 * size, 0.0, 0.85 * size)
        camera.fov, camera.near, camera.far = 0.75, 0.02 * size, 200.0

    def run_in_browsers(self, script: str) -> None:
        """Let every browser run a script of this package, also those that come later."""
        self.gui._websock_interface.queue_message(viser._messages.RunJavascriptMessage(source=script))

    def together(self) -> contextlib.AbstractContextManager[None]:
        """What is changed within appears at once."""
        return self._viser.atomic()

    def stop(self) -> None:
        """Close all connections."""
        self._viser.stop()


@contextlib.contextmanager
def _behind(guard: Guard, listening: socket.socket) -> Iterator[None]:
    """Serve on this socket, behind this guard: viser itself looks for a free port, and lets everybody in."""
    serve = websockets.asyncio.server.serve

    def guarded(handler: Any, _host: str, _port: int, *, process_request: Any, **options: Any) -> Any:
        options |= {"max_size": 1 << 16, "max_queue": 8, "logger": _LOG, "sock": listening}
        return serve(guard.handler(handler), process_request=guard.answer(process_request), **options)

    with mock.patch.object(websockets.asyncio.server, "serve", guarded):
        yield
