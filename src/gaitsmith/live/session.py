"""Two processes: one with the control loop, and this one with the page."""

from __future__ import annotations

import multiprocessing
import secrets
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from gaitsmith.errors import BadInput, GaitsmithError
from gaitsmith.files import uninterrupted
from gaitsmith.live.desk import Desk
from gaitsmith.live.handover import Note, Ring
from gaitsmith.live.page import Page, make_frame
from gaitsmith.live.recording import finish_folder
from gaitsmith.live.server import LOOPBACK, Server, listen
from gaitsmith.live.walker import ROWS, WISHES, Request, serve
from gaitsmith.live.wishes import WIDTH, Kind
from gaitsmith.robots import Robot

_READY = 600.0  # s in which the loop must be ready; the first time it compiles
_END = 10.0  # s in which it must come to its end


class WalkLost(GaitsmithError):
    """The process with the control loop has ended by itself."""


class Walk:
    """A control loop in a process of its own.

    Attributes:
        frames, note: from the loop.
        wishes: to it.
        told: what it said of itself when it was ready.

    Raises:
        BadInput: the scenario does not fit the robot.
    """

    def __init__(self, request: Request) -> None:
        self.wishes = Ring(WIDTH, WISHES)
        context = multiprocessing.get_context("spawn")
        here, there = context.Pipe(duplex=False)
        self._process = context.Process(target=serve, args=(there, self.wishes.name, request), name="gaitsmith walk")
        with uninterrupted():  # Ctrl-C is for this process, which ends the other one
            self._process.start()
        there.close()
        try:
            self.told = self._hear(here)
        except BaseException:
            self._process.kill()
            self.wishes.close()
            raise
        self.note = Note(self.told["note"])
        self._here = here

    def _hear(self, here: Any) -> dict[str, Any]:
        """What the process says when it is ready."""
        try:
            told: dict[str, Any] = here.recv() if here.poll(_READY) else {"failed": "the walk did not begin in time"}
        except EOFError:
            raise WalkLost("the process with the control loop ended before the walk began") from None
        if "error" in told:
            raise BadInput(*told["error"])
        if "failed" in told:
            raise WalkLost(told["failed"])
        return told

    def open_frames(self, columns: int) -> None:
        """Open the ring of frames, of so many numbers each."""
        self.frames = Ring(columns, ROWS, self.told["frames"])

    @property
    def alive(self) -> bool:
        """Whether the loop goes on."""
        return self._process.is_alive()

    def end(self) -> None:
        """Ask the loop to end, and wait for it."""
        self.wishes.write(((float(Kind.END)), *(0.0,) * (WIDTH - 1)))
        self._process.join(_END)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
        for shared in (self.frames, self.note, self.wishes):
            shared.close()


class Session:
    """A walk and its page.

    Args:
        scenario: fields of the walk's scenario.
        host, port: where the page is to be found; another address than this machine's own needs a token, which is made.

    Attributes:
        address: to open in a browser.

    Raises:
        BadInput: the port is in use, or the scenario cannot be run.
    """

    def __init__(self, scenario: dict[str, Any], robot: Robot, host: str, port: int, recordings: str) -> None:
        listening = listen(host, port)
        try:
            self.walk = Walk(Request(scenario, recordings))
        except BaseException:
            listening.close()
            raise
        self._desk = Desk(self.walk.wishes)
        frame = make_frame(self.walk.told["columns"], robot, self.walk.told["balls"])
        self.walk.open_frames(len(frame.row))
        self._server = Server(listening, token_for(host), robot.card.name)
        self.address = self._server.address
        self.page = Page(self._server, robot, frame, self.walk.frames, self.walk.note, self._desk, scenario)
        self._finished: set[str] = set()

    def run(self, look: Callable[[], None] = lambda: None) -> None:
        """Until the walk's process ends, or ``look``, called before every picture, raises.

        Raises:
            WalkLost: it has ended by itself.
        """

        def alive() -> bool:
            look()
            self._finish_recordings()
            return self.walk.alive

        self.page.run(alive)
        raise WalkLost("the process with the control loop has ended; what was recorded is kept")

    def _finish_recordings(self) -> None:
        """Write the summary of a recording that has ended, beside the page."""
        done = str(self.page.words.get("recorded") or "")
        if done and done not in self._finished:
            self._finished.add(done)
            threading.Thread(target=finish_folder, args=(Path(done),), daemon=True).start()

    def close(self) -> list[str]:
        """End the walk, and the page; folders that were recorded."""
        going = str(self.page.words.get("recording") or "")
        self.walk.end()
        self._server.stop()
        if going and going not in self._finished:
            self._finished.add(going)
            finish_folder(Path(going))
        return sorted(self._finished)


def token_for(host: str) -> str:
    """The token that an address needs: none on this machine alone."""
    return "" if host in (LOOPBACK, "localhost", "::1") else secrets.token_urlsafe(16)
