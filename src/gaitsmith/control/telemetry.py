"""What the controller reports of one tick, in one contiguous buffer that a recorder copies in one go."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from gaitsmith.compiled import Vector


class Telemetry(NamedTuple):
    """One tick as the controller sees it (SI units; heading frame where not said).

    Attributes:
        time: since the reset, s.
        mode: 0 standing, 1 walking.
        stance: 0 left, 1 right, 2 both.
        step_time: since the step began, s.
        step_count: steps taken since the reset.
        step_duration: duration of the previous step, s.
        command: latched speed x and y (m/s), period (s), alpha, height, lift, width (m).
        com_velocity: (3,) m/s.
        tilt: roll, pitch (rad), roll rate, pitch rate (rad/s).
        yaw: rad.
        hip_height: hip midpoint above the stance sole, m.
        foothold: (2,) target of the swing sole, hip midpoint, m.
        foothold_bound: 1 if the target lies on one of its bounds.
        integral: (2,) bias integral, m.
        foot_desired: (6,) left, right sole, hip midpoint, m.
        foot_actual: (6,) the same as measured or estimated.
        joint_desired: (nj,) rad.
        joint_position: (nj,) rad.
        joint_velocity: (nj,) rad/s.
        torque_feedforward: (nj,) from the whole-body QP, N·m.
        torque: (nj,) sent to the joints, N·m.
        wrench: (12,) planned force and moment on left and right sole, world axes, N and N·m.
        zmp: (4,) planned x and y in the left and the right contact frame, m; NaN-free, 0 in the air.
        sole_force: (2,) measured, N.
        qp_status: 0 optimal; see control.quadratic_program.
        qp_iterations: changes of the active set in this tick.
        qp_solves: since the reset.
        qp_fallbacks: since the reset.
        qp_infeasible: since the reset.
        ik_fallbacks: since the reset.
        touchdowns_forced: steps ended by the clock instead of by contact.
    """

    time: Vector
    mode: Vector
    stance: Vector
    step_time: Vector
    step_count: Vector
    step_duration: Vector
    command: Vector
    com_velocity: Vector
    tilt: Vector
    yaw: Vector
    hip_height: Vector
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
    touchdowns_forced: Vector


_AXES = ("x", "y", "z")
_SIDES = ("left", "right")
_LABELS: dict[str, tuple[str, ...]] = {
    "command": ("speed_x", "speed_y", "period", "alpha", "height", "lift", "width"),
    "com_velocity": _AXES,
    "tilt": ("roll", "pitch", "roll_rate", "pitch_rate"),
    "foothold": ("x", "y"),
    "integral": ("x", "y"),
    "foot_desired": tuple(f"{side}.{axis}" for side in _SIDES for axis in _AXES),
    "foot_actual": tuple(f"{side}.{axis}" for side in _SIDES for axis in _AXES),
    "wrench": tuple(f"{side}.{kind}{axis}" for side in _SIDES for kind in "fm" for axis in _AXES),
    "zmp": tuple(f"{side}.{axis}" for side in _SIDES for axis in ("x", "y")),
    "sole_force": _SIDES,
}
_PER_JOINT = ("joint_desired", "joint_position", "joint_velocity", "torque_feedforward", "torque")


def make_telemetry(joint_names: tuple[str, ...]) -> tuple[Telemetry, npt.NDArray[np.float64], list[str]]:
    """Telemetry over one buffer, the buffer, and the name of every column."""
    labels = {**_LABELS, **dict.fromkeys(_PER_JOINT, joint_names)}
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
