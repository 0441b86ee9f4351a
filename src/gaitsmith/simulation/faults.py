"""Faults as data: which component of a robot fails, how, when and for how long."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field, model_validator

from gaitsmith.documents import Worded
from gaitsmith.errors import BadInput

if TYPE_CHECKING:
    from gaitsmith.robots import Robot

SENSOR_FAULTS = ("nan", "stuck", "zero", "offset", "delayed")
MOTOR_FAULTS = ("dead", "weak", "stuck", "delayed")
TICK_FAULTS = ("dead", "delayed")
TICKS = "ticks"
FORM = "COMPONENT:TYPE@TIMEs,DURATIONs"
_TEXT = re.compile(r"(?P<component>[^:@]+):(?P<type>[^:@]+)@(?P<time>[^,@]+),(?P<duration>[^,@]+)")


class Fault(Worded):
    """One component that fails in one way for a time; also written as ``imu:stuck@3s,0.5s``.

    Attributes:
        component: a sensor (``gyro``, ``accelerometer``, ``attitude``, ``base_position``, ``base_velocity``, a joint's
            ``JOINT.angle`` or ``JOINT.rate``, a sole's ``SOLE.force``), a joint's motor ``JOINT.motor``, ``ticks``, or
            a group: ``imu``, ``angles``, ``rates``, ``soles``, ``motors``.
        type: of a sensor: ``nan`` gives no number, ``stuck`` the last one, ``zero`` zero, ``offset`` adds an error,
            ``delayed`` gives what was true 20 ms ago. Of a motor: ``dead`` gives no torque, ``weak`` 30 % of it,
            ``stuck`` the last one, ``delayed`` that of 20 ms ago. Of ticks: ``dead`` does none, ``delayed`` one in ten.
        time: of its beginning, s since the run began.
        duration: s.
    """

    component: Annotated[str, Field(min_length=1, max_length=200)]
    type: Literal["nan", "stuck", "zero", "offset", "delayed", "dead", "weak"]
    time: Annotated[float, Field(ge=0.0)]
    duration: Annotated[float, Field(gt=0.0, le=600.0)]

    @model_validator(mode="before")
    @classmethod
    def _from_text(cls, given: Any) -> Any:
        """The short form as a table."""
        if not isinstance(given, str):
            return given
        found = _TEXT.fullmatch(given.strip())
        if found is None:
            raise BadInput("faults", given, FORM, "for example imu:stuck@3s,0.5s")
        return {
            **found.groupdict(),
            **{name: _seconds(given, found[name]) for name in ("time", "duration")},
        }

    def __str__(self) -> str:
        return f"{self.component}:{self.type}@{self.time:g}s,{self.duration:g}s"


def _seconds(given: str, word: str) -> float:
    """A time such as ``0.5s`` or ``500ms``, s."""
    for unit, factor in (("ms", 1e-3), ("s", 1.0), ("", 1.0)):
        if word.endswith(unit):
            try:
                return factor * float(word.removesuffix(unit))
            except ValueError:
                break
    raise BadInput("faults", given, FORM, f"{word} is no time such as 0.5s or 500ms")


def sensors(robot: Robot) -> tuple[str, ...]:
    """Names of a robot's sensors, in the order of the controller's channels."""
    from gaitsmith.estimation.readings import channel_names  # compiled; help does without

    return channel_names(tuple(robot.joint_names), tuple(leg.name for leg in robot.legs))


def motors(robot: Robot) -> tuple[str, ...]:
    """Names of a robot's motors, in the order of its joints."""
    return tuple(f"{joint}.motor" for joint in robot.joint_names)


def groups(robot: Robot) -> dict[str, tuple[str, ...]]:
    """Components that have a name together."""
    names = sensors(robot)
    return {
        "imu": ("attitude", "accelerometer", "gyro"),
        "angles": tuple(name for name in names if name.endswith(".angle")),
        "rates": tuple(name for name in names if name.endswith(".rate")),
        "soles": tuple(name for name in names if name.endswith(".force")),
        "motors": motors(robot),
    }


def members(fault: Fault, robot: Robot) -> tuple[str, ...]:
    """The components that a fault concerns.

    Raises:
        BadInput: the robot has no such component, or it cannot fail like that.
    """
    together, single = groups(robot), (*sensors(robot), *motors(robot), TICKS)
    found = together.get(fault.component, (fault.component,))
    if found[0] not in single:
        plain = ", ".join(name for name in single if "." not in name)
        joints, soles = ", ".join(robot.joint_names), ", ".join(leg.name for leg in robot.legs)
        valid = (
            f"one of {plain}, {', '.join(together)}, SOLE.force of {soles}, or JOINT.angle, .rate, .motor of {joints}"
        )
        raise BadInput("component", fault.component, valid)
    kinds = TICK_FAULTS if found[0] == TICKS else MOTOR_FAULTS if found[0].endswith(".motor") else SENSOR_FAULTS
    if fault.type not in kinds:
        raise BadInput("type", fault.type, f"one of {', '.join(kinds)} for {fault.component}")
    return found
