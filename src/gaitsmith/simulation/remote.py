"""A controller in another process, behind a socket of this machine: it is told every tick, and answers with torques.

The protocol is one line of JSON a message (docs/crash.md). Whoever does not answer in time, or answers with something
else, is not asked again: the joints are braked, and the run says why.
"""

from __future__ import annotations

import json
import math
import socket
import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gaitsmith.control import CONTROL_PERIOD, Controller
from gaitsmith.control.state import STANDING, WALKING
from gaitsmith.errors import BadInput
from gaitsmith.estimation.measurement import Measurement
from gaitsmith.robots.parameters import at_rest
from gaitsmith.template.step import make_gait_inputs

if TYPE_CHECKING:
    from gaitsmith.robots import Robot
    from gaitsmith.robots.parameters import GaitParameters

HOST = "127.0.0.1"
PATIENCE, FIRST = 1.0, 20.0  # s of wall time for an answer: to a tick, and to the greeting
_LONGEST = 1_000_000  # bytes of an answer
_NAME = 100  # characters
_STEP = 4  # numbers: steps taken, stance leg, time in the step, duration of the last one


class _Failed(Exception):
    """The process did not answer as it should; says what it did."""


class Line:
    """A connection that sends and receives lines of JSON.

    Raises:
        BadInput: nobody listens there.
    """

    def __init__(self, port: int) -> None:
        try:
            self._socket = socket.create_connection((HOST, port), timeout=FIRST)
        except OSError as error:
            valid = "a port on which a controller listens"
            raise BadInput(
                "controller", f"socket:{port}", valid, f"start it first ({error.strerror or error})"
            ) from None
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._rest = b""

    def ask(self, message: Mapping[str, Any], patience: float) -> dict[str, Any]:
        """Send a message, and receive the answer.

        Raises:
            _Failed: none came in time, or not one object of JSON.
        """
        if self._rest:
            raise _Failed("answered more than once")
        until = time.monotonic() + patience
        try:
            self._socket.settimeout(patience)
            self._socket.sendall(json.dumps(message, separators=(",", ":"), allow_nan=False).encode() + b"\n")
            while b"\n" not in self._rest:
                self._socket.settimeout(max(until - time.monotonic(), 1e-6))
                received = self._socket.recv(65536)
                if not received:
                    raise _Failed("closed the connection")
                self._rest += received
                if len(self._rest) > _LONGEST:
                    raise _Failed("answered without an end")
        except TimeoutError:
            raise _Failed(f"did not answer within {patience:g} s") from None
        except OSError as error:
            raise _Failed(f"lost the connection ({(error.strerror or str(error)).lower()})") from None
        line, _, self._rest = self._rest.partition(b"\n")
        try:
            answer = json.loads(line)
        except (ValueError, RecursionError):
            raise _Failed("answered with something that is not JSON") from None
        if not isinstance(answer, dict):
            raise _Failed("answered with something that is no object")
        return answer

    def close(self) -> None:
        """Hang up."""
        self._socket.close()


def port_of(text: str) -> int:
    """Port of ``socket:PORT``.

    Raises:
        BadInput: not that.
    """
    kind, _, number = text.partition(":")
    if kind == "socket" and number.isdecimal() and 1 <= int(number) <= 65535:
        return int(number)
    raise BadInput("controller", text, "socket:PORT, of this machine, the port from 1 to 65535")


def identity_of(text: str) -> str:
    """What the controller behind ``socket:PORT`` calls itself, with its version: results are kept under it.

    Raises:
        BadInput: nobody listens there, or it does not say.
    """
    line = Line(port_of(text))
    try:
        answer = line.ask({"hello": {}}, FIRST)
        return _named(answer)
    except _Failed as error:
        raise BadInput("controller", text, "a controller with name and version", f"it {error}") from None
    finally:
        line.close()


def _named(answer: Mapping[str, Any]) -> str:
    name, version = (answer.get(key) for key in ("name", "version"))
    if not all(isinstance(text, str) and 0 < len(text) <= _NAME for text in (name, version)):
        raise _Failed("answered the greeting without name and version")
    return f"{name} {version}"


class RemoteController(Controller):
    """A controller of which only the telemetry is here.

    Args:
        preset: whose limits apply.
        state: what is measured: ``true``, or ``estimated`` by sensors.
        port: of this machine, where the process listens.

    Attributes:
        failed: why the process is not asked any more; empty while it is.
        stopped: told why, when the process is not asked any more; refuses one that cannot even begin.

    Raises:
        BadInput: nobody listens there, or as :class:`gaitsmith.control.Controller`.
    """

    def __init__(
        self,
        robot: Robot,
        preset: str,
        state: Any,
        gait: GaitParameters | None,
        port: int,
    ) -> None:
        self._line, self._port, self.failed = Line(port), port, ""
        self.stopped: Callable[[str], None] = self._refuse
        self._walk, self._greeted, self._angles = False, False, dict[str, float]()
        super().__init__(robot, preset, state, gait)
        self._limit = np.asarray(robot.torque_limit)

    def reset(self) -> None:
        """Forget everything; the process is greeted again before the next tick."""
        super().reset()
        self._walk, self._greeted, self.failed = False, False, ""
        self._angles.clear()
        self.damp()

    def close(self) -> None:
        """Hang up; the process is not asked any more."""
        self._line.close()

    def walk(self) -> None:
        """Say from the next tick on that it is to walk."""
        self._walk = True

    def stand(self) -> None:
        """Say from the next tick on that it is to stand."""
        self.command(**at_rest(self.gait.model_dump()))
        self._walk = False

    def posture(self, angles: Mapping[str, float], rates: Mapping[str, float] | None = None) -> None:
        """Command joints outside the legs."""
        super().posture(angles, rates)
        self._angles.update(angles)

    def tick(self, measurement: Measurement | None = None) -> npt.NDArray[np.float64]:
        """One control period; the joints are braked once the process has failed."""
        braking = super().tick(measurement)
        if self.failed:
            return braking
        try:
            torque, step = self._answer()
        except _Failed as error:
            self.failed = str(error)
            self.stopped(self.failed)
            return braking
        told = self.telemetry
        walking = self._walk and step[0] > 0.0
        told.control_state[0], told.mode[0] = (WALKING, 1.0) if walking else (STANDING, 0.0)
        told.step_count[0], told.stance[0], told.step_time[0], told.step_duration[0] = step
        told.command[:] = make_gait_inputs(self.gait).values
        told.torque[:] = torque
        self._torque[:] = torque
        return self._torque

    def _answer(self) -> tuple[npt.NDArray[np.float64], list[float]]:
        """Torque (nj,) within its limits, and the four numbers of the step."""
        if not self._greeted:
            _named(self._line.ask({"hello": self._greeting()}, FIRST))
            self._greeted = True
        told = {name: _numbers(array) for name, array in zip(Measurement._fields, self.measurement, strict=True)}
        now, gait = float(self.telemetry.time[0]), self.gait.model_dump(mode="json")
        message = {"time": now, "walk": self._walk, "command": gait, "posture": self._angles, **told}
        answer = self._line.ask(message, PATIENCE)
        torque = _array(answer.get("torque"), len(self._limit))
        step = _array(answer.get("step", [0, len(self.robot.legs), 0, 0]), _STEP)
        if torque is None:
            raise _Failed(f"answered without {len(self._limit)} finite torques")
        if step is None:
            raise _Failed(f"answered without a step of {_STEP} finite numbers")
        if min(step) < 0.0 or step[0] % 1.0 or step[1] not in range(len(self.robot.legs) + 1):
            raise _Failed("answered with a step that is none")
        return torque.clip(-self._limit, self._limit), step.tolist()

    def _refuse(self, why: str) -> None:
        self.close()
        valid = "a controller that answers as docs/crash.md says"
        raise BadInput("controller", f"socket:{self._port}", valid, f"it {why}")

    def _greeting(self) -> dict[str, Any]:
        return {
            "robot": self.robot.card.name,
            "joints": list(self.robot.joint_names),
            "soles": [leg.name for leg in self.robot.legs],
            "torque_limit": self._limit.tolist(),
            "control_step": CONTROL_PERIOD,
            "state": "estimated" if self.estimated else "true",
            "gait": self.gait.model_dump(mode="json"),
        }


def _numbers(array: npt.NDArray[np.float64]) -> list[float | None]:
    """A reading; what is no number is null."""
    return [value if math.isfinite(value) else None for value in array.tolist()]


def _array(given: Any, size: int) -> npt.NDArray[np.float64] | None:
    """(size,) finite numbers, or None."""
    if not isinstance(given, list) or len(given) != size:
        return None
    if not all(type(value) in (int, float) for value in given):
        return None
    try:
        found = np.array([float(value) for value in given])
    except OverflowError:  # a whole number of too many digits
        return None
    return found if np.isfinite(found).all() else None
