"""The template as a producer of references: soles, joints, balance and torso of a walk (Han 2023, eqs. 20-23)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import Matrix, Vector, kernel
from gaitsmith.dynamics.tree import TreeState
from gaitsmith.kinematics.inverse import InverseGains, InverseKinematics, LegTable, leg_row, leg_step
from gaitsmith.qp.quadratic_program import QuadraticProgram
from gaitsmith.template.balance import CopGains, divergent_reference, stance_cop
from gaitsmith.template.foothold import (
    FootholdGains,
    Forecast,
    SpeedGains,
    choose_speed,
    foothold_target,
    forecast_touchdown,
    observe_motion,
    pendulum_frequency,
)
from gaitsmith.template.phase import com_over_sole, within_turn
from gaitsmith.template.step import GaitInputs, StepState
from gaitsmith.template.step_time import StepTimeGains, adapt_duration
from gaitsmith.template.touchdown import TouchdownRule
from gaitsmith.template.trajectory import support_height, swing_foot, swing_pitch, swing_yaw
from gaitsmith.whole_body.frames import Frames, to_heading
from gaitsmith.whole_body.legs import Legs
from gaitsmith.whole_body.reference import FLAT, HIPS, NONE, Reference, level_rotation


class JointShares(NamedTuple):
    """Weights of the legs' joints while walking: stance knee, swing joints, swing ankle, 1/(rad/s²)²."""

    knee: float
    swing_joint: float
    swing_ankle: float


class Balance(NamedTuple):
    """Scratch of the balance; heading frame.

    Attributes:
        divergent: (2,) reference of the divergent component, relative to the stance sole, m.
        cop: (2,) wanted centre of pressure, relative to the stance sole, m.
        foot: (2,) swing sole relative to the CoM, m.
        curve: (3,) one coordinate, its rate and acceleration.
        position: (3,) a sole in the torso frame, m.
        velocity: (3,) its velocity, m/s.
        rotation: (3, 3) sole to torso.
        torque: (nj,) N·m, of a tick before it is bounded.
    """

    divergent: Vector
    cop: Vector
    foot: Vector
    curve: Vector
    position: Vector
    velocity: Vector
    rotation: Matrix
    torque: Vector


def make_balance(n_joints: int) -> Balance:
    """Scratch for a robot with ``n_joints`` joints."""
    pairs, triples = [np.zeros(2) for _ in range(3)], [np.zeros(3) for _ in range(3)]
    return Balance(*pairs, *triples, np.zeros((3, 3)), np.zeros(n_joints))  # type: ignore[call-arg]


@kernel
def plan_step(
    step: StepState,
    latched: GaitInputs,
    foothold: FootholdGains,
    speed: SpeedGains,
    times: StepTimeGains,
    touchdown: TouchdownRule,
    forecast: Forecast,
    balance: Balance,
    legs: Legs,
    frames: Frames,
    tree_state: TreeState,
    acceleration: Vector,
    dt: float,
) -> None:
    """Desired sole states of this tick; the foothold follows the CoM.

    ``acceleration`` (nv,) is what the last whole-body solution predicted.
    """
    stance = step.stance[0]
    swing = legs.other[stance]
    side = legs.side[swing]
    com = tree_state.com
    support_height(step, latched, balance.curve)
    support = step.foot_desired[stance]
    for axis in range(2):
        support[0, axis] = frames.relative_position[stance, axis]
        support[1, axis] = frames.relative_velocity[stance, axis]
        support[2, axis] = 0.0
    for order in range(3):
        support[order, 2] = balance.curve[order]
    observe_motion(step, frames.com_velocity, com)
    com_over_sole(frames, com, stance, forecast.arm)
    to_heading(frames, com[0] - step.station[0], com[1] - step.station[1], forecast.drift)
    x, y = tree_state.com_bias[0], tree_state.com_bias[1]
    for k in range(acceleration.shape[0]):
        x += tree_state.com_jacobian[0, k] * acceleration[k]
        y += tree_state.com_jacobian[1, k] * acceleration[k]
    to_heading(frames, x, y, forecast.acceleration)
    choose_speed(step, latched, speed, forecast)
    for axis in range(2):
        balance.foot[axis] = frames.relative_position[swing, axis] - frames.com_offset[axis]
    adapt_duration(step, latched, foothold, times, forecast, frames.com_velocity, balance.foot, side, dt)
    forecast_touchdown(step, latched, foothold, frames.com_velocity, side, forecast)
    beside = frames.relative_position[stance, 1]
    foothold_target(step, latched, foothold, forecast, frames.com_offset, beside, side, step.foothold)
    swing_foot(
        step,
        latched,
        step.foothold,
        -latched.height[0],
        touchdown.descent_speed,
        balance.curve,
        step.foot_desired[swing],
    )


@kernel
def restart_leg(step: StepState, legs: Legs, leg: int, q: Vector, v: Vector) -> None:
    """Restart a leg's inverse kinematics from its measured joints (section 2.2, second rule)."""
    for i in range(legs.joints.shape[1]):
        joint = legs.joints[leg, i]
        step.leg_reference[leg, i] = q[7 + joint]
        step.leg_rate[leg, i] = v[6 + joint]


@kernel
def _to_torso(torso: Matrix, frames: Frames, vector: Vector, out: Vector) -> None:
    """A heading-frame vector in the torso frame."""
    c, s = frames.cos_yaw[0], frames.sin_yaw[0]
    x, y, z = c * vector[0] - s * vector[1], s * vector[0] + c * vector[1], vector[2]
    for i in range(3):
        out[i] = torso[0, i] * x + torso[1, i] * y + torso[2, i] * z


@kernel
def track_leg(
    step: StepState,
    gains: InverseGains,
    chains: LegTable,
    scratch: InverseKinematics,
    program: QuadraticProgram,
    balance: Balance,
    legs: Legs,
    frames: Frames,
    tree_state: TreeState,
    reference: Reference,
    leg: int,
    dt: float,
) -> None:
    """One inverse-kinematics step of one leg towards its desired sole; its joints become references."""
    torso = tree_state.body_rotation[legs.torso[0]]
    desired = step.foot_desired[leg]
    _to_torso(torso, frames, desired[0], balance.position)
    _to_torso(torso, frames, desired[1], balance.velocity)
    wanted = reference.sole_rotation[leg]
    for i in range(3):
        balance.position[i] += legs.hip_midpoint[i]
        for j in range(3):
            balance.rotation[i, j] = (
                torso[0, i] * wanted[0, j] + torso[1, i] * wanted[1, j] + torso[2, i] * wanted[2, j]
            )
    status = leg_step(
        leg_row(chains, leg),
        scratch,
        program,
        chains.active[leg],
        gains,
        step.leg_reference[leg],
        step.leg_rate[leg],
        balance.position,
        balance.velocity,
        balance.rotation,
        dt,
    )
    if status != 0:
        step.inverse_fallbacks[0] += 1
    for i in range(legs.joints.shape[1]):
        joint = legs.joints[leg, i]
        reference.joint[0, joint] = step.leg_reference[leg, i]
        reference.joint[1, joint] = step.leg_rate[leg, i]


@kernel
def set_torso(step: StepState, legs: Legs, turns: int, frames: Frames, reference: Reference) -> None:
    """Torso upright; its heading held, or turned as commanded, on legs that can turn."""
    yaw, rate = frames.yaw[0], 0.0
    if turns == 1:
        away = within_turn(step.heading[0] - yaw)
        yaw += min(max(away, -0.5), 0.5)
        rate = 1.0
    level_rotation(math.cos(yaw), math.sin(yaw), 1.0, 0.0, reference.torso_rotation)
    reference.torso_weight[0] = reference.torso_weight[1] = 1.0
    reference.torso_weight[2] = rate
    for axis in range(3):
        reference.torso_spin[axis] = 0.0
        reference.torso_angular_acceleration[axis] = 0.0


@kernel
def hold_posture(legs: Legs, reference: Reference) -> None:
    """Joints outside the legs hold their posture; those of the legs have no reference yet."""
    for j in range(legs.leg_of_joint.shape[0]):
        outside = legs.leg_of_joint[j] < 0
        reference.joint_weight[j] = 1.0 if outside else 0.0
        reference.joint[2, j] = 0.0
        if outside:
            reference.joint[0, j], reference.joint[1, j] = legs.home[j], 0.0


@kernel
def refer_walking(
    step: StepState,
    latched: GaitInputs,
    foothold: FootholdGains,
    cop: CopGains,
    shares: JointShares,
    forecast: Forecast,
    balance: Balance,
    legs: Legs,
    frames: Frames,
    reference: Reference,
) -> None:
    """Contacts, soles, balance and weights of this tick; joints follow by :func:`track_leg`.

    Swing leg: all joints. Stance leg: the knee alone, so that hip and ankle are free to balance.
    """
    stance = step.stance[0]
    swing = legs.other[stance]
    for leg in range(legs.side.shape[0]):
        reference.contact[leg] = FLAT if leg == stance else NONE
        reference.sole_frame[leg] = HIPS
        reference.cop_weight[leg] = reference.load_weight[leg] = 0.0
        for axis in range(3):
            reference.sole_position[leg, axis] = step.foot_desired[leg, 0, axis]
            reference.sole_velocity[leg, axis] = step.foot_desired[leg, 1, axis]
            reference.sole_acceleration[leg, axis] = step.foot_desired[leg, 2, axis]
            for k in range(3):
                reference.sole_rotation[leg, axis, k] = frames.sole_rotation[leg, axis, k]
    pitch, yaw = swing_pitch(step, latched), frames.yaw[0] + swing_yaw(step, latched)
    level_rotation(math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch), reference.sole_rotation[swing])
    for i in range(legs.joints.shape[1]):
        joint = legs.joints[swing, i]
        reference.joint_weight[joint] = shares.swing_ankle if joint == legs.ankle_pitch[swing] else shares.swing_joint
    reference.joint_weight[legs.knee[stance]] = shares.knee
    reference.hip_height_weight[0] = 0.0
    for axis in range(3):
        reference.com_weight[axis] = 0.0
    omega = pendulum_frequency(foothold, forecast.arm[2])
    side, time = legs.side[swing], step.time[0]
    divergent_reference(step, latched, foothold, forecast.arm[2], side, time, balance.divergent)
    stance_cop(cop, omega, forecast.arm, frames.com_velocity, balance.divergent, balance.cop)
    angle = frames.sole_yaw[stance]
    c, s = math.cos(angle), math.sin(angle)
    x, y = c * balance.cop[0] + s * balance.cop[1], c * balance.cop[1] - s * balance.cop[0]
    ahead, behind = max(legs.toe[stance] - cop.margin, 0.0), max(legs.heel[stance] - cop.margin, 0.0)
    aside = max(legs.half_width[stance] - cop.margin, 0.0)
    reference.cop[stance, 0] = min(max(x, -behind), ahead)
    reference.cop[stance, 1] = min(max(y, -aside), aside)
    reference.cop_weight[stance] = 1.0
