"""Motions that a user writes: phases, footholds and conditions in TOML."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Literal, TypeVar

import numpy as np
import numpy.typing as npt
from pydantic import Field

from gaitsmith.documents import Name, checked, read_toml, written_as
from gaitsmith.errors import BadInput
from gaitsmith.robots.parameters import Parameters
from gaitsmith.synthesis.files.gait_entries import (
    CLOCK,
    Amount,
    DurationRange,
    Heading,
    Height,
    LimitName,
    Place,
    QuantityName,
    Range,
    Slope,
)
from gaitsmith.synthesis.motions.biped import Biped, standing
from gaitsmith.synthesis.motions.contacts import check_contacts
from gaitsmith.synthesis.motions.motion import At, Condition, Motion, Phase, Same, State, Unloaded
from gaitsmith.synthesis.motions.settings import Settings

PHASES, SECTIONS = 60, 120  # of a motion
_SHORTEST = 0.02  # s, of a phase
_T = TypeVar("_T")
_OfJoint = Literal["angle", "velocity", "acceleration", "torque"]
Array = npt.NDArray[np.float64]


class _Range(Range):
    """Bounds on a quantity as written."""

    low: Annotated[Amount | None, Field(alias="min")] = None
    high: Annotated[Amount | None, Field(alias="max")] = None


class _PhaseText(Parameters):
    """One phase as written."""

    name: Name
    duration: Annotated[float, Field(ge=_SHORTEST, le=60.0)]
    duration_range: DurationRange | None = None
    support: Literal["left", "right"]
    contact: Literal["air", "flat", "heel", "toe", "flight"]
    support_contact: Literal["flat", "toe"] = "flat"
    support_at: Place
    other_at: Place | None = None
    support_height: Height = 0.0
    other_height: Height = 0.0
    heading: Heading = 0.0
    other_heading: Heading = 0.0
    sections: Annotated[int, Field(ge=1, le=20)] = 1
    limits: dict[LimitName, _Range] = Field(default_factory=dict)
    joints: dict[Name, dict[_OfJoint, _Range]] = Field(default_factory=dict)


class _ConditionText(Parameters):
    """One condition as written: at the end of a phase, or at the start of the motion."""

    after: str | None = None
    rest: bool = False
    standing: bool = False
    steady: bool = False
    same_as: str | None = None
    mirrored: bool = False
    unloaded: bool = False
    values: dict[QuantityName, Amount] = Field(default_factory=dict)
    joints: dict[Name, dict[_OfJoint, Amount]] = Field(default_factory=dict)


class MotionText(Parameters):
    """A motion file.

    Attributes:
        name: of the motion; it decides nothing.
        cyclic: whether the end is the mirror image of the start, one step further.
        total_duration: of all phases together, s, which free ones keep.
        slope: by which the ground rises along x, rad.
        standing_height: hips above the soles in the standing posture, m; 3 cm below straight legs if absent.
        phases: in order of time.
        conditions: at the ends of phases; ``after`` names the phase, and is absent for the start of the motion.
        settings: bounds, order, tolerances; what is absent keeps its default.
    """

    name: Annotated[str, written_as(r"[A-Za-z0-9_-]{1,40}", "1 to 40 letters, digits, - and _")]
    cyclic: bool = False
    total_duration: Annotated[float, Field(gt=0.0)] | None = None
    slope: Slope = 0.0
    standing_height: Annotated[float | None, Field(gt=0.0, le=10.0)] = None
    phases: Annotated[tuple[_PhaseText, ...], Field(min_length=1, max_length=PHASES)]
    conditions: Annotated[tuple[_ConditionText, ...], Field(max_length=2 * PHASES)] = ()
    settings: Settings = Settings()


def read_motion(path: Path, biped: Biped) -> tuple[Motion, Settings]:
    """The motion in a TOML file; types are taken as written, a text is never a number.

    Raises:
        BadInput: the file cannot be read, or names the entry that is wrong.
    """
    data, _ = read_toml(path, "a motion")
    text = checked(MotionText, data, path.name)
    settings = text.settings.sized(biped)
    try:
        for name in settings.effort_weights:
            if name not in biped.robot.joint_names:
                valid = f"a joint: {', '.join(biped.robot.joint_names)}"
                raise BadInput("settings.effort_weights", name, valid)
        return _motion(text, biped, settings.bounds.foot_gap), settings
    except BadInput as error:
        raise error.within(path.name) from None


def _motion(text: MotionText, biped: Biped, gap: float) -> Motion:
    names = [phase.name for phase in text.phases]
    for index, name in enumerate(names):
        if name in names[:index]:
            raise BadInput(f"phases[{index}].name", name, "names that all differ")
    sections = sum(phase.sections for phase in text.phases)
    if sections > SECTIONS:
        raise BadInput("phases", f"{sections} sections", f"at most {SECTIONS} sections in all phases together")
    phases = tuple(_phase(item, biped, f"phases[{k}]") for k, item in enumerate(text.phases))
    check_contacts(phases, text.cyclic, ("support_at", "other_at"))
    _check_footholds(phases, biped, gap)
    rest = None
    if any(item.standing for item in text.conditions):
        rest = _standing(biped, text.standing_height, text.slope)
    conditions: list[Condition] = []
    for index, item in enumerate(text.conditions):
        conditions += _conditions(item, f"conditions[{index}]", names, rest, biped)
    lasting = sum(phase.duration for phase in phases)
    if text.total_duration is not None and abs(text.total_duration - lasting) > CLOCK:
        raise BadInput("total_duration", text.total_duration, f"{lasting:.6g} s, the sum of the phases' durations")
    return Motion(text.name, phases, tuple(conditions), text.cyclic, total=text.total_duration, slope=text.slope)


def _standing(biped: Biped, height: float | None, slope: float) -> Array:
    try:
        return standing(biped, height, slope)
    except BadInput as error:
        raise BadInput("standing_height", error.value, error.valid, error.remedy) from None


def _of_joints(given: Mapping[str, Mapping[_OfJoint, _T]], biped: Biped, field: str) -> dict[str, _T]:
    """What is said of joints by name, by quantity."""
    for name in given:
        if name not in biped.names:
            raise BadInput(field, name, f"a joint that moves: {', '.join(biped.names)}", "--free NAME lets one move")
    return {f"{name}.{what}": value for name, items in given.items() for what, value in items.items()}


def _phase(item: _PhaseText, biped: Biped, field: str) -> Phase:
    every = item.limits | _of_joints(item.joints, biped, f"{field}.joints")
    limits = tuple(value.limit(name, f"{field}.limits.{name}") for name, value in every.items())
    where = (item.support, item.contact, item.support_at, item.other_at)
    more = item.support_height, item.other_height, item.heading, item.other_heading
    between = item.duration_range
    if between is not None and not max(between[0], _SHORTEST) <= item.duration <= between[1]:
        valid = f"a duration within duration_range, {between[0]:g} to {between[1]:g}, and from {_SHORTEST:g} s"
        raise BadInput(f"{field}.duration", item.duration, valid, "the search starts there")
    return Phase(
        item.name,
        item.duration,
        *where,
        item.sections,
        limits,
        *more,
        between=item.duration_range,
        support_contact=item.support_contact,
    )


def _check_footholds(phases: tuple[Phase, ...], biped: Biped, gap: float) -> None:
    """Soles lie side by side, the left one on the left, and no nearer than the bounds allow."""
    if biped.lines and any(phase.heading or phase.other_heading for phase in phases):
        raise BadInput("heading", "a sole that is turned", "0 for soles that are lines", "their turns are not planned")
    least = biped.sole("left").half_width + biped.sole("right").half_width + gap
    for index, phase in enumerate(phases):
        other = phase.straight.other
        if other is not None:
            sole, sine = biped.sole(phase.other_foot), float(np.sin(phase.bend))
            inward = max(-sole.toe * sine, sole.heel * sine)
            apart = phase.side * (other[1] - phase.foothold[1]) - inward
            if apart < least - 1e-9:
                valid = f"at least {least:.4g} m: the soles' width and bounds.foot_gap"
                remedy = "y points to the left; the left sole lies left of the right one"
                raise BadInput(f"phases[{index}].other_at", f"left sole {apart:.4g} m left of the right", valid, remedy)


def _conditions(
    item: _ConditionText, field: str, names: list[str], rest: Array | None, biped: Biped
) -> list[Condition]:
    """What one entry asks for."""
    border = _border(item.after, names, f"{field}.after")
    values = item.values | _of_joints(item.joints, biped, f"{field}.joints")
    found: list[Condition] = [At(border, quantity, value) for quantity, value in values.items()]
    if item.rest or item.standing or item.steady:
        still, smooth = np.zeros(biped.joints), item.standing or item.steady
        found.append(State(border, rest if item.standing else None, still, still if smooth else None))
    if item.same_as is not None:
        other = _border(item.same_as, names, f"{field}.same_as")
        if other == border:
            raise BadInput(f"{field}.same_as", item.same_as, "another instant than the condition's own")
        whole = biped.whole
        if item.mirrored and not (biped.symmetric and np.allclose(whole.mirrored(biped.home), biped.home)):
            raise BadInput(f"{field}.mirrored", True, "a robot that is its own mirror image")
        found.append(Same(border, other, item.mirrored))
    elif item.mirrored:
        raise BadInput(f"{field}.mirrored", True, "same_as beside it, the instant whose mirror image is meant")
    if item.unloaded:
        found.append(Unloaded(border))
    if not found:
        raise BadInput(field, "nothing to hold", "standing, rest, steady, same_as, unloaded, values or joints")
    return found


def _border(after: str | None, names: list[str], field: str) -> int:
    if after is None:
        return 0
    if after not in names:
        raise BadInput(field, after, f"one of {', '.join(names)}")
    return names.index(after) + 1
