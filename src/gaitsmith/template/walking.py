"""The template as a producer of references: soles, joints, balance and torso of a walk (Han 2023, eqs. 20-23)."""

from __future__ import annotations

import math

from gaitsmith.compiled import Matrix, Vector, kernel
from gaitsmith.kinematics.inverse import leg_row, leg_step
from gaitsmith.template.balance import divergent_reference, stance_cop
from gaitsmith.template.foothold import (
    choose_speed,
    foothold_target,
    forecast_touchdown,
    landing_height,
    observe_motion,
    pendulum_frequency,
)
from gaitsmith.template.ground import feel_slope, find_pivot, plan_landing, share_of_way
from gaitsmith.template.phase import com_over_sole, within_turn
from gaitsmith.template.state import Template
from gaitsmith.template.step import WALK
from gaitsmith.template.step_time import adapt_duration
from gaitsmith.template.trajectory import follow_foothold, support_foot, swing_foot, swing_pitch, swing_yaw
from gaitsmith.whole_body.frames import Frames, to_heading, to_world
from gaitsmith.whole_body.reference import FLAT, HIPS, NONE, WORLD, level_rotation


@kernel
def plan_step(g: Template, dt: float) -> None:
    """Desired sole states of this tick; the foothold follows the CoM."""
    step, latched, forecast, curve, ground = g.step, g.latched, g.forecast, g.balance.curve, g.ground
    frames, state = g.body.frames, g.body.state
    stance = step.stance[0]
    swing = g.body.legs.other[stance]
    side, com = g.body.legs.side[swing], state.com
    support = step.foot_desired[stance]
    for axis in range(2):
        support[0, axis] = frames.relative_position[stance, axis]
        support[1, axis] = frames.relative_velocity[stance, axis]
        support[2, axis] = 0.0
    observe_motion(step, frames.com_velocity, com)
    legs, pitch = g.body.legs, frames.sole_pitch[stance]
    find_pivot(ground, step, pitch, legs.heel[stance], legs.toe[stance], legs.half_width[stance], g.cop.margin)
    omega = com_over_sole(g, stance)
    feel_slope(ground, step, pitch)
    to_heading(frames, com[0] - step.station[0], com[1] - step.station[1], forecast.drift)
    x, y, jacobian = state.com_bias[0], state.com_bias[1], state.com_jacobian
    for k in range(g.acceleration.shape[0]):
        x += jacobian[0, k] * g.acceleration[k]
        y += jacobian[1, k] * g.acceleration[k]
    to_heading(frames, x, y, forecast.acceleration)
    choose_speed(step, latched, g.speed, forecast)
    for axis in range(2):
        g.balance.foot[axis] = frames.relative_position[swing, axis] - frames.com_offset[axis]
    adapt_duration(g, side, dt)
    forecast_touchdown(step, latched, g.foothold, frames.com_velocity, side, forecast)
    stance_y = frames.relative_position[stance, 1]
    beside = foothold_target(step, latched, g.foothold, forecast, frames.com_offset, stance_y, side, step.foothold)
    plan_landing(ground, step, forecast, omega, frames.com_velocity, frames.com_offset, step.foothold)
    rise, highest = ground.rise[0], ground.highest[0]
    height = landing_height(latched, g.foothold, step.foothold, side, max(-rise, 0.0))
    support_foot(step, latched, g.printed, height, -side, curve, support)
    target, descent = step.foot_desired[swing], g.touchdown.descent_speed
    share = share_of_way(ground.start[0], rise, highest, latched.lift[0])
    swing_foot(
        step, latched, step.foothold, rise - height, highest - height, share, g.printed, side, descent, curve, target
    )
    if beside:
        follow_foothold(step, latched, share, frames.relative_velocity[stance, 1], curve, target)


@kernel
def restart_leg(g: Template, leg: int) -> None:
    """Restart a leg's inverse kinematics from its measured joints (section 2.2, second rule)."""
    joints = g.body.legs.joints
    for i in range(joints.shape[1]):
        g.step.leg_reference[leg, i] = g.body.q[7 + joints[leg, i]]
        g.step.leg_rate[leg, i] = g.body.v[6 + joints[leg, i]]


@kernel
def _to_torso(torso: Matrix, frames: Frames, vector: Vector, out: Vector) -> None:
    """A heading-frame vector in the torso frame."""
    c, s = frames.cos_yaw[0], frames.sin_yaw[0]
    x, y, z = c * vector[0] - s * vector[1], s * vector[0] + c * vector[1], vector[2]
    for i in range(3):
        out[i] = torso[0, i] * x + torso[1, i] * y + torso[2, i] * z


@kernel
def track_leg(g: Template, leg: int, dt: float) -> None:
    """One inverse-kinematics step of one leg towards its desired sole; its joints become references."""
    step, legs, balance, reference = g.step, g.body.legs, g.balance, g.reference
    torso, position, wanted = g.body.state.body_rotation[legs.torso[0]], balance.position, reference.sole_rotation[leg]
    angle, rate = step.leg_reference[leg], step.leg_rate[leg]
    if g.printed.joint_reference == 1.0:
        for i in range(legs.joints.shape[1]):
            angle[i] = g.body.q[7 + legs.joints[leg, i]]
    _to_torso(torso, g.body.frames, step.foot_desired[leg, 0], position)
    _to_torso(torso, g.body.frames, step.foot_desired[leg, 1], balance.velocity)
    for i in range(3):
        position[i] += legs.hip_midpoint[i]
        for j in range(3):
            balance.rotation[i, j] = (
                torso[0, i] * wanted[0, j] + torso[1, i] * wanted[1, j] + torso[2, i] * wanted[2, j]
            )
    status = leg_step(
        leg_row(g.chains, leg),
        g.inverse,
        g.inverse_program,
        g.chains.active[leg],
        g.inverse_gains,
        angle,
        rate,
        position,
        balance.velocity,
        balance.rotation,
        dt,
    )
    if status != 0:
        step.inverse_fallbacks[0] += 1
    for i in range(legs.joints.shape[1]):
        joint = legs.joints[leg, i]
        reference.joint[0, joint], reference.joint[1, joint] = angle[i], rate[i]


@kernel
def set_torso(g: Template) -> None:
    """Torso upright, its heading held or turned where legs can turn."""
    reference, yaw = g.reference, g.body.frames.yaw[0]
    if g.turns[0] == 1:
        yaw += min(max(within_turn(g.step.heading[0] - yaw), -0.5), 0.5)
    level_rotation(math.cos(yaw), math.sin(yaw), 1.0, 0.0, reference.torso_rotation)
    reference.torso_weight[0] = reference.torso_weight[1] = 1.0
    reference.torso_weight[2] = float(g.turns[0])
    for axis in range(3):
        reference.torso_spin[axis] = 0.0
        reference.torso_angular_acceleration[axis] = 0.0
    if g.step.mode[0] == WALK:
        reference.torso_spin[2] = g.latched.yaw_rate[0]


@kernel
def _refer_sole(g: Template, leg: int) -> None:
    """A sole's reference: relative to the hips, or with eq. 19 as printed the same place and velocity in the world."""
    reference, frames, desired = g.reference, g.body.frames, g.step.foot_desired[leg]
    position, velocity, acceleration = (
        reference.sole_position[leg],
        reference.sole_velocity[leg],
        reference.sole_acceleration[leg],
    )
    reference.sole_frame[leg] = HIPS
    own = 1.0 - g.printed.swing_feedback
    for axis in range(3):
        position[axis], velocity[axis] = desired[0, axis], desired[1, axis]
        acceleration[axis] = own * desired[2, axis]
    if g.printed.swing_frame == 1.0:
        reference.sole_frame[leg] = WORLD
        to_world(frames, position[0], position[1], position)
        to_world(frames, velocity[0], velocity[1], velocity)
        to_world(frames, acceleration[0], acceleration[1], acceleration)
        for axis in range(3):
            position[axis] += frames.hip_position[axis]
            velocity[axis] += frames.hip_velocity[axis]


@kernel
def refer_walking(g: Template) -> None:
    """Contacts, soles, balance and weights of this tick; joints follow by :func:`track_leg`.

    Swing leg: all joints. Stance leg: the knee alone, so that hip and ankle are free to balance.
    """
    step, latched, legs, frames = g.step, g.latched, g.body.legs, g.body.frames
    reference, cop = g.reference, g.balance.cop
    stance = step.stance[0]
    swing = legs.other[stance]
    for leg in range(legs.side.shape[0]):
        reference.contact[leg] = FLAT if leg == stance else NONE
        reference.cop_weight[leg] = reference.load_weight[leg] = 0.0
        _refer_sole(g, leg)
        for axis in range(3):
            for k in range(3):
                reference.sole_rotation[leg, axis, k] = frames.sole_rotation[leg, axis, k]
    pitch, yaw = swing_pitch(step, latched, g.ground.pitch[0]), frames.yaw[0] + swing_yaw(step, latched)
    level_rotation(math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch), reference.sole_rotation[swing])
    for i in range(legs.joints.shape[1]):
        joint = legs.joints[swing, i]
        ankle = joint == legs.ankle_pitch[swing]
        reference.joint_weight[joint] = g.shares.swing_ankle if ankle else g.shares.swing_joint
    reference.joint_weight[legs.knee[stance]] = g.shares.knee
    reference.hip_height_weight[0] = 0.0
    for axis in range(3):
        reference.com_weight[axis] = 0.0
    arm, divergent, side = g.forecast.arm, g.balance.divergent, legs.side[swing]
    divergent_reference(step, latched, g.foothold, arm[2], side, step.time[0], divergent)
    stance_cop(g.cop, pendulum_frequency(g.foothold, arm[2]), arm, frames.com_velocity, divergent, cop)
    for axis in range(2):
        cop[axis] += g.ground.pivot[axis]
    c, s = math.cos(frames.sole_yaw[stance]), math.sin(frames.sole_yaw[stance])
    x, y = c * cop[0] + s * cop[1], c * cop[1] - s * cop[0]
    for k in range(legs.edges[stance]):
        edge = legs.edge[stance, k]
        past = max(edge[0] * x + edge[1] * y - max(edge[2] - g.cop.margin, 0.0), 0.0)
        x, y = x - past * edge[0], y - past * edge[1]
    reference.cop[stance, 0], reference.cop[stance, 1] = x, y if legs.half_width[stance] > 0.0 else 0.0
    reference.cop_weight[stance] = 1.0
