"""Walks that the controller's tests look at: closed loop on the plant, and a robot that is held in mid-air."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from gaitsmith.control.layout import TickGroups

from gaitsmith.control import Controller
from gaitsmith.kinematics.posture import standing_posture
from gaitsmith.robots import Robot, load_robot
from gaitsmith.robots.presets import ControlParameters, GaitParameters
from gaitsmith.simulation import Plant
from gaitsmith.template.step import StepState

Array = npt.NDArray[np.float64]

MODELS = Path(__file__).resolve().parent.parent / "models"
ROBOTS = ("bhr_b2", "six_joint_legs", "with_arms")
_DIAGONAL = {"regularisation": 1e-3, "torque_change": 1e-2}


@cache
def robot(name: str) -> Robot:
    return load_robot(name if name == "bhr_b2" else MODELS / f"{name}.toml")


def gait(name: str, **changes: Any) -> GaitParameters:
    """The card's gait; a quicker one for the small robots, whose card says what they are and not how they walk."""
    quick = {} if name == "bhr_b2" else {"period": 0.25, "lift": 0.03}
    return GaitParameters(**{**robot(name).card.gait.model_dump(), **quick, **changes})


def parameters(name: str, preset: str = "default", **groups: dict[str, Any]) -> ControlParameters:
    """A preset with some of its numbers changed.

    Six joints a leg leave directions that only the QP's smallest weights decide; with the card's, rounding would be
    magnified a billion times. The tests' own are larger.
    """
    chosen = robot(name).card.presets[preset]
    if name != "bhr_b2":
        groups = {"weights": _DIAGONAL, **groups}
    return chosen.model_copy(
        update={group: getattr(chosen, group).model_copy(update=values) for group, values in groups.items()}
    )


class Loop:
    """Controller and plant, standing, in closed loop.

    Args:
        name: of the robot.
        chosen: control parameters; the tests' default if None.
        state: true or estimated.
        **changes: of the gait.
    """

    def __init__(self, name: str, chosen: ControlParameters | None = None, state: Any = "true", **changes: Any) -> None:
        self.robot, self.gait = robot(name), gait(name, **changes)
        self.controller = Controller(self.robot, chosen or parameters(name), state=state, gait=self.gait)
        self.plant = Plant(self.robot)
        self.start = standing_posture(self.robot, self.gait.height, self.gait.width)
        self.restart()

    def restart(self) -> None:
        """At rest on both feet, as at first; the requested gait stays."""
        self.plant.reset(self.start)
        self.controller.reset()

    def step(self) -> Array:
        self.plant.measure(self.controller.measurement)
        torque = self.controller.tick()
        self.plant.step(torque)
        return torque


Plan = dict[int, Callable[[Loop], None]]


def busy_plan(name: str, speed: float, push: float) -> Plan:
    """Stand, step in place, walk, change every template parameter, be pushed, stop: in 3.9 s."""
    first = gait(name)
    return {
        200: lambda loop: loop.controller.walk(),
        500: lambda loop: loop.controller.command(speed=(speed, 0.1 * speed)),
        1000: lambda loop: loop.controller.command(height=0.96 * first.height, lift=0.8 * first.lift),
        1400: lambda loop: loop.controller.command(period=0.9 * first.period, alpha=0.45, width=1.05 * first.width),
        1700: lambda loop: loop.plant.push((0.0, push, 0.0)),
        1800: lambda loop: loop.plant.push((0.0, 0.0, 0.0)),
        2300: lambda loop: loop.controller.stand(),
    }


DURATION = 3900
SAMPLES = 23  # ticks from one record to the next
SPEED = {"bhr_b2": 0.3, "six_joint_legs": 0.1, "with_arms": 0.1}
PUSH = {"bhr_b2": 60.0, "six_joint_legs": 15.0, "with_arms": 15.0}


class Record(NamedTuple):
    """One tick: its number, all of the controller's groups after it, and some of what was there before it."""

    tick: int
    groups: TickGroups
    feedforward: Array  # of the tick before
    foot_desired: Array  # of the tick before
    step: StepState  # of the tick before


def _copy(group: Any) -> Any:
    return type(group)(*(array.copy() for array in group))


@cache
def records(name: str, preset: str = "default") -> tuple[Record, ...]:
    """Ticks of the busy walk: a sample, and every switch."""
    loop = Loop(name, parameters(name, preset))
    plan, kept = busy_plan(name, SPEED[name], PUSH[name]), []
    groups = loop.controller._groups
    for tick in range(DURATION):
        if tick in plan:
            plan[tick](loop)
        before = (groups.whole_body.torque.copy(), groups.control.foot_desired.copy(), _copy(groups.step))
        loop.step()
        if tick % SAMPLES == 0 or groups.step.count[0] != before[2].count[0]:
            kept.append(Record(tick, TickGroups(*(_copy(group) for group in groups)), *before))
    return tuple(kept)


class Held:
    """A robot held still in its standing posture, whose sole forces the test decides.

    Args:
        name: of the robot.
        chosen: control parameters; the tests' default if None.
        state: true or estimated.
        **changes: of the gait.
    """

    def __init__(
        self, name: str = "bhr_b2", chosen: ControlParameters | None = None, state: Any = "true", **changes: Any
    ) -> None:
        self.robot, self.gait = robot(name), gait(name, **changes)
        self.controller = Controller(self.robot, chosen or parameters(name), state=state, gait=self.gait)
        self.controller.reset()
        self.q = standing_posture(self.robot, self.gait.height, self.gait.width)
        self.v = np.zeros(self.robot.model.nv)
        self.groups = self.controller._groups

    def tick(self, left: float = 200.0, right: float = 200.0) -> Array:
        measurement = self.controller.measurement
        measurement.base_position[:], measurement.base_quaternion[:] = self.q[:3], self.q[3:7]
        measurement.joint_position[:], measurement.joint_velocity[:] = self.q[7:], self.v[6:]
        measurement.base_velocity[:] = self.v[:6]
        measurement.accelerometer[:] = 0.0, 0.0, 9.81
        measurement.sole_force[:] = left, right
        return self.controller.tick().copy()
