"""What a controller keeps: all arrays that a tick reads and writes, made for one robot."""

from __future__ import annotations

from typing import Any

import numpy as np

from gaitsmith.control.defaults import Scale
from gaitsmith.control.gains import make_following_tasks, make_gains
from gaitsmith.control.joint_torque import make_joint_feedback
from gaitsmith.control.state import Tick, make_control_state
from gaitsmith.control.telemetry import Telemetry
from gaitsmith.dynamics.tree import read_tree
from gaitsmith.estimation.estimator import Estimation, make_estimator_gains, make_estimator_state
from gaitsmith.estimation.measurement import make_measurement
from gaitsmith.estimation.motors import make_motors
from gaitsmith.estimation.readings import Checking, make_readings
from gaitsmith.kinematics.inverse import make_inverse_kinematics, make_leg_kinematics, make_leg_table
from gaitsmith.planned.law import make_following
from gaitsmith.planned.replay import ReplayGains, ReplayParameters
from gaitsmith.qp.quadratic_program import make_quadratic_program
from gaitsmith.robots import Robot
from gaitsmith.robots.parameters import GaitParameters
from gaitsmith.robots.presets import ControlParameters
from gaitsmith.template.foothold import Forecast, make_foothold_gains, make_speed_gains
from gaitsmith.template.ground import make_ground
from gaitsmith.template.posture import make_posture
from gaitsmith.template.state import Template, make_balance
from gaitsmith.template.step import make_gait_inputs, make_step_state
from gaitsmith.template.touchdown import make_touchdown_rule
from gaitsmith.whole_body.frames import make_body
from gaitsmith.whole_body.legs import make_legs
from gaitsmith.whole_body.problem import make_whole_body
from gaitsmith.whole_body.reference import make_reference

CONTROL_PERIOD = 1e-3
_POSTURE = 3.0  # ω, of the approach to a commanded posture
_YAW = 2  # of a sole's three turning axes


def make_storage(
    robot: Robot,
    scale: Scale,
    parameters: ControlParameters,
    gait: GaitParameters,
    estimated: bool,
    telemetry: Telemetry,
) -> Tick:
    """All that a tick reads and writes, before an arena owns it."""
    n_joints, n_soles = len(robot.joint_names), len(robot.legs)
    chains = [make_leg_kinematics(robot, leg) for leg in robot.legs]
    n_leg = len(robot.legs[0].joints)
    turns = all(chain.turning[_YAW] for chain in chains)
    inputs, gains = make_gait_inputs(gait), make_gains(parameters, CONTROL_PERIOD)
    body, reference = make_body(read_tree(robot.model), make_legs(robot)), make_reference(n_soles, n_joints)
    whole_body = make_whole_body(body, reference, gains.pop("contact_bounds"), gains.pop("joint_bounds"))
    measurement = make_measurement(n_joints, n_soles)
    control = make_control_state(n_joints, estimated, turns, len(inputs.values))
    dt = CONTROL_PERIOD
    readings, expected = make_readings(measurement, estimated, scale.weight, scale.rate, scale.height, dt)
    sensors = make_estimator_state(n_joints, n_soles)
    filters = make_estimator_gains(
        parameters.estimator, robot.imu_position, parameters.touchdown.force, scale.weight, robot.imu_rotation
    )
    template = Template(
        body=body,
        reference=reference,
        sole_force=measurement.sole_force,
        acceleration=whole_body.solution.acceleration,
        turns=control.turns,
        requested=inputs,
        latched=make_gait_inputs(gait),
        step=make_step_state(n_soles, n_leg),
        ground=make_ground(),
        posture=make_posture(body.legs.home, robot.velocity_limit, _POSTURE * scale.rate),
        foothold=make_foothold_gains(parameters.foothold, scale.gravity, scale.height, robot.card.gait_limits.height),
        speed=make_speed_gains(parameters.speed),
        forecast=Forecast(np.zeros(3), *(np.zeros(2) for _ in range(4))),
        balance=make_balance(),
        touchdown=make_touchdown_rule(parameters.touchdown),
        chains=make_leg_table(chains),
        inverse=make_inverse_kinematics(n_leg),
        inverse_program=make_quadratic_program(n_leg, 0),
        **{name: gains.pop(name) for name in ("times", "printed", "cop", "shares", "rest", "inverse_gains")},
    )
    return Tick(
        body=body,
        reference=reference,
        template=template,
        whole_body=whole_body,
        following=make_following(robot),
        following_tasks=make_following_tasks(scale, parameters),
        replay=_replay_gains(scale, ReplayParameters()),
        feedback=make_joint_feedback(parameters.joint_gains_estimated if estimated else parameters.joint_gains, n_leg),
        measurement=measurement,
        checking=Checking(
            body, measurement, expected, readings, reference, whole_body.solution.acceleration, filters, sensors
        ),
        motors=make_motors(n_joints, n_soles, scale.rate, dt),
        control=control,
        estimation=Estimation(body, measurement, filters, sensors),
        telemetry=telemetry,
        **gains,
    )


def _replay_gains(scale: Scale, given: ReplayParameters) -> ReplayGains:
    """Gains of a replay in SI units."""
    return ReplayGains(given.stiffness * scale.torque, given.damping * scale.torque / scale.rate, given.attitude)


def memory_of(g: Tick) -> list[Any]:
    """Groups of arrays that a reset puts back to what they were at first."""
    template, problem = g.template, g.whole_body
    return [
        *(
            template.step,
            template.ground,
            template.posture,
            template.chains,
            template.inverse_program,
            g.control,
            g.checking.readings,
            g.checking.expected,
            g.motors,
            g.estimation.state,
            g.reference,
        ),
        *((g.body.q, g.body.v), problem.contacts, problem.solution, problem.program),
    ]
