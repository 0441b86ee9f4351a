"""From the template's sole trajectories to acceleration references of soles and joints (Han 2023, eqs. 20-23)."""

from __future__ import annotations

import math

from gaitsmith.compiled import Matrix, Vector, kernel
from gaitsmith.control.state import ControlState, TickGains
from gaitsmith.dynamics.tree import TreeState
from gaitsmith.template.step import WALK, Gait, StepState
from gaitsmith.whole_body.frames import Frames, Legs
from gaitsmith.whole_body.targets import Targets


@kernel
def heading_to_torso(state: TreeState, legs: Legs, frames: Frames, vector: Vector, is_point: bool, out: Vector) -> None:
    """Express a heading-frame vector (or a point relative to the hip midpoint) in the torso frame."""
    cos_yaw, sin_yaw = frames.heading[1], frames.heading[2]
    x = cos_yaw * vector[0] - sin_yaw * vector[1]
    y = sin_yaw * vector[0] + cos_yaw * vector[1]
    z = vector[2]
    torso = state.body_rotation[legs.torso[0]]
    for i in range(3):
        out[i] = torso[0, i] * x + torso[1, i] * y + torso[2, i] * z
        if is_point:
            out[i] += legs.hip_midpoint[i]


@kernel
def sole_target_rotation(
    state: TreeState, legs: Legs, frames: Frames, leg: int, pitch: float, measured: bool, out: Matrix
) -> None:
    """Rotation torso ← sole: as measured, or level across and pitched by ``pitch`` in the heading frame."""
    torso = state.body_rotation[legs.torso[0]]
    cos_yaw, sin_yaw = frames.heading[1], frames.heading[2]
    cos_pitch, sin_pitch = math.cos(pitch), math.sin(pitch)
    for j in range(3):
        if measured:
            x, y, z = frames.sole_rotation[leg, 0, j], frames.sole_rotation[leg, 1, j], frames.sole_rotation[leg, 2, j]
        elif j == 0:
            x, y, z = cos_yaw * cos_pitch, sin_yaw * cos_pitch, -sin_pitch
        elif j == 1:
            x, y, z = -sin_yaw, cos_yaw, 0.0
        else:
            x, y, z = cos_yaw * sin_pitch, sin_yaw * sin_pitch, cos_pitch
        for i in range(3):
            out[i, j] = torso[0, i] * x + torso[1, i] * y + torso[2, i] * z


@kernel
def swing_pitch(step: StepState, gait: Gait) -> float:
    """Desired pitch of the swing sole: from its pitch at the switch to level during the lifting stage."""
    span = gait.alpha[0] * gait.period[0]
    phase = min(step.time[0] / span, 1.0) if span > 0.0 else 1.0
    return float(step.swing_pitch_start[0] * (1.0 - phase * phase * (3.0 - 2.0 * phase)))


@kernel
def set_joint_targets(legs: Legs, step: StepState, gains: TickGains, control: ControlState, targets: Targets) -> None:
    """Acceleration reference and weight of every joint (eqs. 22 and 23).

    Swing leg: all joints. Stance leg: the knee alone, so that hip and ankle are free to balance. Standing: none.
    Joints outside the legs hold their zero position.
    """
    n_joints = control.joint_reference.shape[0]
    for j in range(n_joints):
        leg = legs.leg_of_joint[j]
        if leg < 0:
            targets.joint_weight[j] = gains.other_joint
            targets.joint_acceleration[j] = (
                -gains.other_stiffness * control.q[7 + j] - gains.other_damping * control.v[6 + j]
            )
            continue
        weight = 0.0
        if step.mode[0] == WALK:
            if leg == step.stance[0]:
                weight = gains.knee if j == legs.knee[leg] else 0.0
            else:
                weight = gains.swing_ankle if j == legs.ankle_pitch[leg] else gains.swing_joint
        targets.joint_weight[j] = weight
        targets.joint_acceleration[j] = gains.joint_stiffness * (
            control.joint_reference[j] - control.q[7 + j]
        ) + gains.joint_damping * (control.joint_rate[j] - control.v[6 + j])


@kernel
def set_swing_targets(
    step: StepState, gains: TickGains, frames: Frames, control: ControlState, targets: Targets
) -> None:
    """Acceleration of the swing sole relative to the hip midpoint (eq. 20, with the template's own acceleration)."""
    for leg in range(2):
        actual = frames.relative[leg]
        for axis in range(3):
            targets.swing_acceleration[leg, axis] = (
                control.foot_desired[3 * leg + 2, axis]
                + gains.foot_stiffness * (control.foot_desired[3 * leg, axis] - actual[0, axis])
                + gains.foot_damping * (control.foot_desired[3 * leg + 1, axis] - actual[1, axis])
            )


@kernel
def set_standing_targets(
    state: TreeState, gains: TickGains, frames: Frames, control: ControlState, targets: Targets
) -> None:
    """CoM towards the middle of the soles, hip midpoint towards the standing height."""
    middle_x = 0.5 * (frames.sole_position[0, 0] + frames.sole_position[1, 0]) - state.com[0]
    middle_y = 0.5 * (frames.sole_position[0, 1] + frames.sole_position[1, 1]) - state.com[1]
    cos_yaw, sin_yaw = frames.heading[1], frames.heading[2]
    error_x = cos_yaw * middle_x + sin_yaw * middle_y
    error_y = cos_yaw * middle_y - sin_yaw * middle_x
    floor = 0.5 * (frames.sole_position[0, 2] + frames.sole_position[1, 2])
    height = frames.hip_position[2] - floor
    rise = 0.0
    for leg in range(2):
        rise -= 0.5 * frames.relative[leg, 1, 2]
    targets.body_acceleration[0] = gains.standing_stiffness * error_x - gains.standing_damping * frames.com_velocity[0]
    targets.body_acceleration[1] = gains.standing_stiffness * error_y - gains.standing_damping * frames.com_velocity[1]
    targets.body_acceleration[2] = (
        gains.standing_stiffness * (control.standing_height[0] - height) - gains.standing_damping * rise
    )


@kernel
def set_ankle_targets(
    step: StepState, gait: Gait, legs: Legs, gains: TickGains, frames: Frames, targets: Targets
) -> None:
    """Soft stance ankle torque against the speed error; too fast presses the toe down."""
    error = frames.com_velocity[0] - gait.speed[0] if step.mode[0] == WALK else 0.0
    wanted = min(max(gains.ankle_speed_gain * error, -gains.ankle_torque_limit), gains.ankle_torque_limit)
    for leg in range(2):
        targets.ankle_torque[leg] = legs.ankle_sign[leg] * wanted
