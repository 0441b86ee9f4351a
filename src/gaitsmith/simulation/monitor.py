"""Watches a run tick by tick, compiled and in bounded memory: vital signs, touchdowns, torques, limits, falls."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from gaitsmith.compiled import Arena, IntVector, Vector, bind, kernel
from gaitsmith.robots.parameters import at_rest, gait_numbers
from gaitsmith.simulation.limits import (
    Bounds,
    Hits,
    Joints,
    Seen,
    find_hits,
    make_bounds,
    make_hits,
    remember_hits,
    watch_joints,
)
from gaitsmith.simulation.stages import ENTERED, REMEMBERED, Signals, Span, measure_stage
from gaitsmith.simulation.summary import Stage, StageCommand
from gaitsmith.simulation.truth import Truth, truth_columns

if TYPE_CHECKING:
    from collections.abc import Mapping

    from gaitsmith.log.columns import Columns
    from gaitsmith.robots import Robot
    from gaitsmith.robots.presets import ControlParameters

UPRIGHT, TILTED, SANK, TOUCHED, DIVERGED = range(5)
"""What :attr:`Monitor.state` can be; all but the first are falls."""

SETTLING = 1.5  # s after a push, a command or the start of a walk in which it does not count as undisturbed
_MAX_TILT = math.radians(60.0)
_TOUCHDOWNS = 256  # remembered; no robot takes more steps in the time that signals are kept
_TURN = 2.0 * math.pi
_NEVER = 2**62
_BEGINNINGS = ("walk", "follow")

_TOLD = {name: f"command.{name}" for name in ("period", "height", "yaw_rate")} | {"believed_velocity": "com_velocity"}
_UNTOLD = {"believed_velocity": math.nan}


class Ring(NamedTuple):
    """Signals of the last ticks, row ``tick % n``; and a ring over steps: when one began, and its stance leg."""

    signals: Signals
    touchdown: IntVector
    leg: IntVector


class Range(NamedTuple):
    """Lowest and highest of a signal."""

    low: Vector
    high: Vector


class StageTotals(NamedTuple):
    """Over the present stage: ranges of roll and pitch, heading at its beginning, turn commanded since; rad."""

    roll: Range
    pitch: Range
    heading: Vector
    commanded: Vector


class Kept(NamedTuple):
    """What the monitor writes."""

    ring: Ring
    stage: StageTotals
    joints: Joints
    hits: Hits
    yaws: Range  # rad
    headings: Range  # rad; the heading goes on where the yaw turns over
    ticks: IntVector  # watched so far
    upright: IntVector  # of them, without the fall
    steps: IntVector  # touchdowns so far
    quiet_from: IntVector  # tick from which on the walk counts as undisturbed
    heading: Vector  # of the tick before, rad
    yaw: Vector  # the same
    step_count: Vector  # the same
    place: Vector  # (2,) of the torso when it was upright last, world, m


class Watched(NamedTuple):
    """All that the monitor's kernel reads and writes."""

    seen: Seen
    bounds: Bounds
    kept: Kept


@kernel
def _widen(span: Range, value: float) -> None:
    span.low[0] = min(span.low[0], value)
    span.high[0] = max(span.high[0], value)


@kernel
def _keep_vitals(seen: Seen, bounds: Bounds, kept: Kept, stance: int) -> None:
    """One tick of an upright robot into the ring and the stage."""
    ring, tick, yaw = kept.ring.signals, kept.ticks[0], seen.attitude[2]
    first = kept.upright[0] == 0
    turn = 0.0 if first else (yaw - kept.yaw[0] + 0.5 * _TURN) % _TURN - 0.5 * _TURN
    kept.heading[0] = yaw if first else kept.heading[0] + turn
    kept.yaw[0] = yaw
    row = tick % ring.height.shape[0]
    ring.speed_x[row], ring.speed_y[row] = seen.com_velocity[0], seen.com_velocity[1]
    both = 0.5 * (seen.hip_height[0] + seen.hip_height[1])
    ring.height[row] = both if stance > 1 else seen.hip_height[stance]
    ring.roll[row], ring.pitch[row], ring.heading[row] = seen.attitude[0], seen.attitude[1], kept.heading[0]
    _widen(kept.stage.roll, seen.attitude[0])
    _widen(kept.stage.pitch, seen.attitude[1])
    _widen(kept.yaws, yaw)
    _widen(kept.headings, kept.heading[0])
    if math.isnan(kept.stage.heading[0]):
        kept.stage.heading[0] = kept.heading[0]
    elif seen.mode[0] > 0.0:
        kept.stage.commanded[0] += seen.yaw_rate[0] * bounds.dt
    kept.place[0], kept.place[1] = seen.torso[0], seen.torso[1]
    kept.upright[0] += 1


@kernel
def _watch(address: int) -> int:
    """One tick; returns UPRIGHT or the kind of fall."""
    watched = bind(Watched, address)
    seen, bounds, kept = watched.seen, watched.bounds, watched.kept
    stance, ring = int(seen.stance[0]), kept.ring
    stepped = seen.step_count[0] > kept.step_count[0]
    find_hits(seen, bounds, kept.hits)
    remember_hits(seen, bounds, kept.hits, kept.ticks[0], stepped)
    watch_joints(seen, bounds, kept.joints, kept.ticks[0] >= kept.quiet_from[0])
    if stepped:
        place = kept.steps[0] % ring.leg.shape[0]
        # A sole of a plan lands while the other still bears: then legs take turns.
        other = 1 - ring.leg[(kept.steps[0] - 1) % ring.leg.shape[0]]
        ring.touchdown[place], ring.leg[place] = kept.ticks[0], stance if stance <= 1 else other
        kept.steps[0] += 1
    kept.step_count[0] = seen.step_count[0]
    state = UPRIGHT
    if seen.diverged[0] > 0.0:
        state = DIVERGED
    elif not math.cos(seen.attitude[0]) * math.cos(seen.attitude[1]) > math.cos(_MAX_TILT):
        state = TILTED
    elif max(seen.hip_height[0], seen.hip_height[1]) < 0.5 * seen.height[0]:
        state = SANK
    elif seen.body_contact[0] > 0.0:
        state = TOUCHED
    if state == UPRIGHT:
        _keep_vitals(seen, bounds, kept, stance)
    kept.ticks[0] += 1
    return state


class Monitor:
    """Watches one run.

    Args:
        robot: whose limits apply.
        parameters: of the controller, whose bounds apply.
        columns: telemetry of the controller, and what is true of the robot (``true.*``) or believed (``believed.*``).
        dt: s from one observation to the next.
        gait: what is commanded at first, by name.

    Attributes:
        state: UPRIGHT, or the kind of fall.
        prefix: of the columns that tell where the robot is: ``true.``, or ``believed.`` where nobody knows the truth.
        kept: what has been seen.
        limit_names: of the limits in ``kept.hits``.
        walked_from: (2,) place of the torso when a walk was asked for first, world, m.
    """

    def __init__(
        self, robot: Robot, parameters: ControlParameters, columns: Columns, dt: float, gait: Mapping[str, Any]
    ) -> None:
        self.dt, self.state, self.joint_names = dt, UPRIGHT, tuple(robot.joint_names)
        hits, self.limit_names = make_hits(self.joint_names, tuple(leg.name for leg in robot.legs), dt)
        self.prefix = "true." if columns.labels("true") else "believed."
        self._seen = _views(columns, self.prefix, [leg.name for leg in robot.legs])
        kept = _blank(len(robot.joint_names), hits, round(REMEMBERED / dt) + 1)
        self._arena = Arena(Watched(self._seen, make_bounds(robot, parameters, dt), kept))
        for shared, given in zip(self._arena.view.seen, self._seen, strict=True):
            if not np.shares_memory(shared, given):
                raise TypeError("what the monitor watches must be float64 views of contiguous buffers")
        self.kept: Kept = self._arena.view.kept
        self._address = self._arena.address
        self.walked_from: npt.NDArray[np.float64] | None = None
        self._gait, self._rest, self._began, self._pushes = dict(gait), True, 0, 0
        self._loop: int | None = None
        self._from: npt.NDArray[np.float64] | None = None  # place where a plan began, m
        self._stages: list[bytes] = []

    def observe(self, tick: int) -> bool:
        """Take note of the present tick; whether the robot has fallen."""
        self.state = _watch(self._address)
        return self.state != UPRIGHT

    def hear(self, event: Mapping[str, Any]) -> None:
        """Take note of a command, or of a plan that leaves its loop, which begin a stage, or of a push: all disturb."""
        if event.get("plan") == ENTERED:
            self._loop = self.ticks
            return
        if "push" in event:
            self._pushes += -1 if event.get("over") else 1
        self.kept.quiet_from[0] = _NEVER if self._pushes else self.ticks + round(SETTLING / self.dt)
        if not {"command", "action", "plan"} & set(event):
            return
        if self._began < self.ticks:
            self._stages.append(self._stage().model_dump_json().encode())
            _restart(self.kept.stage)
            self._began = self.ticks
        self._loop, self._from = None, self._seen.torso[:2].copy() if event.get("action") == "follow" else None
        self._gait.update(event.get("command", {}))
        action = "stand" if "plan" in event else event.get("action")
        if action in _BEGINNINGS and self.walked_from is None:
            self.walked_from = self._seen.torso[:2].copy()
        self._rest = action == "stand" or (self._rest and action not in _BEGINNINGS)
        if action == "stand":
            self._gait = at_rest(self._gait)

    @property
    def ticks(self) -> int:
        """Ticks watched."""
        return int(self.kept.ticks[0])

    @property
    def distance(self) -> float:
        """Horizontal distance between the torso's places when a walk was asked for first and now, m."""
        return 0.0 if self.walked_from is None else float(np.hypot(*(self.kept.place - self.walked_from)))

    def stages(self) -> tuple[Stage, ...]:
        """All stages so far, the present one included if it has a tick."""
        done = tuple(map(Stage.model_validate_json, self._stages))
        return (*done, self._stage()) if self._began < self.kept.upright[0] else done

    def hits(self) -> list[tuple[str, int]]:
        """Limits hit since the last step without any, and the tick of each one's first hit, oldest first."""
        found = [(name, int(tick)) for name, tick in zip(self.limit_names, self.kept.hits.first, strict=True)]
        return sorted([hit for hit in found if hit[1] >= 0], key=lambda hit: hit[1])

    def dated_hits(self, time: float) -> list[tuple[str, float]]:
        """The same with times, s, if the present tick's is ``time``."""
        now = self.ticks - 1
        return [(name, time - (now - tick) * self.dt) for name, tick in self.hits()]

    def touchdowns(self) -> npt.NDArray[np.int64]:
        """(m, 2) tick and new stance leg of the latest steps."""
        ring, steps = self.kept.ring, int(self.kept.steps[0])
        at = np.arange(max(0, steps - len(ring.leg)), steps) % len(ring.leg)
        return np.stack([ring.touchdown[at], ring.leg[at]], axis=1)

    def _way(self) -> tuple[float, float] | None:
        """Way of a plan without a loop so far, ahead and to the left of the mean of its first and last heading, m."""
        if self._from is None or self._loop is not None:
            return None
        x, y = (self.kept.place - self._from).tolist()
        middle = 0.5 * float(self.kept.heading[0] + self.kept.stage.heading[0])
        return math.cos(middle) * x + math.sin(middle) * y, math.cos(middle) * y - math.sin(middle) * x

    def _stage(self) -> Stage:
        """The present stage as far as it has come."""
        kept, last = self.kept, int(self.kept.upright[0])
        gait = at_rest(self._gait) if self._rest else self._gait
        command = StageCommand.model_validate({key: value for key, _, value in gait_numbers(gait, keys=True)})
        size = len(kept.ring.signals.height)
        first = max(0, last - size)
        at = np.arange(first, last) % size
        signals = Signals(*(signal[at] for signal in kept.ring.signals))
        span = Span(self._began, last, self._rest, command, self._loop, self._way())
        turned = kept.heading[0] - kept.stage.heading[0] - kept.stage.commanded[0]
        ranges = [(float(span.low[0]), float(span.high[0])) for span in (kept.stage.roll, kept.stage.pitch)]
        return measure_stage(span, first, signals, self.touchdowns(), ranges[0], ranges[1], float(turned), self.dt)


def _views(columns: Columns, prefix: str, legs: list[str]) -> Seen:
    """Where everything lies; what a controller does not report is zero, or NaN where zero would say something."""
    found: dict[str, Vector] = {}
    for field in Seen._fields:
        if field in Truth._fields:
            found[field] = columns.block([prefix + name for name in truth_columns(legs)[field]])
        else:
            view = columns.find(_TOLD.get(field, field))
            found[field] = np.full(2, _UNTOLD.get(field, 0.0)) if view is None else view
    return Seen(**found)


def _range() -> Range:
    return Range(np.full(1, np.inf), np.full(1, -np.inf))


def _restart(stage: StageTotals) -> None:
    """A new stage."""
    for span in (stage.roll, stage.pitch):
        span.low[0], span.high[0] = np.inf, -np.inf
    stage.heading[0], stage.commanded[0] = np.nan, 0.0


def _blank(nj: int, hits: Hits, length: int) -> Kept:
    """Nothing seen yet."""
    signals = Signals(*np.zeros((len(Signals._fields), length)))
    ring = Ring(signals, *np.zeros((2, _TOUCHDOWNS), dtype=np.int64))
    stage = StageTotals(_range(), _range(), np.full(1, np.nan), np.zeros(1))
    joints, (ticks, upright, steps, quiet_from) = np.zeros((len(Joints._fields), nj)), np.zeros((4, 1), dtype=np.int64)
    heading, yaw, step_count = np.zeros((3, 1))
    numbers = (ticks, upright, steps, quiet_from, heading, yaw, step_count, np.zeros(2))
    return Kept(ring, stage, Joints(*joints), hits, _range(), _range(), *numbers)
