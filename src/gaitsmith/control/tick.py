"""The control tick: one compiled kernel from measurement to joint torques, without allocation."""

from __future__ import annotations

from gaitsmith.compiled import Vector, bind, kernel
from gaitsmith.control.joint_torque import bounded_torque
from gaitsmith.control.layout import TickGroups
from gaitsmith.control.phase import advance_phase
from gaitsmith.control.references import (
    heading_to_torso,
    set_ankle_targets,
    set_joint_targets,
    set_standing_targets,
    set_swing_targets,
    sole_target_rotation,
    swing_pitch,
)
from gaitsmith.control.state import ControlState
from gaitsmith.dynamics.algorithms import update_dynamics
from gaitsmith.dynamics.tree import TreeState
from gaitsmith.estimation.estimator import estimate
from gaitsmith.estimation.measurement import Measurement, is_usable
from gaitsmith.kinematics.inverse import leg_step
from gaitsmith.template.foothold import foothold_target, observe_motion, touchdown_velocity
from gaitsmith.template.step import LEFT, RIGHT, STAND, WALK
from gaitsmith.template.trajectory import support_height, swing_foot
from gaitsmith.whole_body.frames import Frames, observe_frames
from gaitsmith.whole_body.solve import WholeBody, solve_whole_body

_DECAY = 0.98  # per tick, of the torque that is held when no new one can be computed


@kernel
def _take_state(measurement: Measurement, control: ControlState) -> bool:
    """Copy the true state; False, and nothing copied, if no robot can be in it."""
    if not is_usable(measurement, False):
        return False
    for i in range(3):
        control.q[i] = measurement.base_position[i]
    for i in range(4):
        control.q[3 + i] = measurement.base_quaternion[i]
    for i in range(6):
        control.v[i] = measurement.base_velocity[i]
    for j in range(measurement.joint_position.shape[0]):
        control.q[7 + j] = measurement.joint_position[j]
        control.v[6 + j] = measurement.joint_velocity[j]
    return True


@kernel
def _turn_to_heading(frames: Frames, x: float, y: float, out: Vector) -> None:
    """Horizontal world vector in the heading frame."""
    out[0] = frames.heading[1] * x + frames.heading[2] * y
    out[1] = frames.heading[1] * y - frames.heading[2] * x


@kernel
def _com_acceleration(tree_state: TreeState, frames: Frames, whole_body: WholeBody, control: ControlState) -> None:
    """CoM acceleration that the last whole-body solution predicted, heading frame."""
    x, y = tree_state.com_bias[0], tree_state.com_bias[1]
    for k in range(control.v.shape[0]):
        x += tree_state.com_jacobian[0, k] * whole_body.acceleration[k]
        y += tree_state.com_jacobian[1, k] * whole_body.acceleration[k]
    _turn_to_heading(frames, x, y, control.com_acceleration)


@kernel
def _run_template(table: int) -> None:
    """Desired sole states of this tick; the foothold follows the CoM."""
    g = bind(TickGroups, table)
    tree_state = g.tree_state
    frames = g.frames
    latched = g.latched
    step = g.step
    foothold = g.foothold
    touchdown = g.touchdown
    whole_body = g.whole_body
    control = g.control
    stance = step.stance[0]
    swing = RIGHT if stance == LEFT else LEFT
    support_height(step, latched, control.support_curve)
    support = control.foot_desired[3 * stance : 3 * stance + 3]
    for axis in range(2):
        support[0, axis] = frames.relative[stance, 0, axis]
        support[1, axis] = frames.relative[stance, 1, axis]
        support[2, axis] = 0.0
    for order in range(3):
        support[order, 2] = control.support_curve[order]
    observe_motion(step, frames.com_velocity, tree_state.com)
    place = frames.sole_position[stance]
    _turn_to_heading(frames, tree_state.com[0] - place[0], tree_state.com[1] - place[1], control.arm)
    control.arm[2] = tree_state.com[2] - place[2]
    touchdown_velocity(step, latched, foothold, frames.com_velocity, control.arm, control.expected)
    _turn_to_heading(frames, tree_state.com[0] - step.station[0], tree_state.com[1] - step.station[1], control.drift)
    hip = frames.hip_position
    _turn_to_heading(frames, tree_state.com[0] - hip[0], tree_state.com[1] - hip[1], control.com_offset)
    _com_acceleration(tree_state, frames, whole_body, control)
    foothold_target(
        step,
        latched,
        foothold,
        control.expected,
        control.com_acceleration,
        control.drift,
        control.arm[2],
        control.com_offset,
        frames.relative[stance, 0, 1],
        control.foothold,
    )
    swing_foot(
        step,
        latched,
        control.foothold,
        -latched.height[0],
        touchdown.descent_speed,
        control.support_curve,
        control.foot_desired[3 * swing : 3 * swing + 3],
    )


@kernel
def _restart_leg(table: int, leg: int) -> None:
    """Restart a leg's inverse kinematics from its measured joints (section 2.2, second rule)."""
    g = bind(TickGroups, table)
    legs = g.legs
    control = g.control
    for i in range(legs.joints.shape[1]):
        joint = legs.joints[leg, i]
        control.leg_reference[leg, i] = control.q[7 + joint]
        control.leg_rate[leg, i] = control.v[6 + joint]


@kernel
def _track_leg(table: int, leg: int) -> None:
    """One inverse-kinematics step of one leg towards its desired sole."""
    g = bind(TickGroups, table)
    tree_state = g.tree_state
    legs = g.legs
    frames = g.frames
    latched = g.latched
    step = g.step
    gains = g.gains
    left_chain = g.left_chain
    right_chain = g.right_chain
    left_inverse = g.left_inverse
    right_inverse = g.right_inverse
    left_program = g.left_program
    right_program = g.right_program
    control = g.control
    desired = control.foot_desired[3 * leg : 3 * leg + 3]
    heading_to_torso(tree_state, legs, frames, desired[0], True, control.target[0])
    heading_to_torso(tree_state, legs, frames, desired[1], False, control.target[1])
    measured = leg == step.stance[0]
    pitch = swing_pitch(step, latched)
    sole_target_rotation(tree_state, legs, frames, leg, pitch, measured, control.target_rotation)
    if leg == LEFT:
        chain, scratch, program = left_chain, left_inverse, left_program
    else:
        chain, scratch, program = right_chain, right_inverse, right_program
    status = leg_step(
        chain,
        scratch,
        program,
        gains.inverse_gain,
        gains.inverse_step_weight,
        gains.inverse_change_weight,
        gains.inverse_pitch_weight,
        control.leg_reference[leg],
        control.leg_rate[leg],
        control.target[0],
        control.target[1],
        control.target_rotation,
        gains.dt,
    )
    if status != 0:
        control.counts[1] += 1
    for i in range(legs.joints.shape[1]):
        joint = legs.joints[leg, i]
        control.joint_reference[joint] = control.leg_reference[leg, i]
        control.joint_rate[joint] = control.leg_rate[leg, i]


@kernel
def _set_torque(table: int, solved: bool) -> None:
    """Eq. 27 with the stance or swing gains of each leg; without a solution the last torque decays."""
    g = bind(TickGroups, table)
    legs = g.legs
    step = g.step
    targets = g.targets
    whole_body = g.whole_body
    feedback = g.feedback
    control = g.control
    walking = step.mode[0] == WALK
    for j in range(control.torque.shape[0]):
        limit = targets.torque_limit[j]
        if solved:
            control.torque[j] = bounded_torque(whole_body.torque[j], 0.0, limit)
        else:
            control.torque[j] = bounded_torque(_DECAY * control.torque[j], 0.0, limit)
    if not (walking and solved):
        return
    for leg in range(2):
        row = 1 if leg == step.stance[0] else 0
        for i in range(legs.joints.shape[1]):
            joint = legs.joints[leg, i]
            correction = feedback.stiffness[row, i] * (
                control.joint_reference[joint] - control.q[7 + joint]
            ) + feedback.damping[row, i] * (control.joint_rate[joint] - control.v[6 + joint])
            control.torque[joint] = bounded_torque(whole_body.torque[joint], correction, targets.torque_limit[joint])


@kernel
def _report(table: int) -> None:
    """Fill the telemetry of this tick."""
    g = bind(TickGroups, table)
    frames = g.frames
    latched = g.latched
    step = g.step
    foothold = g.foothold
    whole_body = g.whole_body
    measurement = g.measurement
    control = g.control
    telemetry = g.telemetry
    out, control, step, frames = telemetry, control, step, frames
    stance = step.stance[0]
    out.time[0] = control.time[0]
    out.mode[0] = step.mode[0]
    out.stance[0] = 2.0 if step.mode[0] == STAND else float(stance)
    out.step_time[0] = step.time[0]
    out.step_count[0] = step.count[0]
    out.step_duration[0] = step.last_duration[0]
    out.command[0] = latched.speed[0]
    out.command[1] = latched.speed[1]
    out.command[2] = latched.period[0]
    out.command[3] = latched.alpha[0]
    out.command[4] = latched.height[0]
    out.command[5] = latched.lift[0]
    out.command[6] = latched.width[0]
    for i in range(3):
        out.com_velocity[i] = frames.com_velocity[i]
    for i in range(4):
        out.tilt[i] = frames.tilt[i]
    out.yaw[0] = frames.heading[0]
    out.hip_height[0] = -frames.relative[stance, 0, 2]
    for axis in range(2):
        out.foothold[axis] = control.foothold[axis]
        out.integral[axis] = step.integral[axis]
    bound = abs(control.foothold[0]) >= foothold.reach or abs(control.foothold[1]) >= foothold.spread
    out.foothold_bound[0] = 1.0 if bound and step.mode[0] == WALK else 0.0
    for j in range(control.torque.shape[0]):
        out.joint_desired[j] = control.joint_reference[j]
        out.joint_position[j] = control.q[7 + j]
        out.joint_velocity[j] = control.v[6 + j]
        out.torque_feedforward[j] = whole_body.torque[j]
        out.torque[j] = control.torque[j]
    for leg in range(2):
        for i in range(3):
            out.foot_desired[3 * leg + i] = control.foot_desired[3 * leg, i]
            out.foot_actual[3 * leg + i] = frames.relative[leg, 0, i]
        _report_wrench(table, leg)
        out.sole_force[leg] = measurement.sole_force[leg]
    out.qp_status[0] = whole_body.status[0]
    out.qp_iterations[0] = whole_body.status[1]
    out.qp_solves[0] = whole_body.counts[0]
    out.qp_fallbacks[0] = whole_body.counts[1]
    out.qp_infeasible[0] = whole_body.counts[2]
    out.ik_fallbacks[0] = control.counts[1]
    out.touchdowns_forced[0] = control.counts[2]


@kernel
def _report_wrench(table: int, leg: int) -> None:
    """Planned wrench and ZMP of one sole."""
    g = bind(TickGroups, table)
    frames = g.frames
    whole_body = g.whole_body
    telemetry = g.telemetry
    wrench = whole_body.wrench[leg]
    axes = frames.contact_rotation[leg]
    normal = moment_x = moment_y = 0.0
    for i in range(3):
        normal += axes[i, 2] * wrench[i]
        moment_x += axes[i, 0] * wrench[3 + i]
        moment_y += axes[i, 1] * wrench[3 + i]
        telemetry.wrench[6 * leg + i] = wrench[i]
        telemetry.wrench[6 * leg + 3 + i] = wrench[3 + i]
    loaded = normal > 1e-6
    telemetry.zmp[2 * leg] = -moment_y / normal if loaded else 0.0
    telemetry.zmp[2 * leg + 1] = moment_x / normal if loaded else 0.0


@kernel
def tick(table: int) -> None:
    """Advance the controller by one period; ``table`` is the address of its arena's table."""
    g = bind(TickGroups, table)
    tree = g.tree
    tree_state = g.tree_state
    legs = g.legs
    frames = g.frames
    requested = g.requested
    latched = g.latched
    step = g.step
    foothold = g.foothold
    touchdown = g.touchdown
    gains = g.gains
    motion = g.motion
    task_gains = g.task_gains
    targets = g.targets
    whole_body = g.whole_body
    program = g.program
    measurement = g.measurement
    control = g.control
    estimator_gains = g.estimator_gains
    estimator = g.estimator
    telemetry = g.telemetry
    control.time[0] += gains.dt
    if control.estimated[0] == 1:
        usable = estimate(
            tree,
            tree_state,
            legs,
            estimator_gains,
            estimator,
            measurement,
            gains.dt,
            targets.in_contact,
            control.q,
            control.v,
        )
    else:
        usable = _take_state(measurement, control)
    if not usable:
        control.counts[0] += 1
        _set_torque(table, False)
        telemetry.time[0] = control.time[0]
        for j in range(control.torque.shape[0]):
            telemetry.torque[j] = control.torque[j]
        return
    update_dynamics(tree, tree_state, control.q, control.v)
    observe_frames(tree, tree_state, legs, control.v, frames)
    at_rest = step.mode[0] == STAND
    switched = advance_phase(
        step, requested, latched, foothold, touchdown, gains, frames, tree_state.com, control, measurement
    )
    if step.mode[0] == WALK:
        stance = step.stance[0]
        swing = RIGHT if stance == LEFT else LEFT
        if switched:
            _restart_leg(table, swing)
            if at_rest:
                _restart_leg(table, stance)
        _run_template(table)
        _track_leg(table, LEFT)
        _track_leg(table, RIGHT)
        set_swing_targets(step, gains, frames, control, targets)
        targets.in_contact[stance] = 1
        targets.in_contact[swing] = 0
    else:
        for leg in range(2):
            targets.in_contact[leg] = 1
            _restart_leg(table, leg)
        set_standing_targets(tree_state, gains, frames, control, targets)
    set_joint_targets(legs, step, gains, control, targets)
    set_ankle_targets(step, latched, legs, gains, frames, targets)
    solved = solve_whole_body(program, tree_state, legs, targets, frames, task_gains, motion, whole_body)
    _set_torque(table, solved)
    _report(table)
