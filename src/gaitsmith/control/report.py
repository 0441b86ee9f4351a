"""Telemetry of one tick."""

from __future__ import annotations

from gaitsmith.compiled import kernel
from gaitsmith.control.state import FOLLOWING, Tick
from gaitsmith.estimation.measurement import JOINT_POSITION, JOINT_VELOCITY, SOLE_FORCE
from gaitsmith.template.step import WALK
from gaitsmith.whole_body.reference import FLAT, NONE


@kernel
def _report_sole(g: Tick, leg: int) -> None:
    """Desired and actual place, planned wrench and ZMP, and measured force of one sole."""
    out, frames, contacts = g.telemetry, g.body.frames, g.whole_body.contacts
    wrench, axes, desired = g.whole_body.solution.wrench[leg], contacts.axes[leg], g.template.step.foot_desired[leg]
    if g.control.state[0] == FOLLOWING:
        cos, sin, hip = frames.cos_yaw[0], frames.sin_yaw[0], frames.hip_position
        wanted = g.reference.sole_position[leg]
        x, y = wanted[0] - hip[0], wanted[1] - hip[1]
        desired[0, 0], desired[0, 1], desired[0, 2] = cos * x + sin * y, cos * y - sin * x, wanted[2] - hip[2]
    for i in range(3):
        out.foot_desired[3 * leg + i] = desired[0, i]
        out.foot_actual[3 * leg + i] = frames.relative_position[leg, i]
    normal = moment_x = moment_y = 0.0
    for i in range(3):
        normal += axes[i, 2] * wrench[i]
        moment_x += axes[i, 0] * wrench[3 + i]
        moment_y += axes[i, 1] * wrench[3 + i]
        out.wrench[6 * leg + i] = wrench[i]
        out.wrench[6 * leg + 3 + i] = wrench[3 + i]
    loaded = contacts.kind[leg] != NONE and normal > 1e-6
    out.zmp[2 * leg] = -moment_y / normal if loaded else 0.0
    out.zmp[2 * leg + 1] = moment_x / normal if loaded else 0.0
    out.sole_force[leg] = g.measurement.sole_force[leg]


@kernel
def _report_step(g: Tick) -> None:
    """Gait and step."""
    out, step, foothold = g.telemetry, g.template.step, g.template.foothold
    following = g.control.state[0] == FOLLOWING
    walking = step.mode[0] == WALK or following
    bearing, stance = 0, 0
    for leg in range(g.reference.contact.shape[0]):
        if g.reference.contact[leg] != NONE:
            bearing += 1
        if g.reference.contact[leg] == FLAT:
            stance = leg
    out.mode[0] = 1.0 if walking else 0.0
    plan, clock = g.following.plan, g.following.clock
    out.plan_phase[0] = float(plan.phase[plan.sequence[clock.visit[0]]]) if following else -1.0
    out.plan_lead[0] = clock.lead[0] if following else 0.0
    out.stance[0] = float(stance) if bearing == 1 else float(g.reference.contact.shape[0])
    out.step_time[0] = step.time[0]
    out.step_count[0] = step.count[0]
    out.step_duration[0] = step.last_duration[0]
    for k in range(out.command.shape[0]):
        out.command[k] = g.template.latched.values[k]
    for axis in range(2):
        out.foothold[axis] = step.foothold[axis] if not following else g.following.state.goal[axis]
        out.integral[axis] = step.integral[axis]
    bound = (not following and abs(step.foothold[0]) >= foothold.reach) or abs(step.foothold[1]) >= foothold.spread
    out.foothold_bound[0] = 1.0 if bound and walking else 0.0
    out.heading[0] = step.heading[0]
    out.hip_height[0] = -g.body.frames.relative_position[step.stance[0], 2]
    out.ik_fallbacks[0] = step.inverse_fallbacks[0]
    out.touchdowns_forced[0] = step.forced[0]


@kernel
def _report_readings(g: Tick) -> None:
    """What was wrong with the readings; counts by sensor."""
    out, control, readings = g.telemetry, g.control, g.checking.readings
    nj, any_lost = readings.rate.shape[0], 0
    for sensor in range(control.refused.shape[0]):
        begin = sensor if sensor <= JOINT_POSITION else sensor - 2 + (nj if sensor == JOINT_VELOCITY else 2 * nj)
        begin = begin + 1 if sensor == JOINT_VELOCITY else begin
        end = begin + (nj if JOINT_POSITION <= sensor <= JOINT_VELOCITY else 1)
        end = readings.what.shape[0] if sensor == SOLE_FORCE else end
        lost = 0
        for c in range(begin, end):
            out.reading[c] = readings.what[c]
            lost = 1 if readings.lost[c] > 0 else lost
        control.refused[sensor] += lost
        any_lost = max(any_lost, lost)
        out.refused[sensor] = control.refused[sensor]
    control.refused_ticks[0] += any_lost
    out.refused_ticks[0], out.missed_ticks[0] = control.refused_ticks[0], control.missed[0]
    for j in range(nj):
        out.motor[j] = g.motors.what[j]
    out.reading_changes[0], out.reading_lost[0] = readings.changes[0], readings.culprit[0]


@kernel
def report(g: Tick) -> None:
    """Fill the telemetry of this tick."""
    out, frames, control, body, found = g.telemetry, g.body.frames, g.control, g.body, g.whole_body.solution
    out.time[0] = control.time[0]
    out.control_state[0] = control.state[0]
    _report_step(g)
    for i in range(3):
        out.com_velocity[i] = frames.com_velocity[i]
    for i in range(2):
        out.tilt[i] = frames.tilt[i]
        out.tilt[2 + i] = frames.tilt_rate[i]
    out.yaw[0], out.yaw_rate[0] = frames.yaw[0], frames.yaw_rate[0]
    for j in range(control.torque.shape[0]):
        out.joint_desired[j] = g.reference.joint[0, j]
        out.joint_position[j] = body.q[7 + j]
        out.joint_velocity[j] = body.v[6 + j]
        out.torque_feedforward[j] = found.torque[j]
        out.torque[j] = control.torque[j]
    for leg in range(g.reference.contact.shape[0]):
        _report_sole(g, leg)
    out.qp_status[0], out.qp_iterations[0] = found.status[0], found.iterations[0]
    out.qp_solves[0], out.qp_fallbacks[0] = found.solves[0], found.fallbacks[0]
    out.qp_infeasible[0], out.stops_dropped[0] = found.infeasible[0], found.stops_dropped[0]
    _report_readings(g)
