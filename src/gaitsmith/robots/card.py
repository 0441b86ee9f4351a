"""The robot card: what the control needs to know about a robot and its model file does not say."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from gaitsmith.documents import Name, written_as
from gaitsmith.errors import BadInput
from gaitsmith.robots.parameters import (
    Finite,
    GaitLimits,
    GaitParameters,
    Parameters,
    Positive,
    check_gait,
    partial,
)
from gaitsmith.robots.presets import CardPreset
from gaitsmith.robots.sole import Sole

PresetName = Annotated[str, written_as(r"[A-Za-z0-9_-]{1,64}", "1 to 64 letters, digits, - and _")]
Triple = tuple[Finite, Finite, Finite]


class LegCard(Parameters):
    """One leg: its joints from hip to ankle, and its sole frame.

    The sole frame is a site of the model (`sole_site`), or is placed on a body: `sole_body`, `sole_position` (m) and
    `sole_rpy` (rad, roll about x, then pitch about y, then yaw about z, all fixed axes of the body).
    """

    name: Literal["left", "right"]
    joints: Annotated[tuple[Name, ...], Field(min_length=3, max_length=12)]
    knee: Name
    ankle_pitch: Name
    ankle_roll: Name | None = None
    sole: Sole
    sole_site: Name | None = None
    sole_body: Name | None = None
    sole_position: Triple | None = None
    sole_rpy: Triple = (0.0, 0.0, 0.0)


class TorsoFrame(Parameters):
    """A frame on the torso with x forward and z up, from the body's own: `rpy` turns as `sole_rpy` does, rad."""

    rpy: Triple


class JointLimits(Parameters):
    """Limits of one joint: position (rad or m), velocity and torque, the last two in both directions."""

    position: tuple[Finite, Finite]
    velocity: Positive
    torque: Positive


CardLimits: Any = partial(JointLimits)
CardGait: Any = partial(GaitParameters)
CardGaitLimits: Any = partial(GaitLimits)


class Assumption(Parameters):
    """A number that the source does not give: what it is, its value, and why this value."""

    what: str
    value: str
    why: str


class Described(Parameters):
    """What every card says, whether or not the loader has filled in the rest.

    Attributes:
        schema_version: 2; 1 is read without its presets, see `card_file`.
        model: MJCF or URDF file, relative to the card's folder.
        torso: body that carries the free joint.
        legs: left and right, in any order.
        imu_site: site on the torso; the torso frame if absent.
        trust: `card` accepts limits that are wider than the model's.
        weld: joints outside the legs that are fixed at home.
        ignore: bodies that are left out, with all that hangs on them.
        home: angles of joints outside the legs.
        presets: by name, the control parameters that differ from those that the robot's size and mass suggest.

    Raises:
        BadInput: entries contradict each other.
    """

    schema_version: Literal[1, 2]
    name: Annotated[str, written_as(r"[A-Za-z0-9_.-]{1,64}", "1 to 64 letters, digits, -, _ and .")]
    description: str = ""
    model: Annotated[str, Field(min_length=1, max_length=500)]
    torso: Name
    torso_frame: TorsoFrame | None = None
    legs: tuple[LegCard, LegCard]
    imu_site: Name | None = None
    trust: Literal["card"] | None = None
    weld: Annotated[tuple[Name, ...], Field(max_length=200)] = ()
    ignore: Annotated[tuple[Name, ...], Field(max_length=200)] = ()
    home: Annotated[dict[Name, Finite], Field(max_length=200)] = Field(default_factory=dict)
    presets: Annotated[dict[PresetName, CardPreset], Field(max_length=50)] = Field(default_factory=dict)
    assumptions: tuple[Assumption, ...] = ()

    @model_validator(mode="after")
    def _consistent(self) -> Described:
        names = [leg.name for leg in self.legs]
        if sorted(names) != ["left", "right"]:
            raise BadInput("legs", names, "one leg named left and one named right")
        for index, leg in enumerate(self.legs):
            _check_leg(leg, f"legs[{index}]")
        first, second = self.legs
        if shared := sorted(set(first.joints) & set(second.joints)):
            valid = "joints that the other leg does not have"
            raise BadInput("legs[1].joints", shared, valid, "as torso name the body where the legs meet")
        if len(first.joints) != len(second.joints):
            raise BadInput("legs[1].joints", list(second.joints), f"{len(first.joints)} joints, as in legs[0]")
        for entry, given in (("home", self.home), ("weld", self.weld)):
            if inside := [name for name in given if name in (*first.joints, *second.joints)]:
                raise BadInput(entry, inside, "joints outside the legs")
        for preset, parameters in self.presets.items():
            _check_preset(parameters.model_dump(exclude_none=True), len(first.joints), f"presets.{preset}")
        return self


class CardText(Described):
    """A card as its author writes it: what it does not say, the loader fills in from the model.

    Attributes:
        mass: total mass, kg; checked against the model.
        limits: of joints, as far as they differ from the model's.
        gait: default inputs of the gait template.
        gait_limits: valid ranges of these inputs.
    """

    mass: Positive | None = None
    limits: Annotated[dict[Name, CardLimits], Field(max_length=200)] = Field(default_factory=dict)
    gait: CardGait = CardGait()
    gait_limits: CardGaitLimits = CardGaitLimits()

    @model_validator(mode="after")
    def _ordered(self) -> CardText:
        for joint, limits in self.limits.items():
            if limits.position is not None and not limits.position[0] < limits.position[1]:
                raise BadInput(f"limits.{joint}.position", list(limits.position), "lowest < highest")
        for name, pair in self.gait_limits:
            if pair is not None and not pair[0] <= pair[1]:
                raise BadInput(f"gait_limits.{name}", list(pair), "lowest <= highest")
        return self


class RobotCard(Described):
    """A robot's card, complete: every entry is the card's own, the model's, or assumed for a robot of this size.

    Attributes:
        mass: total mass, kg.
        limits: of every joint besides the free one.
        gait: default inputs of the gait template.
        gait_limits: valid ranges of these inputs.
    """

    mass: Positive
    limits: dict[Name, JointLimits]
    gait: GaitParameters
    gait_limits: GaitLimits

    @model_validator(mode="after")
    def _walkable(self) -> RobotCard:
        check_gait(self.gait.model_dump(), self.gait_limits, "gait.")
        return self


def _check_leg(leg: LegCard, field: str) -> None:
    if len(set(leg.joints)) != len(leg.joints):
        raise BadInput(f"{field}.joints", list(leg.joints), "every joint once")
    for role in ("knee", "ankle_pitch", "ankle_roll"):
        joint = getattr(leg, role)
        if joint is not None and joint not in leg.joints:
            raise BadInput(f"{field}.{role}", joint, f"one of {', '.join(leg.joints)}")
    if leg.knee == leg.joints[0]:
        raise BadInput(f"{field}.knee", leg.knee, "a joint after the first, which is the hip's")
    if leg.joints.index(leg.ankle_pitch) <= leg.joints.index(leg.knee):
        raise BadInput(f"{field}.ankle_pitch", leg.ankle_pitch, "a joint after the knee", "list joints hip to ankle")
    if leg.ankle_roll is not None and leg.joints.index(leg.ankle_roll) <= leg.joints.index(leg.knee):
        raise BadInput(f"{field}.ankle_roll", leg.ankle_roll, "a joint after the knee", "list joints hip to ankle")
    if leg.ankle_roll == leg.ankle_pitch:
        raise BadInput(f"{field}.ankle_roll", leg.ankle_roll, "a joint other than ankle_pitch")
    if (leg.sole.kind == "line") != (leg.sole.half_width == 0.0):
        valid = "0 for a line" if leg.sole.kind == "line" else "greater than 0 for a rectangle"
        raise BadInput(f"{field}.sole.half_width", leg.sole.half_width, valid)
    placed = leg.sole_body is not None or leg.sole_position is not None
    if (leg.sole_site is None) == (not placed):
        raise BadInput(f"{field}.sole_site", leg.sole_site, "either sole_site, or sole_body with sole_position")
    if placed and (leg.sole_body is None or leg.sole_position is None):
        missing = "sole_body" if leg.sole_body is None else "sole_position"
        raise BadInput(f"{field}.{missing}", None, "sole_body and sole_position together")


def _check_preset(given: dict[str, Any], joint_count: int, field: str) -> None:
    for group in ("joint_gains", "joint_gains_estimated"):
        for name, gains in given.get(group, {}).items():
            if len(gains) not in (0, joint_count):
                raise BadInput(f"{field}.{group}.{name}", list(gains), f"{joint_count} values, one per leg joint")
    low, high = given.get("contact", {}).get("normal_force", (0.0, math.inf))
    if not low < high:
        raise BadInput(f"{field}.contact.normal_force", [low, high], "lowest < highest")
    foothold = given.get("foothold", {})
    separation, spread = foothold.get("separation", 0.0), foothold.get("spread", math.inf)
    if not separation < 2.0 * spread:
        raise BadInput(f"{field}.foothold.separation", separation, f"less than twice the spread, {2.0 * spread}")
