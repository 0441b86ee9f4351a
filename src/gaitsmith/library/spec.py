"""What a library is to hold: a robot, a grid of steps, and the bounds that every gait keeps."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, model_validator

from gaitsmith.documents import checked, read_toml
from gaitsmith.errors import BadInput
from gaitsmith.robots.parameters import Fraction, Parameters, Positive
from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.motions.catalogue import cyclic
from gaitsmith.synthesis.motions.motion import Motion
from gaitsmith.synthesis.motions.parameters import StepParameters
from gaitsmith.synthesis.motions.settings import Settings
from gaitsmith.synthesis.requests.asked import RANGES, stride

Index = tuple[int, ...]
AXES = ("speed", "step_height", "period")
"""Names of a grid's axes, in the order of an index."""
MOST = 10_000  # points
_Axis = Annotated[tuple[Positive, ...], Field(min_length=1, max_length=200)]


class Step(Parameters):
    """What all steps of a library have in common; see :class:`gaitsmith.synthesis.motions.catalogue.StepParameters`."""

    double_support: Annotated[float, Field(ge=0.05, le=0.8)] = 0.30
    toe_off: Fraction = 0.20
    heel_strike: Fraction = 0.15


class Spec(Parameters):
    """A library as a file describes it.

    Attributes:
        robot: name of a robot of the package, or the path of a card.
        speed: m/s, rising.
        step_height: of the ankle at mid-swing, m, rising; the planner's own if empty.
        period: of a step, s, rising; if empty, every speed has the one that the planner gives it.
        step: what all steps share.
        settings: of the planner.
    """

    robot: Annotated[str, Field(min_length=1, max_length=1000)]
    speed: _Axis
    step_height: Annotated[tuple[Positive, ...], Field(max_length=200)] = ()
    period: Annotated[tuple[Positive, ...], Field(max_length=200)] = ()
    step: Step = Step()
    settings: Settings = Settings()

    @model_validator(mode="after")
    def _rising(self) -> Spec:
        for name, flag in zip(AXES, ("--speed", "", "--period"), strict=True):
            values = getattr(self, name)
            for k, (one, two) in enumerate(itertools.pairwise(values)):
                if two <= one:
                    raise BadInput(f"{name}[{k + 1}]", two, f"more than {one:g}, the value before")
            low, high = RANGES.get(flag, (0.0, math.inf))
            for k, value in enumerate(values):
                if not low <= value <= high:
                    raise BadInput(f"{name}[{k}]", value, f"{low:g} to {high:g}")
        if len(self.points) > MOST:
            raise BadInput("speed", f"{len(self.points)} points in all", f"at most {MOST}")
        return self

    @property
    def axes(self) -> tuple[tuple[float, ...], ...]:
        """Values along every axis; NaN alone where each point has its own."""
        return tuple(getattr(self, name) or (math.nan,) for name in AXES)

    @cached_property
    def points(self) -> tuple[Index, ...]:
        """All points, in order."""
        return tuple(itertools.product(*(range(len(axis)) for axis in self.axes)))

    def place(self, point: Index) -> dict[str, float]:
        """Value along every axis that the file gives."""
        given = {name: axis[k] for name, axis, k in zip(AXES, self.axes, point, strict=True)}
        return {name: value for name, value in given.items() if not math.isnan(value)}

    def parent(self, point: Index) -> Index | None:
        """The neighbour that a point starts from, one nearer to the middle of the grid; None for the middle itself."""
        for axis in reversed(range(len(point))):
            middle = (len(self.axes[axis]) - 1) // 2
            if point[axis] != middle:
                nearer = point[axis] + (1 if point[axis] < middle else -1)
                return (*point[:axis], nearer, *point[axis + 1 :])
        return None

    def steps(self, biped: Biped) -> dict[Index, StepParameters]:
        """The step of every point.

        Raises:
            BadInput: a length that no step has.
        """
        found = {}
        if biped.lines:
            raise BadInput("robot", biped.robot.card.name, "soles with an area", "gaits on lines cannot be mixed")
        for point in self.points:
            at = self.place(point)
            try:
                length, period = stride(at["speed"], None, at.get("period"), biped.height)
            except BadInput as error:
                raise BadInput(f"speed[{point[0]}]", at["speed"], f"{error.field}: {error.valid}") from None
            given: dict[str, float] = {"height": at["step_height"]} if "step_height" in at else {}
            found[point] = StepParameters.sized(
                biped.height, length, period, **given, **self.step.model_dump(mode="python")
            )
        return found

    def motions(self, biped: Biped) -> dict[Index, tuple[StepParameters, Motion]]:
        """Step and motion of every point; phases have as many sections at all of them, so that gaits can be mixed."""
        made = {point: (step, cyclic(biped, step)) for point, step in self.steps(biped).items()}
        phases = [motion.phases for _, motion in made.values()]
        most = [max(row[k].sections for row in phases) for k in range(len(phases[0]))]
        return {
            point: (
                step,
                replace(motion, phases=tuple(replace(p, sections=n) for p, n in zip(motion.phases, most, strict=True))),
            )
            for point, (step, motion) in made.items()
        }


def read_spec(path: str | Path) -> Spec:
    """The library that a TOML file describes.

    Raises:
        BadInput: naming the entry that is wrong.
    """
    data, _ = read_toml(Path(path), "a library's grid")
    return checked(Spec, data, Path(path).name)


def checked_spec(data: Any, source: str = "spec") -> Spec:
    """The library that plain data describe, with lists for tuples."""
    return checked(Spec, data, source)


def key_of(point: Index) -> str:
    """A point as a file's name."""
    return "-".join(f"{k:03d}" for k in point)
