"""The control tick: one compiled kernel from measurement to joint torques, without allocation."""

from __future__ import annotations

from gaitsmith.compiled import bind, kernel
from gaitsmith.control.joint_torque import add_joint_feedback, bounded_torque, braked_torque, held_torque
from gaitsmith.control.report import report
from gaitsmith.control.state import AIRBORNE, DAMPING, FAULT, FOLLOWING, OFF, STANDING, WALKING, Tick
from gaitsmith.dynamics.algorithms import update_dynamics
from gaitsmith.estimation.checks import check_readings
from gaitsmith.estimation.estimator import estimate
from gaitsmith.estimation.motors import watch_motors
from gaitsmith.planned.clock import FORCED, ON_TIME
from gaitsmith.planned.follow import follow
from gaitsmith.planned.replay import replay_torque
from gaitsmith.template.phase import advance_phase, turn_heading
from gaitsmith.template.posture import hold_posture
from gaitsmith.template.standing import refer_standing
from gaitsmith.template.step import STAND, WALK
from gaitsmith.template.walking import plan_step, refer_walking, restart_leg, set_torso, track_leg
from gaitsmith.whole_body.frames import observe_frames
from gaitsmith.whole_body.solve import solve_whole_body

_COM_FOR_HIPS = 1.5  # share of its height by which hips sink for that by which the CoM does
_LIFTED = 0.25  # of a step's period without load after which a robot that stood hangs in the air


@kernel
def _open_mailbox(g: Tick) -> None:
    """Take over the gait inputs and the posture that were commanded, all at once or not yet."""
    control, requested, posture = g.control, g.template.requested.values, g.template.posture
    letters = control.letters[0]
    if letters % 2 == 1 or letters == control.read[0]:
        return
    for k in range(requested.shape[0]):
        requested[k] = control.mailbox[k]
    for i in range(2):
        for j in range(posture.goal.shape[1]):
            posture.goal[i, j] = posture.mailbox[i, j]
    if control.letters[0] == letters:
        control.read[0] = letters


@kernel
def _sunk(g: Tick) -> float:
    """Share of the commanded height by which the hips are too low; of a plan, from that of the CoM."""
    state, place, hips = g.control.state[0], g.body.frames.relative_position, 0.0
    if state == FOLLOWING:
        return float(_COM_FOR_HIPS * (g.reference.com[0, 2] - g.body.state.com[2]) / g.checking.readings.height_unit[0])
    if state != WALKING and state != STANDING:
        return 0.0
    for leg in range(place.shape[0]):
        hips = max(hips, -place[leg, 2])
    return float(1.0 - hips / g.template.latched.height[0])


@kernel
def _check_readings(g: Tick) -> None:
    """Replace what cannot be believed; brake for good if the robot cannot do without it, or if it was left alone."""
    control, step, readings, touchdown = g.control, g.template.step, g.checking.readings, g.template.touchdown
    state, late = control.state[0], readings.late[0]
    swing = g.body.legs.other[step.stance[0]] if state == WALKING else -1
    driven = (state in (WALKING, STANDING, FOLLOWING)) and g.whole_body.solution.fresh[0] == 0
    lost = check_readings(
        g.checking,
        g.gains.dt,
        control.estimated[0] == 1,
        driven,
        swing,
        step.time[0] + late * g.gains.dt,
        step.period[0],
        touchdown.earliest * step.period[0],
        touchdown.force,
        _sunk(g),
        g.motors.what,
    )
    if late > 0:
        control.missed[0] += late
        control.time[0] += late * g.gains.dt
    if lost >= 0:
        control.asked[0] = FAULT


@kernel
def _take_state(g: Tick, elapsed: float) -> None:
    """State of this tick, copied or estimated."""
    q, v, measurement = g.body.q, g.body.v, g.measurement
    if g.control.estimated[0] == 1:
        estimate(g.estimation, elapsed, g.whole_body.contacts.kind)
        return
    for i in range(3):
        q[i] = measurement.base_position[i]
    for i in range(4):
        q[3 + i] = measurement.base_quaternion[i]
    for i in range(6):
        v[i] = measurement.base_velocity[i]
    for j in range(measurement.joint_position.shape[0]):
        q[7 + j] = measurement.joint_position[j]
        v[6 + j] = measurement.joint_velocity[j]


@kernel
def _watch_motors(g: Tick) -> None:
    """Name motors that give less than they were told, by the velocity that the last tick's torques led to."""
    control, readings = g.control, g.checking.readings
    state = control.state[0]
    solved = state in (WALKING, STANDING) or (state == FOLLOWING and control.replays[0] == 0)
    driven = solved and g.whole_body.solution.fresh[0] == 0 and readings.late[0] == 0
    readings.changes[0] += watch_motors(g.motors, g.body, g.whole_body, control.torque, driven, g.gains.dt)


@kernel
def _choose_state(g: Tick, elapsed: float) -> None:
    """Control state of this tick: what was asked for, unless the robot hangs in the air."""
    control, step, solution, period = g.control, g.template.step, g.whole_body.solution, g.template.latched.period[0]
    loaded = False
    for leg in range(g.measurement.sole_force.shape[0]):
        loaded = loaded or g.measurement.sole_force[leg] > g.gains.contact_force
    control.unloaded[0] = 0.0 if loaded else control.unloaded[0] + elapsed
    stands = control.state[0] == STANDING or control.state[0] == FOLLOWING
    if control.sent[0] == 0 or (loaded and stands):
        for j in range(control.held.shape[0]):
            control.held[j] = g.body.q[7 + j]
    if control.asked[0] == FOLLOWING:
        lifted = control.unloaded[0] > period
        if control.state[0] == AIRBORNE and not lifted:
            solution.fresh[0] = 1
        control.state[0] = AIRBORNE if lifted else FOLLOWING
    elif control.asked[0] != STANDING:
        control.state[0] = control.asked[0]
        step.mode[0] = STAND
    elif control.unloaded[0] > period * (1.0 if step.mode[0] == WALK else _LIFTED):
        control.state[0] = AIRBORNE
        step.mode[0] = STAND
    else:
        if control.state[0] in (AIRBORNE, OFF, DAMPING, FAULT, FOLLOWING):
            solution.fresh[0] = 1
            step.heading_set[0] = 0
        control.state[0] = STANDING


@kernel
def _refer(g: Tick, dt: float) -> None:
    """The template, on both feet or walking, writes the reference."""
    template, legs = g.template, g.body.legs
    step = template.step
    # No walk begins before a first solution: from it on the torques change no faster than they may.
    switched = g.whole_body.solution.fresh[0] == 0 and advance_phase(template, dt)
    turn_heading(template, dt)
    set_torso(template)
    hold_posture(template.posture, legs, template.reference, dt)
    if step.mode[0] != WALK:
        for leg in range(legs.side.shape[0]):
            restart_leg(template, leg)
        refer_standing(template)
        return
    g.control.state[0] = WALKING
    if switched:
        restart_leg(template, legs.other[step.stance[0]])
    plan_step(template, dt)
    refer_walking(template)
    for leg in range(legs.side.shape[0]):
        track_leg(template, leg, dt)


@kernel
def _follow(g: Tick, dt: float) -> bool:
    """The plan writes the reference, and the whole body follows it; True if its QP was solved."""
    following, state, frames, step, reference = g.following, g.body.state, g.body.frames, g.template.step, g.reference
    event = follow(
        following,
        frames.sole_position,
        frames.sole_rotation,
        state.com,
        state.com_velocity,
        g.measurement.sole_force,
        reference,
        dt,
    )
    if event != ON_TIME:
        step.last_duration[0] = step.time[0]
        step.forced[0] = following.clock.touchdowns[FORCED]
    step.time[0], step.count[0] = following.clock.since_touchdown[0], following.clock.steps[0]
    step.heading[0], step.stance[0] = following.state.heading[0], following.state.support[0]
    if g.control.replays[0] == 1:
        replay_torque(g.replay, g.body, reference, g.whole_body.solution.torque)
        return False
    return solve_whole_body(g.whole_body, g.following_tasks)


@kernel
def _send(g: Tick, solved: bool) -> None:
    """Torque of this tick into ``control.torque``: inside its limit, no faster than its rate, never NaN."""
    control, body, gains, found = g.control, g.body, g.gains, g.whole_body.solution.torque
    torque, state = control.torque, control.state[0]
    step = g.whole_body.joint_bounds.torque_step * g.whole_body.solution.elapsed[0]
    free = state != WALKING and state != STANDING and state != FOLLOWING
    for j in range(torque.shape[0]):
        limit, speed = body.legs.torque_limit[j], body.v[6 + j]
        wanted = found[j]
        if state == OFF:
            wanted = 0.0
        elif state in (DAMPING, FAULT):
            wanted = braked_torque(limit, speed, gains.brake)
        elif state == AIRBORNE:
            wanted = held_torque(limit, control.held[j] - body.q[7 + j], speed, gains.hold, gains.brake)
        control.wanted[j] = wanted
    if solved and state == WALKING:
        add_joint_feedback(g.feedback, body, g.reference, control.wanted)
    for j in range(torque.shape[0]):
        wanted = bounded_torque(control.wanted[j], 0.0, body.legs.torque_limit[j])
        if control.sent[0] == 1:
            wanted = min(max(wanted, torque[j] - step), torque[j] + step)
        torque[j] = wanted
        if free:
            found[j] = wanted
    control.sent[0] = 1


@kernel
def tick(table: int) -> None:
    """Advance the controller by one period; ``table`` is the address of its arena's table."""
    g = bind(Tick, table)
    control, body = g.control, g.body
    control.time[0] += g.gains.dt
    _open_mailbox(g)
    solved = False
    elapsed = g.gains.dt * (1 + g.checking.readings.late[0])
    g.whole_body.solution.elapsed[0] = 1 + g.checking.readings.late[0]
    _check_readings(g)
    _take_state(g, elapsed)
    _watch_motors(g)
    g.checking.readings.late[0] = 0
    update_dynamics(body.tree, body.state, body.q, body.v)
    observe_frames(body)
    _choose_state(g, elapsed)
    if control.state[0] == STANDING:
        _refer(g, elapsed)
        solved = solve_whole_body(g.whole_body, g.tasks)
    elif control.state[0] == FOLLOWING:
        solved = _follow(g, elapsed)
    _send(g, solved)
    report(g)
