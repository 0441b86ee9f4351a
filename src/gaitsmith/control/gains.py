"""A preset's numbers as the kernels read them, card to kernel by name."""

from __future__ import annotations

from typing import Any

from gaitsmith.control.defaults import Scale
from gaitsmith.control.state import TickGains
from gaitsmith.kinematics.inverse import InverseGains
from gaitsmith.robots.presets import ControlParameters
from gaitsmith.template.balance import CopGains
from gaitsmith.template.state import JointShares, RestGains, StepTimeGains
from gaitsmith.template.trajectory import Printed
from gaitsmith.whole_body.contact import ContactBounds
from gaitsmith.whole_body.problem import JointBounds
from gaitsmith.whole_body.tasks import Task, TaskTable

_BRAKE = 0.05  # of the torque limit per rad/s
_HOLD = 0.5  # rad
_DIVERGENT = 3.0
_SOLE, _TORSO, _HEIGHT = (18.0, 8.5), (5.5, 4.8), (3.65, 3.8)  # ω², ω: when following a plan


def make_task_table(parameters: ControlParameters) -> TaskTable:
    """Tasks of standing and of the template's walk."""
    weights, tracking, attitude = parameters.weights, parameters.tracking, parameters.attitude
    standing, others = parameters.standing, parameters.other_joints
    balance = Task(standing.weight, standing.com_stiffness, standing.com_damping)
    return TaskTable(
        stance=Task(weights.stance_linear, 0.0, 0.0),
        stance_turn=Task(weights.stance_angular, 0.0, 0.0),
        swing=Task(weights.swing_foot, tracking.foot_stiffness, tracking.foot_damping),
        swing_turn=Task(0.0, 0.0, 0.0),
        roll=Task(weights.attitude, attitude.roll_stiffness, attitude.roll_damping),
        pitch=Task(weights.attitude, attitude.pitch_stiffness, attitude.pitch_damping),
        yaw=Task(weights.yaw, attitude.yaw_stiffness, attitude.yaw_damping),
        com=balance,
        com_height=balance,
        hip_height=balance,
        leg_joint=Task(1.0, tracking.joint_stiffness, tracking.joint_damping),
        posture=Task(weights.other_joint, others.stiffness, others.damping),
        cop=parameters.cop.weight,
        load=0.0,
        torque_change=weights.torque_change,
        regularisation=weights.regularisation,
    )


def make_following_tasks(scale: Scale, parameters: ControlParameters) -> TaskTable:
    """Tasks of following a plan: its CoM, torso and soles, its posture where these leave room, its shares of load.

    The CoM's spring and damper are those of a pendulum whose CoP answers :data:`_DIVERGENT` times the error of its
    divergent component.
    """
    rate, angular = scale.rate, (scale.height / 0.6) ** 2
    sole, torso = _task(rate, 5.0, _SOLE), _task(rate, 8.0 * angular, _TORSO)
    com = _task(rate, 10.0, (_DIVERGENT - 1.0, _DIVERGENT))
    tasks = make_task_table(parameters)
    return tasks._replace(
        stance=_task(rate, 100.0, _SOLE),
        stance_turn=_task(rate, 280.0 * angular, _SOLE),
        swing=sole,
        swing_turn=_task(rate, 4.0 * angular, _SOLE),
        roll=torso,
        pitch=torso,
        yaw=torso,
        com=com,
        com_height=_task(rate, 10.0, _HEIGHT),
        leg_joint=_task(rate, 0.03 * angular, _HEIGHT),
        posture=tasks.posture._replace(weight=angular),
        load=31.0 / scale.weight**2,
    )


def _task(rate: float, weight: float, gains: tuple[float, float]) -> Task:
    """A task with stiffness and damping in units of ω² and ω."""
    return Task(weight, gains[0] * rate**2, gains[1] * rate)


def make_gains(parameters: ControlParameters, dt: float) -> dict[str, Any]:
    """Groups of the tick's view that are constants of a preset."""
    weights, contact, joints = parameters.weights, parameters.contact, parameters.joints
    standing, inverse, cop = parameters.standing, parameters.inverse_kinematics, parameters.cop
    return {
        "gains": TickGains(dt=dt, brake=_BRAKE, hold=_HOLD, contact_force=parameters.touchdown.force),
        "tasks": make_task_table(parameters),
        "cop": CopGains(gain_x=cop.gain[0], gain_y=cop.gain[1], margin=contact.zmp_margin),
        "shares": JointShares(knee=weights.knee, swing_joint=weights.swing_joint, swing_ankle=weights.swing_ankle),
        "printed": Printed(**{name: float(taken) for name, taken in parameters.printed.model_dump().items()}),
        "times": StepTimeGains(**parameters.step_time.model_dump()),
        "rest": RestGains(
            weight_shift=float(standing.weight_shift),
            longest_shift=standing.longest_shift,
            entry_speed=standing.entry_speed,
            straddle=standing.straddle,
            height_rate=standing.height_rate,
        ),
        "contact_bounds": ContactBounds(
            friction=contact.friction,
            normal_low=contact.normal_force[0],
            normal_high=contact.normal_force[1],
            zmp_margin=contact.zmp_margin,
            yaw_friction=contact.yaw_friction,
        ),
        "joint_bounds": JointBounds(torque_step=joints.torque_rate * dt, stop_rate=joints.stop_rate),
        "inverse_gains": InverseGains(**inverse.model_dump()),
    }
