"""The other end of :mod:`gaitsmith.simulation.remote`: any controller, asked through a socket of this machine."""

from __future__ import annotations

import contextlib
import json
import socketserver
from collections.abc import Callable, Mapping
from typing import Any

from gaitsmith.simulation.remote import HOST

Answer = Callable[[Mapping[str, Any]], Mapping[str, Any]]
"""From a tick's message to ``torque``, N·m, and ``step``; see docs/crash.md."""


class Server(socketserver.ThreadingTCPServer):
    """Asks a controller of its own for every connection.

    Args:
        make: called with the greeting whenever a run begins; returns what answers its ticks.
        name, version: of the controller; results are kept under them.
        port: 0 for any that is free, see ``server_address``.
    """

    allow_reuse_address = True
    daemon_threads = True

    def __init__(self, make: Callable[[Mapping[str, Any]], Answer], name: str, version: str, port: int = 0) -> None:
        self.make, self.named = make, {"name": name, "version": version}
        super().__init__((HOST, port), _Connection)


class _Connection(socketserver.StreamRequestHandler):
    disable_nagle_algorithm = True

    def handle(self) -> None:
        """Answer until the other end hangs up."""
        with contextlib.suppress(OSError):
            self._talk()

    def _talk(self) -> None:
        server, answer = self.server, None
        assert isinstance(server, Server)
        for line in self.rfile:
            message = json.loads(line)
            if "hello" in message:
                answer = server.make(message["hello"]) if message["hello"] else None
                told: Mapping[str, Any] = server.named
            elif answer is not None:
                told = answer(message)
            else:
                return
            self.wfile.write(json.dumps(told).encode() + b"\n")
