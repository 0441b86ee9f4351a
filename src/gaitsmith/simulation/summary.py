"""What a run achieved, in numbers: speeds per stage, attitude, separation, torques, QP, time."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, ConfigDict, create_model

from gaitsmith.robots.parameters import GAIT_INPUTS

SCORED = 2.0  # s at the end of a stage over which means are taken
Array = npt.NDArray[np.float64]


class _Part(BaseModel):
    """Base of a summary's parts: frozen, and no NaN."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


if TYPE_CHECKING:

    class StageCommand(_Part):
        """Gait inputs that hold during a stage; SI units, zero speed at rest."""

        def __getattr__(self, name: str) -> float: ...

else:
    StageCommand = create_model(
        "StageCommand",
        __base__=_Part,
        __module__=__name__,
        __doc__="Gait inputs that hold during a stage; SI units, zero speed at rest.",
        **{key: (float, ...) for name, about in GAIT_INPUTS.items() for key in about.keys or (name,)},
    )


class Stage(_Part):
    """Between two changes of the command.

    Attributes:
        t0, t1: beginning and end, s.
        rest: whether rest was commanded.
        command: what was commanded.
        scored: beginning and end of the window of the means, s; see :func:`scored_window`.
        vx_mean, vy_mean: CoM velocity in the heading frame, m/s.
        vx_error, vy_error: mean minus command.
        height_mean, height_error: hip midpoint above the stance sole, and that minus the command, m.
        roll_deg, pitch_deg: lowest and highest over the whole stage.
        settled_roll_deg, settled_pitch_deg: the same over the last 2 s.
    """

    t0: float
    t1: float
    rest: bool
    command: StageCommand
    scored: tuple[float, float]
    vx_mean: float
    vx_error: float
    vy_mean: float
    vy_error: float
    height_mean: float
    height_error: float
    roll_deg: tuple[float, float]
    pitch_deg: tuple[float, float]
    settled_roll_deg: tuple[float, float]
    settled_pitch_deg: tuple[float, float]


class FallReport(_Part):
    """A fall: when, in which phase of the step, and why."""

    time: float
    phase: str
    reason: str


class QpCounts(_Part):
    """Whole-body QP: ticks that solved it, that fell back, and that found it infeasible."""

    solves: int
    fallbacks: int
    infeasible: int


class TickTimes(_Part):
    """Wall time of the controller's tick, µs, and how many took longer than the control period of 1 ms."""

    median: float
    p99: float
    max: float
    overruns: int


class Summary(_Part):
    """A run in numbers.

    Attributes:
        fell, fall: whether the robot fell, and the fall.
        interrupted: whether the run was cut short from outside.
        robot, preset, state, terrain, seed: what was run.
        duration: simulated, s.
        steps: taken.
        stages: in order of time, rests included.
        drift: largest horizontal excursion of the torso since the walk began, m.
        distance: horizontal distance between the torso's places at the walk's beginning and at the end, m.
        yaw_deg: lowest and highest.
        min_foot_separation: smallest lateral distance, left minus right, of the sole frames' origins in the heading
            frame, over all physics steps, m.
        leg_contacts: how many times one leg came to touch the other.
        torque_peak: largest magnitude per joint, N·m.
        torque_saturated: share of ticks at the limit, per joint.
        qp: counts of the whole-body QP.
        tick_us: wall time of the controller's tick.
        realtime_factor: simulated over wall time, logging included.
        pushes: when each push began, s; null if it never did.
        warnings: what the physics engine warned of.
    """

    fell: bool
    fall: FallReport | None
    interrupted: bool
    robot: str
    preset: str
    state: str
    terrain: str
    seed: int
    duration: float
    steps: int
    stages: tuple[Stage, ...]
    drift: float
    distance: float
    yaw_deg: tuple[float, float]
    min_foot_separation: float
    leg_contacts: int
    torque_peak: dict[str, float]
    torque_saturated: dict[str, float]
    qp: QpCounts
    tick_us: TickTimes
    realtime_factor: float
    pushes: tuple[float | None, ...]
    warnings: tuple[str, ...]


class Span(NamedTuple):
    """A stage before it is measured: control ticks [first, last), whether at rest, and the command."""

    first: int
    last: int
    rest: bool
    command: StageCommand


def scored_window(first: int, last: int, touchdowns: npt.NDArray[np.int64], control_step: float) -> tuple[int, int]:
    """Ticks [begin, end) over which a stage's means are taken.

    The largest even number of strides (a stride is two steps) between touchdowns of the same leg that fits into the
    last 2 s of the stage, as late as possible; a single stride if no two fit; else these 2 s as they are.

    Args:
        first: tick at which the stage begins.
        last: tick after its end.
        touchdowns: (m, 2) tick and new stance leg of every step, in order of time.
        control_step: s.
    """
    begin = max(first, last - round(SCORED / control_step))
    ticks = touchdowns[(touchdowns[:, 0] >= begin) & (touchdowns[:, 0] <= last)]
    best: tuple[int, int, int] | None = None
    for leg in (0, 1):
        own = ticks[ticks[:, 1] == leg, 0]
        strides = len(own) - 1
        strides -= strides % 2 if strides > 1 else 0
        if strides >= 1:
            found = (strides, int(own[-1]), int(own[-1 - strides]))
            best = found if best is None else max(best, found)
    return (best[2], best[1]) if best else (begin, last)


def _range_deg(values: Array) -> tuple[float, float]:
    """Lowest and highest in degrees."""
    return float(np.degrees(np.min(values))), float(np.degrees(np.max(values)))


def measure_stages(
    spans: list[Span], vitals: Array, touchdowns: npt.NDArray[np.int64], control_step: float
) -> tuple[Stage, ...]:
    """Stages that have at least one tick.

    Args:
        spans: in order of time.
        vitals: (n, 8), one row a tick; see :data:`gaitsmith.simulation.monitor.VITALS`.
        touchdowns: (m, 2) tick and new stance leg.
        control_step: s.
    """
    stages = []
    for span in spans:
        last = min(span.last, len(vitals))
        if last <= span.first:
            continue
        begin, end = (max(span.first, last - round(SCORED / control_step)), last)
        settled = vitals[begin:end]
        if not span.rest:
            begin, end = scored_window(span.first, last, touchdowns, control_step)
        means = np.mean(vitals[begin:end], axis=0)
        whole = vitals[span.first : last]
        stages.append(
            Stage(
                t0=span.first * control_step,
                t1=last * control_step,
                rest=span.rest,
                command=span.command,
                scored=(begin * control_step, end * control_step),
                vx_mean=means[0],
                vx_error=means[0] - span.command.vx,
                vy_mean=means[1],
                vy_error=means[1] - span.command.vy,
                height_mean=means[2],
                height_error=means[2] - span.command.height,
                roll_deg=_range_deg(whole[:, 3]),
                pitch_deg=_range_deg(whole[:, 4]),
                settled_roll_deg=_range_deg(settled[:, 3]),
                settled_pitch_deg=_range_deg(settled[:, 4]),
            )
        )
    return tuple(stages)


def tick_times(nanoseconds: npt.NDArray[np.int64], control_step: float) -> TickTimes:
    """Statistics of the controller's wall times, ns per tick."""
    if not len(nanoseconds):
        return TickTimes(median=0.0, p99=0.0, max=0.0, overruns=0)
    microseconds = nanoseconds / 1000.0
    return TickTimes(
        median=float(np.median(microseconds)),
        p99=float(np.percentile(microseconds, 99)),
        max=float(np.max(microseconds)),
        overruns=int(np.count_nonzero(microseconds > 1e6 * control_step)),
    )
