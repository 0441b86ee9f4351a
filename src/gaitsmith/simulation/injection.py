"""Faults put between a plant and its controller: readings spoiled, torques lost, ticks withheld; bit-repeatable."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from gaitsmith.control.defaults import robot_scale
from gaitsmith.estimation.measurement import Measurement, all_of
from gaitsmith.estimation.readings import channel_names
from gaitsmith.robots import Robot
from gaitsmith.simulation.faults import TICKS, Fault, members
from gaitsmith.simulation.plant import Plant

_DELAY = 20  # ticks, of a delayed reading or torque
_WEAK = 0.3  # of the torque
_EVERY = 10  # ticks, of which a delayed controller does one
_GAP = 0.4  # √(z/g) without a new torque after which the motors' drives brake the joints
_BRAKE = 0.05  # of the torque limit per rad/s
_SIZES = {"gyro": 1.0, "accelerometer": 5.0, "attitude": 0.2, "base_position": 0.2, "base_velocity": 0.5}
_ANGLE, _RATE, _FORCE = 0.1, 2.0, 0.5  # rad, rad/s, of the weight


class Injector:
    """A backend around a plant whose components fail.

    Args:
        plant: what is controlled.
        faults: checked against the robot.
        robot: whose components they are.
        tell: hears of the beginning and the end of every fault.
        braked: called when the motors' drives brake the joints, as no torque comes.

    Attributes:
        control_step: of the plant, s.
    """

    def __init__(
        self,
        plant: Plant,
        faults: Sequence[Fault],
        robot: Robot,
        tell: Callable[[Mapping[str, Any]], None],
        braked: Callable[[], None] = lambda: None,
    ) -> None:
        self._plant, self._faults, self._tell, self.control_step = plant, faults, tell, plant.control_step
        self._braked = braked
        self._limit, nj, n = np.asarray(robot.torque_limit), len(robot.joint_names), len(robot.legs)
        names = channel_names(tuple(robot.joint_names), tuple(leg.name for leg in robot.legs))
        sizes = [3, 4, 6, *[1] * (2 * nj), 3, 3, *[1] * n]
        ends = np.cumsum(sizes)
        scale = robot_scale(robot)
        self._places = {name: np.arange(end - size, end) for name, size, end in zip(names, sizes, ends, strict=True)}
        self._motors = {f"{name}.motor": j for j, name in enumerate(robot.joint_names)}
        self._offset = np.zeros(ends[-1])
        for name, place in self._places.items():
            kind = name.rpartition(".")[2]
            joint = {"angle": _ANGLE, "rate": _RATE, "force": _FORCE * scale.weight}
            self._offset[place] = _SIZES.get(name, joint.get(kind, 0.0))
        self._members = [members(fault, robot) for fault in faults]
        self._starts = [round(fault.time / self.control_step) for fault in faults]
        self._ends = [
            start + max(1, round(fault.duration / self.control_step))
            for start, fault in zip(self._starts, faults, strict=True)
        ]
        self._read, self._sent = np.zeros((_DELAY + 1, ends[-1])), np.zeros((_DELAY + 1, nj))
        self._gap, self._tick, self._withheld = round(_GAP / scale.rate / self.control_step), 0, 0
        self._held_torque, self._held = np.zeros(nj), np.zeros(ends[-1])

    @property
    def time(self) -> float:
        """Of the plant, s."""
        return self._plant.time

    def _acting(self, k: int) -> bool:
        return self._starts[k] <= self._tick < self._ends[k]

    def withholds(self) -> bool:
        """Whether the controller does not get to do this tick."""
        for k, fault in enumerate(self._faults):
            if self._members[k] == (TICKS,) and self._acting(k):
                late = fault.type == "dead" or (self._tick - self._starts[k]) % _EVERY != _EVERY - 1
                self._withheld = self._withheld + 1 if late else 0
                return late
        self._withheld = 0
        return False

    def measure(self, into: Measurement) -> None:
        """What the plant's sensors say, spoiled."""
        self._plant.measure(into)
        values = all_of(into)
        row = self._tick % len(self._read)
        self._read[row] = values
        for k, fault in enumerate(self._faults):
            if self._tick in (self._starts[k], self._ends[k]):
                self._tell({"fault": str(fault), "over": self._tick == self._ends[k]})
            if not self._acting(k):
                continue
            if self._tick == self._starts[k]:
                self._held[:] = self._read[row - 1] if self._tick > 0 else values
            for name in self._members[k]:
                place = self._places.get(name)
                if place is not None:
                    self._spoil(values, place, name, fault.type, row)

    def _spoil(
        self, values: npt.NDArray[np.float64], place: npt.NDArray[np.intp], name: str, kind: str, row: int
    ) -> None:
        """One sensor's numbers."""
        if kind == "nan":
            values[place] = np.nan
        elif kind == "zero":
            values[place] = 0.0
        elif kind == "stuck":
            values[place] = self._held[place]
        elif kind == "delayed":
            values[place] = self._read[(row + 1) % len(self._read)][place] if self._tick >= _DELAY else values[place]
        elif name == "attitude":
            values[place] = _rolled(values[place], self._offset[place[0]])
        else:
            values[place] += self._offset[place]

    def step(self, torque: npt.NDArray[np.float64]) -> None:
        """Apply what the motors make of the torques; without new ones for too long the drives brake."""
        row = self._tick % len(self._sent)
        self._sent[row] = torque
        sent = self._sent[row].copy()
        for k, fault in enumerate(self._faults):
            motors = [self._motors[name] for name in self._members[k] if name in self._motors]
            if not motors or not self._acting(k):
                continue
            if self._tick == self._starts[k]:
                self._held_torque[:] = self._sent[row - 1] if self._tick > 0 else sent
            late = self._sent[(row + 1) % len(self._sent)] if self._tick >= _DELAY else sent
            changed = {"dead": 0.0 * sent, "weak": _WEAK * sent, "stuck": self._held_torque, "delayed": late}[
                fault.type
            ]
            sent[motors] = changed[motors]
        if self._withheld > self._gap:
            if self._withheld == self._gap + 1:
                self._braked()
            sent = np.clip(-_BRAKE * self._limit * self._plant.v[6:], -self._limit, self._limit)
        self._plant.step(sent)
        self._tick += 1


def _rolled(quaternion: npt.NDArray[np.float64], angle: float) -> npt.NDArray[np.float64]:
    """An attitude turned by an angle, rad, half way between roll and pitch, body axes."""
    w, x, y, z = quaternion
    c, s = np.cos(0.5 * angle), np.sin(0.5 * angle) * np.sqrt(0.5)
    return np.array([c * w - s * x - s * y, s * w + c * x - s * z, s * w + c * y + s * z, c * z + s * x - s * y])
