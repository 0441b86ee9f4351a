"""The control tick: one compiled kernel from measurement to joint torques, without allocation."""

from __future__ import annotations

from gaitsmith.compiled import bind, kernel
from gaitsmith.control.joint_torque import add_joint_feedback, bounded_torque, braked_torque, held_torque
from gaitsmith.control.report import report
from gaitsmith.control.state import AIRBORNE, DAMPING, FAULT, FOLLOWING, OFF, STANDING, WALKING, Tick
from gaitsmith.dynamics.algorithms import update_dynamics
from gaitsmith.estimation.estimator import estimate
from gaitsmith.estimation.measurement import is_usable
from gaitsmith.planned.clock import FORCED, ON_TIME
from gaitsmith.planned.follow import follow
from gaitsmith.planned.replay import replay_torque
from gaitsmith.template.phase import advance_phase, turn_heading
from gaitsmith.template.standing import refer_standing
from gaitsmith.template.step import STAND, WALK
from gaitsmith.template.walking import hold_posture, plan_step, refer_walking, restart_leg, set_torso, track_leg
from gaitsmith.whole_body.frames import observe_frames
from gaitsmith.whole_body.solve import solve_whole_body
from gaitsmith.whole_body.tasks import TaskTable

_DECAY = 0.98  # per tick, of the torque that is held when no new one can be computed
_LIFTED = 0.25  # of a step's period without load after which a robot that stood hangs in the air


@kernel
def _open_mailbox(table: int) -> None:
    """Take over the gait inputs that were commanded, all at once or not yet."""
    g = bind(Tick, table)
    letters = g.control.letters[0]
    if letters % 2 == 1 or letters == g.control.read[0]:
        return
    for k in range(g.control.mailbox.shape[0]):
        g.requested.values[k] = g.control.mailbox[k]
    if g.control.letters[0] == letters:
        g.control.read[0] = letters


@kernel
def _take_state(table: int) -> bool:
    """State of this tick, copied or estimated; False if a reading cannot be used."""
    g = bind(Tick, table)
    control, measurement = g.control, g.measurement
    if control.estimated[0] == 1:
        return estimate(
            g.tree,
            g.tree_state,
            g.legs,
            g.estimator_gains,
            g.estimator,
            measurement,
            g.gains.dt,
            g.contacts.kind,
            control.refused,
            control.q,
            control.v,
        )
    if not is_usable(measurement, False, control.refused):
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
def _choose_state(table: int) -> None:
    """Control state of this tick: what was asked for, unless the robot hangs in the air."""
    g = bind(Tick, table)
    control, step = g.control, g.step
    loaded = False
    for leg in range(g.legs.side.shape[0]):
        loaded = loaded or g.measurement.sole_force[leg] > g.gains.contact_force
    control.unloaded[0] = 0.0 if loaded else control.unloaded[0] + g.gains.dt
    stands = control.state[0] == STANDING or control.state[0] == FOLLOWING
    if control.sent[0] == 0 or (loaded and stands):
        for j in range(control.held.shape[0]):
            control.held[j] = control.q[7 + j]
    patience = g.latched.period[0] * (1.0 if step.mode[0] == WALK else _LIFTED)
    if control.asked[0] == FOLLOWING:
        lifted = control.unloaded[0] > g.latched.period[0]
        if control.state[0] == AIRBORNE and not lifted:
            g.body.fresh[0] = 1
        control.state[0] = AIRBORNE if lifted else FOLLOWING
    elif control.asked[0] != STANDING:
        control.state[0] = control.asked[0]
        step.mode[0] = STAND
    elif control.unloaded[0] > patience:
        control.state[0] = AIRBORNE
        step.mode[0] = STAND
    else:
        before = control.state[0]
        if before in (AIRBORNE, OFF, DAMPING, FOLLOWING):
            g.body.fresh[0] = 1
            step.heading_set[0] = 0
        control.state[0] = STANDING


@kernel
def _refer(table: int) -> None:
    """The template, on both feet or walking, writes the reference."""
    g = bind(Tick, table)
    step, legs, control, dt = g.step, g.legs, g.control, g.gains.dt
    switched = advance_phase(
        step,
        g.requested,
        g.latched,
        g.foothold,
        g.speed,
        g.touchdown,
        g.rest,
        legs,
        g.frames,
        g.tree_state.com,
        g.measurement.sole_force,
        g.forecast.arm,
        g.balance.divergent,
        dt,
    )
    turn_heading(step, g.latched, g.frames, dt)
    set_torso(step, legs, control.turns[0], g.frames, g.reference)
    hold_posture(legs, g.reference)
    if step.mode[0] != WALK:
        for leg in range(legs.side.shape[0]):
            restart_leg(step, legs, leg, control.q, control.v)
        refer_standing(step, g.latched, g.foothold, g.forecast, g.balance, legs, g.frames, g.tree_state, g.reference)
        return
    control.state[0] = WALKING
    if switched:
        restart_leg(step, legs, legs.other[step.stance[0]], control.q, control.v)
    plan_step(
        step,
        g.latched,
        g.foothold,
        g.speed,
        g.times,
        g.touchdown,
        g.forecast,
        g.balance,
        legs,
        g.frames,
        g.tree_state,
        g.body.acceleration,
        dt,
    )
    refer_walking(step, g.latched, g.foothold, g.cop, g.shares, g.forecast, g.balance, legs, g.frames, g.reference)
    for leg in range(legs.side.shape[0]):
        track_leg(
            step,
            g.inverse_gains,
            g.chains,
            g.inverse,
            g.inverse_program,
            g.balance,
            legs,
            g.frames,
            g.tree_state,
            g.reference,
            leg,
            dt,
        )


@kernel
def _solve(table: int, tasks: TaskTable) -> bool:
    """Solve the whole-body QP for a table of tasks; True if it has a solution."""
    g = bind(Tick, table)
    return solve_whole_body(
        g.program,
        g.tree_state,
        g.legs,
        g.reference,
        g.frames,
        g.contacts,
        tasks,
        g.contact_bounds,
        g.joint_bounds,
        g.motion,
        g.body,
        g.control.q,
        g.control.v,
    )


@kernel
def _follow(table: int) -> bool:
    """The plan writes the reference, and the whole body follows it; True if its QP was solved."""
    g = bind(Tick, table)
    control, step, following, legs, torso = g.control, g.step, g.following, g.legs, g.legs.torso[0]
    event = follow(
        following,
        g.frames.sole_position,
        g.frames.sole_rotation,
        g.tree_state.com,
        g.tree_state.com_velocity,
        g.measurement.sole_force,
        g.reference,
        g.gains.dt,
    )
    if event != ON_TIME:
        step.last_duration[0] = step.time[0]
        step.forced[0] = following.clock.touchdowns[FORCED]
    step.time[0], step.count[0] = following.clock.since_touchdown[0], following.clock.steps[0]
    step.heading[0], step.stance[0] = following.state.heading[0], following.state.support[0]
    if control.replays[0] == 1:
        rotation = g.tree_state.body_rotation[torso]
        replay_torque(g.replay, legs, g.reference, rotation, control.q, control.v, g.body.torque)
        return False
    return _solve(table, g.following_tasks)


@kernel
def _send(table: int, solved: bool) -> None:
    """Torque of this tick into ``control.torque``: inside its limit, no faster than its rate, never NaN."""
    g = bind(Tick, table)
    control, legs = g.control, g.legs
    state = control.state[0]
    free = state != WALKING and state != STANDING and state != FOLLOWING
    for j in range(control.torque.shape[0]):
        limit, last = legs.torque_limit[j], control.torque[j]
        wanted = g.body.torque[j]
        if state == OFF:
            wanted = 0.0
        elif state == FAULT:
            wanted = _DECAY * last
        elif state == DAMPING:
            wanted = braked_torque(limit, control.v[6 + j], g.gains.brake)
        elif state == AIRBORNE:
            error = control.held[j] - control.q[7 + j]
            wanted = held_torque(limit, error, control.v[6 + j], g.gains.hold, g.gains.brake)
        g.balance.torque[j] = wanted
    if solved and state == WALKING:
        add_joint_feedback(g.feedback, legs, g.reference, control.q, control.v, g.balance.torque)
    for j in range(control.torque.shape[0]):
        limit, last = legs.torque_limit[j], control.torque[j]
        wanted = bounded_torque(g.balance.torque[j], 0.0, limit)
        if g.control.sent[0] == 1:
            step = g.joint_bounds.torque_step
            wanted = min(max(wanted, last - step), last + step)
        control.torque[j] = wanted
        if free:
            g.body.torque[j] = wanted
    g.control.sent[0] = 1


@kernel
def tick(table: int) -> None:
    """Advance the controller by one period; ``table`` is the address of its arena's table."""
    g = bind(Tick, table)
    control = g.control
    control.time[0] += g.gains.dt
    _open_mailbox(table)
    solved = False
    if _take_state(table):
        update_dynamics(g.tree, g.tree_state, control.q, control.v)
        observe_frames(g.tree, g.tree_state, g.legs, control.v, g.frames)
        _choose_state(table)
        if control.state[0] == STANDING:
            _refer(table)
            solved = _solve(table, g.tasks)
        elif control.state[0] == FOLLOWING:
            solved = _follow(table)
    else:
        control.refused_ticks[0] += 1
        control.state[0] = FAULT
    _send(table, solved)
    report(table)
