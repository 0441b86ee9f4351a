"""What the reference tick remembers, as plain attributes, and how to read it off a compiled controller."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from gaitsmith.control import Controller

Array = npt.NDArray[np.float64]

LEFT, RIGHT = 0, 1


@dataclass
class GaitNumbers:
    """The gait template's inputs."""

    speed: Array  # (2,)
    period: float
    alpha: float
    height: float
    lift: float
    width: float


@dataclass
class Memory:
    """Between two ticks. Soles are left, right; positions relative to the hip midpoint in the heading frame."""

    walking: bool
    walk_requested: bool
    stance: int  # of the present step
    step_count: int
    step_time: float
    last_duration: float
    duration_ratio: float  # of the period, how long steps last
    support_start: Array  # (3, 3) desired state of the support sole when the step began
    swing_start: Array  # (2, 3) actual state of the swing sole when the step began
    swing_pitch_start: float
    velocity_sum: Array  # (2,) over the step's ticks, heading frame
    position_sum: Array  # (2,) over the step's ticks, world
    ticks: int
    settling: int  # steps before the integral learns again
    last_mean_velocity: Array  # (2,)
    last_position: Array  # (2,)
    integral: Array  # (2,)
    station: Array  # (2,)
    station_kept: bool
    gait: GaitNumbers  # latched
    foot_desired: Array  # (2, 3, 3) sole, derivative, axis
    foothold: Array  # (2,)
    standing_height: float
    leg_reference: Array  # (2, n_leg)
    leg_rate: Array  # (2, n_leg)
    torque: Array  # (nj,) sent
    feedforward: Array  # (nj,) of the whole-body QP
    acceleration: Array  # (nv,) that it predicted


def requested_gait(controller: Controller) -> GaitNumbers:
    """The gait that was asked for last."""
    return _gait(controller._groups.requested)


def read_memory(controller: Controller) -> Memory:
    """A copy of what the compiled controller remembers now."""
    step, control, body = (getattr(controller._groups, name) for name in ("step", "control", "whole_body"))
    return Memory(
        walking=bool(step.mode[0]),
        walk_requested=bool(step.walk_requested[0]),
        stance=int(step.stance[0]),
        step_count=int(step.count[0]),
        step_time=float(step.time[0]),
        last_duration=float(step.last_duration[0]),
        duration_ratio=float(step.duration_ratio[0]),
        support_start=step.support_start.copy(),
        swing_start=step.swing_start.copy(),
        swing_pitch_start=float(step.swing_pitch_start[0]),
        velocity_sum=step.velocity_sum.copy(),
        position_sum=step.position_sum.copy(),
        ticks=int(step.velocity_ticks[0]),
        settling=int(step.settling[0]),
        last_mean_velocity=step.last_mean_velocity.copy(),
        last_position=step.last_position.copy(),
        integral=step.integral.copy(),
        station=step.station.copy(),
        station_kept=bool(step.station_kept[0]),
        gait=_gait(controller._groups.latched),
        foot_desired=control.foot_desired.reshape(2, 3, 3).copy(),
        foothold=control.foothold.copy(),
        standing_height=float(control.standing_height[0]),
        leg_reference=control.leg_reference.copy(),
        leg_rate=control.leg_rate.copy(),
        torque=control.torque.copy(),
        feedforward=body.torque.copy(),
        acceleration=body.acceleration.copy(),
    )


def _gait(gait) -> GaitNumbers:
    return GaitNumbers(gait.speed.copy(), *(float(value[0]) for value in gait[1:]))


def differences(one: Memory, other: Memory) -> dict[str, float]:
    """Largest difference of every attribute, relative to its size where that exceeds 1."""
    found = {}
    for field in fields(Memory):
        a, b = getattr(one, field.name), getattr(other, field.name)
        if field.name == "gait":
            a, b = (np.concatenate([np.ravel(getattr(g, f.name)) for f in fields(GaitNumbers)]) for g in (a, b))
        a, b = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
        found[field.name] = float(np.max(np.abs(a - b)) / max(1.0, float(np.max(np.abs(b)))))
    return found
