"""What the controller reports of one tick, in one contiguous buffer that a recorder copies in one go."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from gaitsmith.compiled import Vector
from gaitsmith.estimation.measurement import Measurement
from gaitsmith.estimation.readings import channel_names


class Telemetry(NamedTuple):
    """One tick as the controller sees it (SI units; heading frame where not said).

    Attributes:
        time: since the reset, s.
        control_state: see control.state.STATE_NAMES.
        mode: 0 on both feet, 1 walking.
        stance: row of the stance leg; the number of legs when all bear.
        step_time: since the step began, s.
        step_count: steps taken since the reset.
        step_duration: duration of the previous step, s.
        command: latched gait inputs, as :data:`gaitsmith.robots.parameters.GAIT_INPUTS` names them.
        com_velocity: (3,) m/s.
        tilt: roll, pitch (rad), roll rate, pitch rate (rad/s).
        yaw: rad.
        yaw_rate: rad/s.
        heading: yaw that the torso is to have, rad.
        hip_height: hip midpoint above the stance sole, m.
        plan_phase: number of the phase of the plan that is followed, -1 without one.
        plan_lead: by which the plan is ahead of the time that has passed, s.
        foothold: (2,) target of the swing sole, hip midpoint, m.
        foothold_bound: 1 if the target lies on one of its bounds.
        integral: (2,) what is added to the commanded speed, m/s.
        foot_desired: (3 n,) every sole, hip midpoint, m.
        foot_actual: (3 n,) the same as measured or estimated.
        joint_desired: (nj,) rad.
        joint_position: (nj,) rad.
        joint_velocity: (nj,) rad/s.
        torque_feedforward: (nj,) from the whole-body QP, N·m.
        torque: (nj,) sent to the joints, N·m.
        wrench: (6 n,) planned force and moment on every sole, world axes, N and N·m.
        zmp: (2 n,) planned x and y of every sole, contact axes, from the sole frame's origin, m; 0 in the air.
        sole_force: (n,) measured, N.
        qp_status: 0 optimal; see control.quadratic_program.
        qp_iterations: changes of the active set in this tick.
        qp_solves: since the reset.
        qp_fallbacks: since the reset.
        qp_infeasible: since the reset.
        ik_fallbacks: since the reset.
        stops_dropped: ticks that could not keep every joint off its stops.
        touchdowns_forced: steps ended by the clock instead of by contact.
        refused: (8,) ticks in which readings were replaced, by sensor.
        refused_ticks: ticks with any.
        missed_ticks: ticks that came too late to be done.
        reading: (m,) what is wrong with each channel, see estimation.readings.WHAT.
        motor: (nj,) 1 for a motor that gives less torque than it is told.
        reading_changes: how many times a channel or a motor has gone wrong or good.
        reading_lost: number of what the robot cannot do without, see estimation.readings.Readings.culprit.
    """

    time: Vector
    control_state: Vector
    mode: Vector
    stance: Vector
    step_time: Vector
    step_count: Vector
    step_duration: Vector
    command: Vector
    com_velocity: Vector
    tilt: Vector
    yaw: Vector
    yaw_rate: Vector
    heading: Vector
    hip_height: Vector
    plan_phase: Vector
    plan_lead: Vector
    foothold: Vector
    foothold_bound: Vector
    integral: Vector
    foot_desired: Vector
    foot_actual: Vector
    joint_desired: Vector
    joint_position: Vector
    joint_velocity: Vector
    torque_feedforward: Vector
    torque: Vector
    wrench: Vector
    zmp: Vector
    sole_force: Vector
    qp_status: Vector
    qp_iterations: Vector
    qp_solves: Vector
    qp_fallbacks: Vector
    qp_infeasible: Vector
    ik_fallbacks: Vector
    stops_dropped: Vector
    touchdowns_forced: Vector
    refused: Vector
    refused_ticks: Vector
    missed_ticks: Vector
    reading: Vector
    motor: Vector
    reading_changes: Vector
    reading_lost: Vector


_AXES = ("x", "y", "z")
_PER_JOINT = ("joint_desired", "joint_position", "joint_velocity", "torque_feedforward", "torque", "motor")


def _labels(joints: tuple[str, ...], soles: tuple[str, ...], inputs: tuple[str, ...]) -> dict[str, tuple[str, ...]]:
    """Names of the entries of every field that has more than one."""

    def each(parts: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(f"{sole}.{part}" for sole in soles for part in parts)

    return {
        "command": inputs,
        "com_velocity": _AXES,
        "tilt": ("roll", "pitch", "roll_rate", "pitch_rate"),
        "foothold": ("x", "y"),
        "integral": ("x", "y"),
        "foot_desired": each(_AXES),
        "foot_actual": each(_AXES),
        "wrench": each(tuple(kind + axis for kind in "fm" for axis in _AXES)),
        "zmp": each(("x", "y")),
        "sole_force": soles,
        "refused": Measurement._fields,
        "reading": channel_names(joints, soles),
        **dict.fromkeys(_PER_JOINT, joints),
    }


def make_telemetry(
    joints: tuple[str, ...], soles: tuple[str, ...], inputs: tuple[str, ...]
) -> tuple[Telemetry, npt.NDArray[np.float64], list[str]]:
    """Telemetry over one buffer, the buffer, and the name of every column; ``inputs`` names the gait's numbers."""
    labels = _labels(joints, soles, inputs)
    columns = [
        f"{field}.{label}" if label else field for field in Telemetry._fields for label in labels.get(field, ("",))
    ]
    buffer = np.zeros(len(columns))
    views, start = [], 0
    for field in Telemetry._fields:
        size = len(labels.get(field, ("",)))
        views.append(buffer[start : start + size])
        start += size
    return Telemetry(*views), buffer, columns
