"""Walks that the controller's tests look at: closed loop on the plant, and a robot that is held where it stands."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from gaitsmith.control import Controller
from gaitsmith.control.defaults import preset_parameters, robot_scale
from gaitsmith.control.state import Tick
from gaitsmith.kinematics.posture import standing_posture
from gaitsmith.robots import Robot, load_robot
from gaitsmith.robots.parameters import GaitParameters
from gaitsmith.robots.presets import ControlParameters
from gaitsmith.simulation import Plant

Array = npt.NDArray[np.float64]

MODELS = Path(__file__).resolve().parent.parent / "models"
ROBOTS = ("bhr_b2", "thbip_ii", "with_arms")
DT = 1e-3


@cache
def robot(name: str) -> Robot:
    """A shipped robot, or one of the tests' models."""
    path = MODELS / f"{name}.toml"
    return load_robot(path if path.exists() else name)


def gait(name: str, **changes: Any) -> GaitParameters:
    """The card's gait with some inputs changed."""
    return GaitParameters(**{**robot(name).card.gait.model_dump(), **changes})


@cache
def _preset(name: str, preset: str) -> ControlParameters:
    return preset_parameters(robot(name), robot_scale(robot(name)), preset)


def parameters(name: str, preset: str = "default", **groups: dict[str, Any]) -> ControlParameters:
    """A preset with some of its numbers changed."""
    chosen = _preset(name, preset)
    return chosen.model_copy(
        update={group: getattr(chosen, group).model_copy(update=values) for group, values in groups.items()}
    )


def view(controller: Controller) -> Tick:
    """All arrays of a controller."""
    return controller._g


def copied(group: Any) -> Any:
    """A named tuple with all its arrays copied, however deep."""
    return group.copy() if isinstance(group, np.ndarray) else type(group)(*(copied(part) for part in group))


class Loop:
    """Controller and plant in closed loop, at rest on both feet at first.

    Args:
        name: of the robot.
        chosen: control parameters; the default preset if None.
        state: true or estimated.
        plant: options of the plant.
        **changes: of the gait.
    """

    def __init__(
        self,
        name: str,
        chosen: ControlParameters | None = None,
        state: Any = "true",
        plant: dict[str, Any] | None = None,
        **changes: Any,
    ) -> None:
        self.robot, self.gait = robot(name), gait(name, **changes)
        self.controller = Controller(self.robot, chosen or parameters(name), state=state, gait=self.gait)
        self.plant = Plant(self.robot, **(plant or {}))
        self.start = standing_posture(self.robot, self.gait.height, self.gait.width)
        self.groups = view(self.controller)
        self.restart()

    def restart(self) -> None:
        """At rest on both feet, with the first gait."""
        self.plant.push((0.0, 0.0, 0.0))
        self.plant.reset(self.start)
        self.controller.command(**self.gait.model_dump())
        self.controller.reset()

    def step(self) -> Array:
        """One tick; returns a view of the torque."""
        self.plant.measure(self.controller.measurement)
        torque = self.controller.tick()
        self.plant.step(torque)
        return torque

    def run(self, ticks: int) -> Array:
        """Telemetry of some ticks, a row each."""
        rows = np.zeros((ticks, len(self.controller.telemetry_buffer)))
        for row in rows:
            self.step()
            row[:] = self.controller.telemetry_buffer
        return rows

    def column(self, name: str) -> int:
        """Index of a column of telemetry."""
        return self.controller.telemetry_columns.index(name)


class Record(NamedTuple):
    """A tick of a walk: its number, everything after it, and the last torque before it."""

    tick: int
    groups: Tick
    before: Array


DURATION, SAMPLES = 4200, 29  # ticks, and ticks from one record to the next


@cache
def records(name: str) -> tuple[Record, ...]:
    """Ticks of a walk with everything in it: standing, turning, new inputs, a push, a stop; a sample, and switches."""
    loop, first, kept = Loop(name), gait(name), []
    scale = loop.controller.scale
    turn = 0.3 if loop.groups.control.turns[0] else 0.0
    push = 0.05 * scale.mass * scale.speed / 0.1
    plan: dict[int, Any] = {
        150: loop.controller.walk,
        900: lambda: loop.controller.command(speed=(0.1 * scale.speed, 0.02 * scale.speed), yaw_rate=turn),
        1500: lambda: loop.controller.command(height=0.97 * first.height, lift=0.8 * first.lift),
        2000: lambda: loop.controller.command(period=0.95 * first.period, alpha=0.45, width=1.05 * first.width),
        2400: lambda: loop.plant.push((0.0, push, 0.0)),
        2500: lambda: loop.plant.push((0.0, 0.0, 0.0)),
        3000: loop.controller.stand,
    }
    for tick in range(DURATION):
        plan.get(tick, lambda: None)()
        before, count = loop.groups.whole_body.solution.torque.copy(), int(loop.groups.template.step.count[0])
        loop.step()
        if tick % SAMPLES == 0 or loop.groups.template.step.count[0] != count:
            kept.append(Record(tick, copied(loop.groups), before))
    return tuple(kept)


class Held:
    """A robot held still in its standing posture, whose sole forces the test decides.

    It lifts a foot without shifting its weight first, for it cannot shift it.

    Args:
        name: of the robot.
        chosen: control parameters; the default preset if None.
        state: true or estimated.
        **changes: of the gait.
    """

    def __init__(
        self, name: str = "bhr_b2", chosen: ControlParameters | None = None, state: Any = "true", **changes: Any
    ) -> None:
        self.robot, self.gait = robot(name), gait(name, **changes)
        chosen = chosen or parameters(name, standing={"weight_shift": False})
        self.controller = Controller(self.robot, chosen, state=state, gait=self.gait)
        self.q = standing_posture(self.robot, self.gait.height, self.gait.width)
        self.v = np.zeros(self.robot.model.nv)
        self.groups = view(self.controller)

    def tick(self, *forces: float) -> Array:
        """One tick with these forces on the soles, N; 200 each if none are given."""
        measurement = self.controller.measurement
        measurement.base_position[:], measurement.base_quaternion[:] = self.q[:3], self.q[3:7]
        measurement.joint_position[:], measurement.joint_velocity[:] = self.q[7:], self.v[6:]
        measurement.base_velocity[:] = self.v[:6]
        measurement.accelerometer[:] = 0.0, 0.0, 9.81
        measurement.gyro[:] = self.v[3:6]
        measurement.sole_force[:] = forces or (200.0, 200.0)
        return self.controller.tick().copy()

    def stance_only(self, force: float = 300.0, swing: float = 0.0) -> Array:
        """One tick with a force on the stance sole and another on the swing sole."""
        stance = int(self.groups.template.step.stance[0])
        return self.tick(*(force if leg == stance else swing for leg in range(len(self.robot.legs))))
