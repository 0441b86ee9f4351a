"""What happens in one run, as data: robot, terrain, commands over time, pushes, sensors; from TOML or from flags."""

from __future__ import annotations

import math
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import Field, create_model, field_validator, model_validator

from gaitsmith.documents import About, Frozen, Name, about, checked, parse_toml, read_toml, written_as
from gaitsmith.errors import BadInput
from gaitsmith.robots.parameters import GAIT_INPUTS, GaitParameters, check_gait
from gaitsmith.simulation.disturbances import Push
from gaitsmith.simulation.faults import FORM, Fault, members
from gaitsmith.simulation.path import Part, region_around
from gaitsmith.simulation.sensors import SensorNoise
from gaitsmith.simulation.terrain import Region, parse_terrain

if TYPE_CHECKING:
    from gaitsmith.robots import Robot

Seconds = Annotated[float, Field(ge=0.0)]
_Shift = Annotated[float, Field(ge=-1.0, le=1.0)]


if TYPE_CHECKING:

    class _Inputs(Frozen):
        def __getattr__(self, name: str) -> Any: ...

else:
    _Inputs = create_model(
        "_Inputs",
        __base__=Frozen,
        __module__=__name__,
        **{
            name: (Annotated[field.annotation | None, about(field)], None)
            for name, field in GaitParameters.model_fields.items()
        },
    )


class Command(_Inputs):
    """Gait inputs that a user sets; None leaves one as it was (at the start: the robot card's default).

    They are the fields of :class:`gaitsmith.robots.parameters.GaitParameters`; a single number is a forward speed.
    """

    @field_validator("speed", mode="before")
    @classmethod
    def _forward_alone(cls, given: Any) -> Any:
        """A single number is a forward speed."""
        pair = given if isinstance(given, list | tuple) else [given]
        if given is None:
            return None
        if not 1 <= len(pair) <= 2 or not all(type(number) in (int, float) for number in pair):
            raise ValueError("one or two finite numbers, m/s, forward and to the left")
        return tuple(pair) if len(pair) == 2 else (pair[0], 0.0)

    def given(self) -> dict[str, Any]:
        """The inputs that are set, as keyword arguments of :meth:`gaitsmith.control.Controller.command`."""
        return {name: getattr(self, name) for name in GAIT_INPUTS if getattr(self, name) is not None}


class Change(Command):
    """Gait inputs, and angles of joints outside the legs (rad), that change at a time, s since the run began."""

    time: Seconds
    posture: Annotated[dict[Name, float], Field(max_length=200)] = Field(default_factory=dict)

    if TYPE_CHECKING:

        def __init__(self, **values: Any) -> None: ...

    def __hash__(self) -> int:
        return hash(self.model_dump_json())

    @model_validator(mode="after")
    def _changes_something(self) -> Change:
        """Refuse a change of nothing."""
        if not self.given() and not self.posture:
            raise BadInput("changes", self.time, f"a time and at least one of {', '.join(GAIT_INPUTS)}, posture")
        return self


class Tour(Frozen):
    """One run of the teleoperation test, see :mod:`gaitsmith.simulation.tour`.

    Attributes:
        forward: largest speed commanded forward and backward, m/s.
        lateral: largest speed commanded to either side, m/s.
        yaw_rate: largest rate commanded, rad/s.
    """

    id: Annotated[int, Field(ge=0, lt=2**32)]
    forward: Annotated[float, Field(gt=0.0)]
    lateral: Annotated[float, Field(gt=0.0)]
    yaw_rate: Annotated[float, Field(ge=0.0)]


class Scenario(Command):
    """One run. The inherited gait inputs hold from the beginning; ``changes``, in order of time, alter them."""

    robot: Annotated[
        str,
        Field(min_length=1, max_length=1000),
        About("A robot of the package, or the path of a card", metavar="NAME_OR_PATH"),
    ] = "bhr_b2"
    preset: Annotated[
        str,
        Field(min_length=1, max_length=64),
        About("Control parameters of the card, such as default or paper", metavar="NAME"),
    ] = "default"
    state: Annotated[
        Literal["true", "estimated"],
        About("What the controller sees: the true state, or noisy sensors and an estimator"),
    ] = "true"
    engine: Annotated[
        Literal["mujoco", "bullet"], About("Physics: MuJoCo, or Bullet (extra bullet), the first paper's engine")
    ] = "mujoco"
    seed: Annotated[int, Field(ge=0, lt=2**32), About("Seed of everything random", metavar="N")] = 0
    terrain: Annotated[
        str,
        About(
            "Ground: flat, a slope (uphill positive), a slope across (left side up), random boxes up to a height, "
            "stairs, or a patch of ice",
            metavar="flat|slope:DEG|ramp:DEG|cross:DEG|boxes:M|stairs:RISE,TREAD,EDGE,COUNT|ice:MU,FROM,LENGTH",
        ),
    ] = "flat"
    footholds: Annotated[
        str,
        Field(max_length=1000),
        About("Ground known ahead: all of it, or a file with x, y, z of a foothold in every line", "m", "terrain|FILE"),
    ] = ""
    # 32 years: the clock still tells one tick from the next
    duration: Annotated[float, Field(gt=0.0, le=1e9), About("Length of the whole run, rests included", "s", "S")] = 20.0
    rest_before: Annotated[Seconds, About("Standing on both feet before the walk", "s", "S")] = 1.0
    rest_after: Annotated[Seconds, About("Standing on both feet after the walk", "s", "S")] = 0.0
    gait: Annotated[
        tuple[str, ...],
        Field(max_length=8),
        About(
            "Gait file to follow instead of the template's walk; several are followed one after the other", "", "FILE"
        ),
    ] = ()
    cycles: Annotated[int | None, Field(ge=1, le=10_000), About("Steps of a cyclic gait", "", "N", "endless")] = None
    tracking: Annotated[
        Literal["whole-body", "replay"],
        About("How a gait file is followed: by the whole body, or replayed by the joints alone"),
    ] = "whole-body"
    library: Annotated[
        str,
        Field(max_length=1000),
        About("Library of gaits to walk by: speed, lift, period and yaw rate within it", metavar="DIR"),
    ] = ""
    policy: Annotated[
        str,
        Field(max_length=1000),
        About("ONNX file whose policy sets gait inputs at every touchdown", metavar="FILE"),
    ] = ""
    controller: Annotated[
        str,
        written_as(r"(socket:[1-9]\d{0,4})?", "socket:PORT, the port from 1 to 65535"),
        About("Controller in another process that listens on a port of this machine", metavar="socket:PORT"),
    ] = ""
    changes: tuple[Change, ...] = ()
    tour: Tour | None = None
    pushes: Annotated[
        tuple[Push, ...],
        About(
            "Push of 0.1 s at the torso's centre of mass: time, s, and impulse, N·s, world axes",
            metavar="t,Jx,Jy,Jz",
            flag="--push",
        ),
    ] = ()
    faults: Annotated[
        tuple[Fault, ...],
        Field(max_length=100),
        About(
            "Component that fails, how, from when on and for how long, such as imu:stuck@3s,0.5s",
            metavar=FORM,
            flag="--fault",
        ),
    ] = ()
    sensors: SensorNoise = SensorNoise()
    joint_friction: Annotated[
        float, Field(ge=0.0, le=100.0), About("Coulomb friction of every joint", "N·m", "N·m")
    ] = 0.0
    joint_frictions: Annotated[dict[Name, Annotated[float, Field(ge=0.0, le=100.0)]], Field(max_length=200)] = Field(
        default_factory=dict
    )
    torque_delay: Annotated[float, Field(ge=0.0, le=0.1), About("From torque command to joint", "s", "S")] = 0.0
    friction: Annotated[
        float, Field(ge=0.05, le=5.0), About("Coulomb coefficient between sole and ground", metavar="MU")
    ] = 0.8
    mass_factor: Annotated[
        float,
        Field(ge=0.5, le=2.0),
        About("On every mass and inertia of the plant; the controller keeps the card's", metavar="X"),
    ] = 1.0
    mass_spread: Annotated[
        float,
        Field(ge=0.0, le=0.5),
        About("Each body's masses differ by up to this share besides, drawn from the seed", metavar="X"),
    ] = 0.0
    torso_shift: Annotated[
        tuple[_Shift, _Shift, _Shift],
        About("Where the plant's torso has its centre of mass, from where the card has it, torso axes", "m", "X Y Z"),
    ] = (0.0, 0.0, 0.0)

    if TYPE_CHECKING:

        def __init__(self, **values: Any) -> None: ...

    def __hash__(self) -> int:
        return hash(self.model_dump_json())

    @model_validator(mode="after")
    def _consistent(self) -> Scenario:
        """Check what no single field can tell."""
        parse_terrain(self.terrain)
        self._check_gait_file()
        if self.rest_before + self.rest_after > self.duration and not self.gait:
            valid = f"at least rest_before + rest_after = {self.rest_before + self.rest_after:g} s"
            raise BadInput("duration", self.duration, valid)
        if self.tour is not None and (self.changes or self.gait or self.library):
            valid = "nothing with changes, a gait file or a library"
            raise BadInput("tour", self.tour.id, valid, "the tour says where to go")
        if self.library and (self.gait or self.policy):
            given = "gait" if self.gait else "policy"
            raise BadInput(given, getattr(self, given), "nothing with a library", "leave one of them out")
        for own, name in (("footholds", "footholds"), ("controller", "a controller of its own")):
            not_with = ("gait", "library", "controller" if own == "footholds" else "policy")
            if getattr(self, own) and (others := [other for other in not_with if getattr(self, other)]):
                raise BadInput(others[0], getattr(self, others[0]), f"nothing with {name}", "leave one out")
        last = -math.inf
        for k, change in enumerate(self.changes):
            if change.time <= last:
                raise BadInput(
                    f"changes[{k}].time", change.time, f"more than {last:g} s, the time of the change before"
                )
            if change.time >= self.duration:
                raise BadInput(f"changes[{k}].time", change.time, f"less than the duration, {self.duration:g} s")
            last = change.time
        for k, push in enumerate(self.pushes):
            if push.time >= self.duration:
                raise BadInput(f"pushes[{k}].time", push.time, f"0 s to less than the duration, {self.duration:g} s")
        for k, fault in enumerate(self.faults):
            if fault.time >= self.duration:
                raise BadInput(f"faults[{k}].time", fault.time, f"less than the duration, {self.duration:g} s")
        return self

    def _check_gait_file(self) -> None:
        """A gait file is followed from the beginning, and nothing of it can be commanded."""
        if not self.gait:
            for name in ("cycles", "tracking"):
                if getattr(self, name) != type(self).model_fields[name].default:
                    raise BadInput(name, getattr(self, name), "nothing without a gait file", "add gait")
            return
        for name in (*GAIT_INPUTS, "policy", "changes", "rest_before", "rest_after"):
            if getattr(self, name) not in (None, 0.0, "", type(self).model_fields[name].default):
                raise BadInput(name, getattr(self, name), "nothing with a gait file", "the file decides")

    @property
    def walk_from(self) -> float:
        """When the walk is asked for, s."""
        return self.rest_before

    @property
    def walk_until(self) -> float:
        """When rest is asked for, s."""
        return self.duration - self.rest_after

    def region(self) -> Region:
        """Ground around the path that the commands describe, if nothing else moves the robot."""
        parts: list[Part] = []
        speed, yaw_rate, now = self.speed or (0.0, 0.0), self.yaw_rate or 0.0, self.walk_from
        for change in (*self.changes, Change(time=self.walk_until, speed=(0.0, 0.0))):
            until = min(max(change.time, now), self.walk_until)
            parts.append((until - now, speed, yaw_rate))
            speed = speed if change.speed is None else change.speed
            yaw_rate, now = yaw_rate if change.yaw_rate is None else change.yaw_rate, until
        return region_around(parts)


def make_scenario(fields: dict[str, Any], source: str = "") -> Scenario:
    """Scenario from plain values, as a TOML file or flags give them.

    Args:
        fields: names and values of :class:`Scenario`.
        source: what errors begin with, such as a file name.

    Raises:
        BadInput: naming the first field that is wrong, its value, and what is valid.
    """
    return checked(Scenario, fields, source)


def check_scenario(scenario: Scenario, robot: Robot) -> None:
    """Check a scenario's gait inputs, preset and failing components against a robot.

    Raises:
        BadInput: a value outside the card's ``gait_limits``, or a preset or component that the robot does not have.
    """
    from gaitsmith.template.posture import commanded  # compiled; help does without

    if scenario.preset not in robot.card.presets:
        raise BadInput("preset", scenario.preset, "one of " + ", ".join(sorted(robot.card.presets)))
    for prefix, command in [("", scenario), *((f"changes[{k}].", change) for k, change in enumerate(scenario.changes))]:
        if not scenario.library:  # which has limits of its own
            check_gait(command.given(), robot.card.gait_limits, prefix)
    for joint in scenario.joint_frictions:
        if joint not in robot.joint_names:
            raise BadInput("joint_frictions", joint, "one of " + ", ".join(robot.joint_names))
    for k, fault in enumerate(scenario.faults):
        try:
            members(fault, robot)
        except BadInput as error:
            raise error.named(f"faults[{k}].{error.field}") from None
    at_home = np.array([robot.home, robot.velocity_limit])
    for k, change in enumerate(scenario.changes):
        try:
            commanded(at_home, robot, change.posture, {})
        except BadInput as error:
            raise error.named(f"changes[{k}].{error.field}") from None


def load_scenario(name_or_path: str | Path) -> Scenario:
    """Scenario of a TOML file, or a shipped one by name (``figure5``).

    Raises:
        BadInput: no such file or name, a file over 1 MB, not TOML, empty, or with a wrong field.
    """
    shipped = {Path(entry.name).stem: entry for entry in resources.files(__package__).joinpath("scenarios").iterdir()}
    if str(name_or_path) in shipped:
        source, fields = str(name_or_path), parse_toml(shipped[str(name_or_path)].read_bytes(), "", "a scenario")
    else:
        source = Path(name_or_path).name
        try:
            fields, _ = read_toml(Path(name_or_path), "a scenario")
        except BadInput as error:
            known = f", or one of {', '.join(sorted(shipped))}" if error.field == str(name_or_path) else ""
            raise BadInput(error.field, error.value, error.valid + known, error.remedy) from None
    if not fields:
        raise BadInput(source, "an empty file", "at least one field, such as duration = 20")
    return make_scenario(fields, source)
