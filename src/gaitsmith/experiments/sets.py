"""Sets of trials and push grids: data in TOML, scaled to the robot that runs them."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from gaitsmith.documents import Frozen, checked, parse_toml, read_toml
from gaitsmith.errors import BadInput
from gaitsmith.experiments.limits import QUANTITIES, Limit
from gaitsmith.experiments.push_grid import PushGrid, momentum_unit
from gaitsmith.robots import Robot, load_robot
from gaitsmith.robots.parameters import GAIT_INPUTS
from gaitsmith.simulation.planned_run import completed
from gaitsmith.simulation.scenario import Scenario, load_scenario, make_scenario

_ROOT, _LENGTH, _RATE = 0.5, 1.0, -0.5
_POWERS = {
    **dict.fromkeys(("duration", "rest_before", "rest_after", "time", "period"), _ROOT),
    **dict.fromkeys(("speed", "speed_error", "lateral_error", "speed_bias"), _ROOT),
    **dict.fromkeys(("height", "lift", "width", "drift", "separation", "height_error"), _LENGTH),
    **dict.fromkeys(("yaw_rate", "yaw_rate_error"), _RATE),
}
"""Power of the length scale in each quantity, gravity being the same: times and speeds go with its root."""


class TrialEntry(Frozen):
    """One trial; without limits it is judged by falls alone.

    Attributes:
        name: as ``--only`` takes it.
        base: a shipped scenario that the fields of ``scenario`` are put over.
        scenario: fields of :class:`gaitsmith.simulation.Scenario`.
        draw: fields drawn evenly from a range, anew for every seed.
        limits: bounds by quantity, kept in every episode.
        report: quantities shown without a limit.
        seeds: number of episodes.
        least: how many of them have to stand; all if None.
        judged: False to report only.
    """

    name: Annotated[str, Field(min_length=1, max_length=64)]
    base: str | None = None
    scenario: dict[str, Any] = Field(default_factory=dict)
    draw: dict[str, tuple[float, float]] = Field(default_factory=dict)
    limits: dict[str, float] = Field(default_factory=dict)
    report: tuple[str, ...] = ()
    seeds: Annotated[int, Field(ge=1, le=1000)] = 1
    least: Annotated[int, Field(ge=0)] | None = None
    judged: bool = True


class GridEntry(Frozen):
    """One grid of pushes; see :class:`gaitsmith.experiments.PushGrid`. ``strength`` is over mass times √(gH)."""

    impulse: Annotated[float, Field(gt=0.0, le=1000.0)] | None = None
    strength: Annotated[float, Field(gt=0.0, le=2.0)] | None = None
    scenario: dict[str, Any] = Field(default_factory=dict)
    least: int | None = None
    goal: int | None = None
    separation: float | None = None
    directions: Annotated[int, Field(ge=1, le=360)] = 8
    phases: Annotated[int, Field(ge=1, le=360)] = 12
    offset: float = 0.0


class Reference(Frozen):
    """The robot in whose size a set is written: leg from hip to sole, stretched, m, and mass, kg."""

    leg: Annotated[float, Field(gt=0.0)]
    mass: Annotated[float, Field(gt=0.0)]


class _Document(Frozen):
    """A set's file; ``every`` holds what all its trials share, put over what ``extends`` brings.

    Attributes:
        planned: whether the set is about a planned gait, which has to be given.
    """

    robot: str
    planned: bool = False
    reference: Reference | None = None
    trials: tuple[TrialEntry, ...] = ()
    grids: tuple[GridEntry, ...] = ()


@dataclass(frozen=True)
class Trial:
    """A trial for one robot: an episode for each seed, and limits of the robot's size.

    Attributes:
        scenarios: one for each seed.
    """

    entry: TrialEntry
    scenarios: tuple[Scenario, ...]
    limits: tuple[Limit, ...] = ()

    @property
    def name(self) -> str:
        """As ``--only`` takes it."""
        return self.entry.name

    @property
    def least(self) -> int:
        """How many episodes have to stand."""
        return len(self.scenarios) if self.entry.least is None else self.entry.least

    def target(self) -> str:
        """What is asked for, in words."""
        if not self.entry.judged:
            return "report"
        total = len(self.scenarios)
        stands = "no fall" if self.least >= total else f"≥ {self.least} of {total} stand"
        return "; ".join([stands, *(limit.target() for limit in self.limits)])


@dataclass(frozen=True)
class TrialSet:
    """Trials and grids for one robot.

    Attributes:
        base: scenario fields that hold throughout: robot, preset, and the gait file if one was given.
    """

    name: str
    robot: Robot
    trials: tuple[Trial, ...]
    grids: tuple[PushGrid, ...]
    base: dict[str, Any]


def set_names() -> tuple[str, ...]:
    """Sets that come with the package."""
    return tuple(sorted(Path(entry.name).stem for entry in resources.files(__package__).joinpath("sets").iterdir()))


def load_set(
    name: str | None, robot: str | None = None, preset: str = "default", gait: str | None = None, engine: str = "mujoco"
) -> TrialSet:
    """A set, scaled to a robot.

    Args:
        name: of a set that comes with the package, or path of a TOML file; None for ``planned`` with a gait, else
            ``walks``.
        robot: name or path; the set's own if None.
        preset: control parameters, for the trials that do not name their own.
        gait: planned gait that every trial walks; None for the template.

    Raises:
        BadInput: the set, the robot or the preset cannot be used.
    """
    name = name or ("planned" if gait else "walks")
    document = _read(name)
    if document.planned and not gait:
        raise BadInput("--gait", "none", f"a gait file: what the set {name} tries", "gaitsmith plan makes one")
    robot = robot or document.robot
    loaded = load_robot(robot)
    if preset not in loaded.card.presets:
        raise BadInput("--preset", preset, "one of " + ", ".join(sorted(loaded.card.presets)))
    base: dict[str, Any] = {"robot": robot, "preset": preset, "engine": engine}
    if gait:
        wanted = [_asked(entry) | entry.draw for entry in document.trials] + [grid.scenario for grid in document.grids]
        if any(fields.keys() & {*GAIT_INPUTS, "changes"} for fields in wanted):
            raise BadInput("--set", name, "a set without speeds, heights or periods: the gait decides", "leave it out")
        base = completed(base | {"gait": [gait]})
    scale, heavier = 1.0, 1.0
    if document.reference is not None:
        scale, heavier = leg_length(loaded) / document.reference.leg, loaded.mass / document.reference.mass
    trials = tuple(_trial(entry, base, scale) for entry in document.trials)
    grids = tuple(_grid(entry, base, scale, heavier, loaded) for entry in document.grids)
    return TrialSet(name, loaded, trials, grids, base)


def leg_length(robot: Robot) -> float:
    """From the first leg's hip to its sole along the stretched leg, m."""
    leg, model = robot.legs[0], robot.model
    hip, body = int(model.jnt_bodyid[leg.joint_indices[0] + 1]), leg.sole_body
    length = float(np.linalg.norm(leg.sole_position))
    while body != hip:
        length += float(np.linalg.norm(model.body_pos[body]))
        body = int(model.body_parentid[body])
    return length


def _read(name: str) -> _Document:
    """A set's document, with what it extends."""
    try:
        return checked(_Document, _plain(name), name)
    except (AttributeError, TypeError) as error:
        raise BadInput(f"{name}: trials", str(error), "tables") from None


def _plain(name: str) -> dict[str, Any]:
    """A set's tables; ``every`` is put under its own trials and over those of the set that it extends."""
    data = _data(name)
    every = data.pop("every", {})
    data["trials"] = [_merged(every, trial) for trial in data.get("trials", [])]
    if "extends" in data:
        extended = _plain(str(data.pop("extends")))
        data["trials"] = [_merged(trial, every) for trial in extended["trials"]] + data["trials"]
        data = extended | data
    return data


def _data(name: str) -> dict[str, Any]:
    """A set's file as plain data."""
    if name in set_names():
        shipped = resources.files(__package__).joinpath("sets", f"{name}.toml")
        return parse_toml(shipped.read_bytes(), name, "a set")
    try:
        return read_toml(Path(name), "a set of trials")[0]
    except BadInput as error:
        raise BadInput("--set", name, f"{error.valid}, or one of {', '.join(set_names())}", error.remedy) from None


def _merged(base: dict[str, Any], top: dict[str, Any]) -> dict[str, Any]:
    """One trial's table over another, field by field of the scenario."""
    return {**base, **top, "scenario": {**base.get("scenario", {}), **top.get("scenario", {})}}


def _asked(entry: TrialEntry) -> dict[str, Any]:
    """Scenario fields of a trial over those of the file that it begins with."""
    start = load_scenario(entry.base).model_dump(mode="json", exclude_unset=True) if entry.base else {}
    return {**start, **entry.scenario}


def _trial(entry: TrialEntry, base: dict[str, Any], scale: float) -> Trial:
    """A trial with its scenarios made."""
    fields = {"rest_before": 1.0, **base, **_scaled(_asked(entry), scale)}
    for quantity in (*entry.limits, *entry.report):
        if quantity not in QUANTITIES:
            raise BadInput(f"{entry.name}: limits", quantity, "one of " + ", ".join(QUANTITIES))
    scenarios = tuple(make_scenario({**fields, **_drawn(entry, seed), "seed": seed}) for seed in range(entry.seeds))
    limits = tuple(Limit(name, bound) for name, bound in _scaled(entry.limits, scale).items())
    return Trial(entry, scenarios, limits)


def _drawn(entry: TrialEntry, seed: int) -> dict[str, float]:
    """What a seed draws."""
    rng = np.random.default_rng([seed, 0xD1])
    return {name: round(float(rng.uniform(low, high)), 4) for name, (low, high) in entry.draw.items()}


def _grid(entry: GridEntry, base: dict[str, Any], scale: float, heavier: float, robot: Robot) -> PushGrid:
    """A grid with the scenario that it pushes in; least and goal count cells."""
    walk = walking({**base, **_scaled(entry.scenario, scale)}, robot)
    if (entry.impulse is None) == (entry.strength is None):
        raise BadInput("grids", entry.impulse, "either an impulse or a strength")
    if entry.impulse is not None:
        impulse = entry.impulse * heavier * scale**_ROOT
    else:
        impulse = (entry.strength or 0.0) * momentum_unit(robot, walk.height or robot.card.gait.height)
    separation = None if entry.separation is None else Limit("separation", scale * entry.separation)
    same = entry.model_dump(include={"least", "goal", "directions", "phases", "offset"})
    return PushGrid(round(impulse, 3), walk, separation=separation, **same)


def walking(fields: dict[str, Any], robot: Robot) -> Scenario:
    """Scenario of a walk whose height and period are written out, so that a grid can name them."""
    gait = robot.card.gait
    usual = {} if "gait" in fields else {"height": gait.height, "period": gait.period}
    return make_scenario({"rest_before": 1.0, **usual, **fields})


def _scaled(value: Any, scale: float, name: str = "") -> Any:
    """Numbers of a reference robot's size in another's, each by the power of its name."""
    if isinstance(value, dict):
        return {key: _scaled(entry, scale, key) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_scaled(entry, scale, name) for entry in value]
    if name in _POWERS and isinstance(value, int | float):
        return round(value * scale ** _POWERS[name], 6)
    return value
