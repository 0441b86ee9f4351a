"""Motions that a user writes: phases, footholds and conditions in TOML."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from gaitsmith.errors import BadInput
from gaitsmith.files import read_bounded
from gaitsmith.robots.parameters import Finite, Parameters, Positive
from gaitsmith.synthesis.biped import Biped
from gaitsmith.synthesis.ipopt import Progress
from gaitsmith.synthesis.motion import QUANTITIES, At, Limit, Motion, Phase, Same, State
from gaitsmith.synthesis.plan import Planner
from gaitsmith.synthesis.posture import standing
from gaitsmith.synthesis.request import REST, Answer
from gaitsmith.synthesis.settings import Settings

_LARGEST = 1_000_000
_REPORT = Callable[[str, int, Progress], None]
Place = tuple[Finite, Finite]


class _Range(BaseModel):
    """Bounds on a quantity."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    low: Annotated[float | None, Field(alias="min", allow_inf_nan=False)] = None
    high: Annotated[float | None, Field(alias="max", allow_inf_nan=False)] = None


class _PhaseText(Parameters):
    """One phase as written."""

    name: Annotated[str, Field(min_length=1, max_length=60)]
    duration: Annotated[float, Field(ge=0.02, le=60.0, allow_inf_nan=False)]
    support: Literal["left", "right"]
    contact: Literal["air", "flat", "heel", "toe"]
    support_at: Place
    other_at: Place | None = None
    sections: Annotated[int, Field(ge=1, le=20)] = 1
    limits: dict[str, _Range] = Field(default_factory=dict)


class _ConditionText(Parameters):
    """One condition as written: at the end of a phase, or at the start of the motion."""

    after: str | None = None
    rest: bool = False
    standing: bool = False
    same_as: str | None = None
    values: dict[str, Finite] = Field(default_factory=dict)


class MotionText(Parameters):
    """A motion file.

    Attributes:
        name: of the motion.
        cyclic: whether the end is the mirror image of the start, one step further.
        standing_height: hips above the soles in the standing posture, m; 3 cm below straight legs if absent.
        phases: in order of time.
        conditions: at the ends of phases; ``after`` names the phase, and is absent for the start of the motion.
        settings: bounds, order, tolerances; what is absent keeps its default.
    """

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]{1,40}$")]
    cyclic: bool = False
    standing_height: Positive | None = None
    phases: Annotated[tuple[_PhaseText, ...], Field(min_length=1, max_length=200)]
    conditions: tuple[_ConditionText, ...] = ()
    settings: Settings = Settings()


def read_motion(path: Path, biped: Biped) -> tuple[Motion, Settings]:
    """The motion in a TOML file.

    Raises:
        BadInput: the file cannot be read, or names the entry that is wrong.
    """
    try:
        data = tomllib.loads(read_bounded(path, _LARGEST).decode("utf-8"))
    except (ValueError, RecursionError) as error:
        raise BadInput(path.name, str(error)[:80], "a motion in TOML") from None
    try:
        text = MotionText.model_validate(data)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False)[0]
        place = ".".join(str(part) for part in first["loc"])
        raise BadInput(f"{path.name}: {place}", first["input"], first["msg"]) from None
    return _motion(text, biped, path.name), text.settings


def _motion(text: MotionText, biped: Biped, source: str) -> Motion:
    names = [phase.name for phase in text.phases]
    if len(set(names)) != len(names):
        raise BadInput(f"{source}: phases", names, "names that all differ")
    phases = tuple(_phase(item, f"{source}: phases.{item.name}") for item in text.phases)
    _check_contacts(phases, source, text.cyclic)
    rest = None
    if any(item.standing for item in text.conditions):
        rest = standing(biped, text.standing_height or biped.height - REST)
    conditions: list[At | State | Same] = []
    for index, item in enumerate(text.conditions):
        field = f"{source}: conditions[{index}]"
        border = _border(item.after, names, f"{field}.after")
        for quantity, value in item.values.items():
            conditions.append(At(border, _known(quantity, f"{field}.values"), value))
        still = np.zeros(biped.joints) if item.rest or item.standing else None
        if still is not None:
            conditions.append(State(border, rest if item.standing else None, still))
        if item.same_as is not None:
            conditions.append(Same(border, _border(item.same_as, names, f"{field}.same_as")))
    return Motion(text.name, phases, tuple(conditions), text.cyclic)


def _phase(item: _PhaseText, field: str) -> Phase:
    if (item.contact == "air") != (item.other_at is None):
        valid = "no place in the air" if item.contact == "air" else "two numbers, where the other sole stands"
        raise BadInput(f"{field}.other_at", item.other_at, valid)
    limits = tuple(
        Limit(
            _known(name, f"{field}.limits"),
            -np.inf if value.low is None else value.low,
            np.inf if value.high is None else value.high,
        )
        for name, value in item.limits.items()
    )
    return Phase(
        item.name, item.duration, item.support, item.contact, item.support_at, item.other_at, item.sections, limits
    )


def _known(quantity: str, field: str) -> str:
    if quantity not in QUANTITIES:
        raise BadInput(field, quantity, f"one of {', '.join(QUANTITIES)}")
    return quantity


def _border(after: str | None, names: list[str], field: str) -> int:
    if after is None:
        return 0
    if after not in names:
        raise BadInput(field, after, f"one of {', '.join(names)}")
    return names.index(after) + 1


def _check_contacts(phases: tuple[Phase, ...], source: str, cyclic: bool) -> None:
    """Feet may only move in the air, and a foot must be on the ground before it can bear the robot."""
    if cyclic and phases[-1].support == phases[0].support:
        raise BadInput(f"{source}: cyclic", True, "a last phase whose support foot differs from the first's")
    for before, after in pairwise(phases):
        field = f"{source}: phases.{after.name}"
        if before.support != after.support and not (before.double and after.double):
            remedy = "the support changes between two phases with both feet on the ground"
            raise BadInput(f"{field}.support", after.support, f"{before.support} as in the phase before", remedy)
        held = before.foothold if before.support == after.support else before.other
        if held is not None and max(abs(a - b) for a, b in zip(held, after.foothold, strict=True)) > 1e-9:
            raise BadInput(f"{field}.support_at", after.foothold, f"{held}, where that foot stands before")
        if before.double and after.double:
            other = before.other if before.support == after.support else before.foothold
            if other is not None and after.other is not None:
                gap = max(abs(a - b) for a, b in zip(other, after.other, strict=True))
                if gap > 1e-9:
                    raise BadInput(f"{field}.other_at", after.other, f"{other}, where that foot stands before")


def answer_file(planner: Planner, path: Path, report: _REPORT | None = None) -> Answer:
    """Plan the motion in a file.

    Raises:
        BadInput: as :func:`read_motion`.
    """
    motion, settings = read_motion(path, planner.biped)
    tell: Any = None if report is None else lambda rounds, progress: report(motion.name, rounds, progress)
    found = planner.plan(motion, settings, report=tell)
    return Answer({motion.name: found}, found.gait)
