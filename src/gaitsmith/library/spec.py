"""What a library is to hold: a robot, a grid of steps, and the bounds that every gait keeps."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from functools import cached_property, partial
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, model_validator

from gaitsmith.documents import checked, read_toml
from gaitsmith.errors import BadInput
from gaitsmith.robots.parameters import Finite, Fraction, Parameters, Positive
from gaitsmith.synthesis.motions.biped import REST, Biped, standing
from gaitsmith.synthesis.motions.catalogue import cyclic, start, stop
from gaitsmith.synthesis.motions.motion import Motion, Side
from gaitsmith.synthesis.motions.parameters import StepParameters
from gaitsmith.synthesis.motions.settings import Settings
from gaitsmith.synthesis.motions.turning import turn_cycle, turn_start, turn_stop
from gaitsmith.synthesis.requests.asked import RANGES, stride

Index = tuple[int, ...]
AXES = {"speed": "m/s", "step_height": "m", "period": "s", "yaw_rate": "rad/s", "slope": "degrees"}
"""Names and units of the axes that a grid may have, in the order of an index."""
MOST = 10_000  # points
_STEEPEST, _SHARPEST = 28.0, 45.0  # degrees: of the ground, and from one foothold to the next
_RANGES = {"speed": RANGES["--speed"], "period": RANGES["--period"], "slope": (-_STEEPEST, _STEEPEST)}
_FIRST: Side = "right"  # bears in the first step, whichever way a gait turns: all gaits have the same phases
_Values = Field(max_length=200)


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
        yaw_rate: at which the walk turns, to the left, rad/s, rising; with it all gaits are turns, on flat soles.
        slope: by which the ground rises ahead, degrees, rising; level if empty.
        step: what all steps share.
        settings: of the planner.
    """

    robot: Annotated[str, Field(min_length=1, max_length=1000)]
    speed: Annotated[tuple[Positive, ...], Field(min_length=1, max_length=200)]
    step_height: Annotated[tuple[Positive, ...], _Values] = ()
    period: Annotated[tuple[Positive, ...], _Values] = ()
    yaw_rate: Annotated[tuple[Finite, ...], _Values] = ()
    slope: Annotated[tuple[Finite, ...], _Values] = ()
    step: Step = Step()
    settings: Settings = Settings()

    @model_validator(mode="after")
    def _rising(self) -> Spec:
        for name in AXES:
            values = getattr(self, name)
            for k, (one, two) in enumerate(itertools.pairwise(values)):
                if two <= one:
                    raise BadInput(f"{name}[{k + 1}]", two, f"more than {one:g}, the value before")
            low, high = _RANGES.get(name, (-math.inf, math.inf))
            for k, value in enumerate(values):
                if not low <= value <= high:
                    raise BadInput(f"{name}[{k}]", value, f"{low:g} to {high:g}")
        if len(self.points) > MOST:
            raise BadInput("speed", f"{len(self.points)} points in all", f"at most {MOST}")
        return self

    @property
    def names(self) -> tuple[str, ...]:
        """The axes that the file gives."""
        return tuple(name for name in AXES if getattr(self, name))

    @property
    def axes(self) -> tuple[tuple[float, ...], ...]:
        """Values along every one of them."""
        return tuple(getattr(self, name) for name in self.names)

    @cached_property
    def points(self) -> tuple[Index, ...]:
        """All points, in order."""
        return tuple(itertools.product(*(range(len(axis)) for axis in self.axes)))

    def place(self, point: Index) -> dict[str, float]:
        """Value along every axis."""
        return {name: axis[k] for name, axis, k in zip(self.names, self.axes, point, strict=True)}

    def no_gait(self, point: Index) -> str:
        """Why a point has no gait, whatever the robot; empty if it may have one."""
        at = self.place(point)
        turns = at.get("yaw_rate") and at.get("slope")
        return "a turn on a slope: every step would begin on other ground than the one before" if turns else ""

    def on_slopes(self, point: Index) -> tuple[Index, ...]:
        """The same step on every slope of the grid; the point alone if slopes are no axis."""
        if not self.slope:
            return (point,)
        return tuple((*point[:-1], k) for k in range(len(self.slope)))

    @property
    def bases(self) -> tuple[Index, ...]:
        """The points from which a walk may begin and end, the straight, level and slow ones first."""

        def effort(point: Index) -> tuple[float, float]:
            at = self.place(point)
            return abs(at.get("slope", 0.0)), abs(at.get("yaw_rate", 0.0))

        return tuple(sorted(self.points, key=effort))

    def parent(self, point: Index) -> Index | None:
        """The neighbour that a point starts from, one nearer to the middle of the grid; None for the middle itself."""
        for axis in reversed(range(len(point))):
            middle = (len(self.axes[axis]) - 1) // 2
            if point[axis] != middle:
                nearer = point[axis] + (1 if point[axis] < middle else -1)
                return (*point[:axis], nearer, *point[axis + 1 :])
        return None

    def steps(self, biped: Biped) -> dict[Index, StepParameters]:
        """The step of every point that may have a gait.

        Raises:
            BadInput: a length that no step has.
        """
        found = {}
        if biped.lines:
            raise BadInput("robot", biped.robot.card.name, "soles with an area", "gaits on lines cannot be mixed")
        for point in self.points:
            at = self.place(point)
            if self.no_gait(point):
                continue
            try:
                length, period = stride(at["speed"], None, at.get("period"), biped.height)
            except BadInput as error:
                raise BadInput(f"speed[{point[0]}]", at["speed"], f"{error.field}: {error.valid}") from None
            given: dict[str, float] = {"height": at["step_height"]} if "step_height" in at else {}
            given |= {"slope": math.radians(at.get("slope", 0.0)), "turn": period * at.get("yaw_rate", 0.0)}
            if not abs(given["turn"]) <= math.radians(_SHARPEST):
                most = f"at most {math.radians(_SHARPEST) / period:.3g} rad/s, {_SHARPEST:g} degrees a step"
                raise BadInput("yaw_rate", at["yaw_rate"], most)
            found[point] = StepParameters.sized(
                biped.height, length, period, **given, **self.step.model_dump(mode="python")
            )
        return found

    def motions(self, biped: Biped) -> dict[Index, tuple[StepParameters, Motion]]:
        """Step and motion of every point; phases have as many sections at all of them, so that gaits can be mixed."""
        gap = self.settings.sized(biped).bounds.foot_gap
        cycle = partial(turn_cycle, gap=gap, bears=_FIRST) if self.yaw_rate else cyclic
        made = {point: (step, cycle(biped, step)) for point, step in self.steps(biped).items()}
        phases = [motion.phases for _, motion in made.values()]
        most = [max(row[k].sections for row in phases) for k in range(len(phases[0]))]
        return {
            point: (
                step,
                replace(motion, phases=tuple(replace(p, sections=n) for p, n in zip(motion.phases, most, strict=True))),
            )
            for point, (step, motion) in made.items()
        }

    def end(self, biped: Biped, step: StepParameters, begins: bool, goal: tuple[Any, Any, Any]) -> Motion:
        """From rest to a step's gait, or back.

        Args:
            biped: the robot.
            step: of the gait.
            begins: whether it is the start.
            goal: the gait's angles, velocities and accelerations at its start.
        """
        bounds = self.settings.sized(biped).bounds
        rest = standing(biped, biped.height - max(REST * biped.height, bounds.squat), step.slope)
        if self.yaw_rate:
            return (turn_start if begins else turn_stop)(biped, step, rest, goal, bounds.foot_gap, _FIRST)
        return (start if begins else stop)(biped, step, rest, goal)


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


def point_of(key: str) -> Index:
    """The point of a file's name."""
    return tuple(map(int, key.split("-")))
