"""A plan as a producer of references: its clock, its soles where they stand, its footholds, and all tracked motion."""

from __future__ import annotations

import math

from gaitsmith.compiled import Cube, Matrix, Vector, kernel
from gaitsmith.planned.clock import ON_TIME, advance, flies, is_swing, next_stretch
from gaitsmith.planned.evaluate import evaluate, orientation
from gaitsmith.planned.footholds import (
    choose_footholds,
    expect_landing,
    learn_landing,
    locate,
    move_anchor,
    move_origin,
    move_swing,
    swing_pace,
)
from gaitsmith.planned.law import Following
from gaitsmith.planned.table import COM, PER_SOLE, SOLES, TORSO
from gaitsmith.whole_body.reference import NONE, WORLD, Reference


@kernel
def follow(
    g: Following,
    sole_position: Matrix,
    sole_rotation: Cube,
    com: Vector,
    com_velocity: Vector,
    sole_force: Vector,
    out: Reference,
    dt: float,
) -> int:
    """Advance the plan by one tick and fill the reference; it begins with x where the first support sole points to.

    Args:
        g: the plan.
        sole_position: (n, 3) sole frames' origins, world, m.
        sole_rotation: (n, 3, 3) sole to world.
        com: (3,) world, m.
        com_velocity: (3,) world axes, m/s.
        sole_force: (n,) normal force on every sole, N.
        out: the reference.
        dt: s.

    Returns:
        How a swing ended in this tick; ON_TIME if none did.
    """
    plan, law, clock, state = g.plan, g.law, g.clock, g.state
    before = plan.sequence[clock.visit[0]]
    window = law.window if state.goal[0] == 0.0 and state.goal[1] == 0.0 else 0.0
    pace = swing_pace(plan, law, before, state)
    event = advance(plan, clock, dt, pace, sole_force, law.touchdown_force, law.earliest, window, law.longest_wait)
    section = plan.sequence[clock.visit[0]]
    support = plan.support[section]
    if state.support[0] < 0:
        state.heading[0] = math.atan2(sole_rotation[support, 1, 0], sole_rotation[support, 0, 0])
    elif state.support[0] != support:
        state.heading[0] += plan.place[before, support, 3]
    if law.turns == 0:
        x, y, yaw = sole_rotation[support, 0, 0], sole_rotation[support, 1, 0], state.heading[0]
        state.heading[0] += law.omega * dt * (math.cos(yaw) * y - math.sin(yaw) * x)
    evaluate(plan, section, clock.time[0], g.sample)
    scale_time(g)
    locate(plan, law, section, state, sole_position, sole_rotation)
    if event != ON_TIME:
        expect_landing(plan, before, section, state)
    if is_swing(plan, section) and not is_swing(plan, before) and clock.steps[0] > 0:
        learn_landing(law, support, state)
    move_origin(plan, before, section, state)
    _move_soles(g, section, com, com_velocity, dt)
    _write_body(g, section, out)
    for row in range(plan.contact.shape[1]):
        _write_sole(g, section, row, out)
    write_joints(g, out)
    return event


@kernel
def scale_time(g: Following) -> None:
    """Derivatives by time instead of by the plan's own; none once it has ended."""
    motion, rate = g.sample.motion, g.clock.rate[0] if g.clock.ended[0] == 0 else 0.0
    for channel in range(motion.shape[1]):
        motion[1, channel] *= rate
        motion[2, channel] *= rate * rate


@kernel
def _move_soles(g: Following, section: int, com: Vector, com_velocity: Vector, dt: float) -> None:
    """Footholds, the CoM's shift, and the shift of every sole against the plan."""
    plan, law, clock, state, motion = g.plan, g.law, g.clock, g.state, g.sample.motion
    base = state.place[plan.support[section]]
    cos, sin = math.cos(state.heading[0]), math.sin(state.heading[0])
    dx = com[0] + com_velocity[0] / law.omega - base[0]
    dy = com[1] + com_velocity[1] / law.omega - base[1]
    state.error[0] = cos * dx + sin * dy - motion[0, COM] - motion[1, COM] / law.omega
    state.error[1] = cos * dy - sin * dx - motion[0, COM + 1] - motion[1, COM + 1] / law.omega
    left = max(plan.stretch_duration[section] - plan.stretch_start[section] - clock.time[0], 0.0)
    landing = next_stretch(plan, clock) if is_swing(plan, section) and not flies(plan, section) else -1
    state.goal[0], state.goal[1] = 0.0, 0.0
    if landing >= 0:
        choose_footholds(g, section, plan.sequence[landing], left)
    move_anchor(plan, law, clock, section, state, dt)
    for row in range(plan.contact.shape[1]):
        shift, bias = state.shift[row], state.bias[row]
        if plan.contact[section, row] != NONE:
            for axis in range(3):
                shift[0, axis] = state.place[row, axis] - base[axis]
                shift[1, axis], shift[2, axis] = 0.0, 0.0
            state.foothold[row, 0], state.foothold[row, 1] = 0.0, 0.0
        elif clock.waited[0] == 0.0:
            goal_x = state.goal[0] + cos * bias[0] - sin * bias[1]
            goal_y = state.goal[1] + sin * bias[0] + cos * bias[1]
            move_swing(shift, goal_x, goal_y, left, dt)
        else:
            shift[0, 2] -= law.descent_speed * dt
            shift[1, 0], shift[1, 1], shift[1, 2] = 0.0, 0.0, -law.descent_speed


@kernel
def _turn_in(values: Vector, first: int, cos: float, sin: float, out: Vector) -> None:
    """Three channels of the plan in world axes."""
    out[0] = cos * values[first] - sin * values[first + 1]
    out[1] = sin * values[first] + cos * values[first + 1]
    out[2] = values[first + 2]


@kernel
def _write_body(g: Following, section: int, out: Reference) -> None:
    """CoM and torso; while the plan waits for the ground, the CoM goes on as it moved at the end."""
    motion, state, waited = g.sample.motion, g.state, g.clock.waited[0]
    cos, sin = math.cos(state.heading[0]), math.sin(state.heading[0])
    for order in range(3):
        _turn_in(motion[order], COM, cos, sin, out.com[order])
    for axis in range(3):
        out.com[0, axis] += waited * (out.com[1, axis] + 0.5 * waited * out.com[2, axis])
        out.com[1, axis] += waited * out.com[2, axis]
        for order in range(3):
            out.com[order, axis] += state.anchor[order, axis]
        out.com_weight[axis], out.torso_weight[axis] = 1.0, 1.0
    if g.law.turns == 0:
        out.torso_weight[2] = 0.0
    if is_swing(g.plan, section) and g.law.edges[g.plan.support[section]] == 2:
        out.com_weight[1] = g.law.on_line
    out.hip_height_weight[0] = 0.0
    orientation(motion, TORSO, state.heading[0], out.torso_rotation, out.torso_spin, out.torso_angular_acceleration)


@kernel
def _write_sole(g: Following, section: int, row: int, out: Reference) -> None:
    """Motion, contact and load of one sole."""
    plan, motion, state = g.plan, g.sample.motion, g.state
    first, heading, kind = SOLES + PER_SOLE * row, state.heading[0], plan.contact[section, row]
    base, shift = state.place[plan.support[section]], state.shift[row]
    out.contact[row], out.sole_frame[row] = kind, WORLD
    position, velocity, acceleration = out.sole_position[row], out.sole_velocity[row], out.sole_acceleration[row]
    spin, turn = out.sole_spin[row], out.sole_angular_acceleration[row]
    cos, sin = math.cos(heading), math.sin(heading)
    _turn_in(motion[0], first, cos, sin, position)
    _turn_in(motion[1], first, cos, sin, velocity)
    _turn_in(motion[2], first, cos, sin, acceleration)
    orientation(motion, first + 3, heading, out.sole_rotation[row], spin, turn)
    for axis in range(3):
        if kind == NONE and g.clock.waited[0] > 0.0:
            velocity[axis], acceleration[axis], spin[axis], turn[axis] = 0.0, 0.0, 0.0, 0.0
        position[axis] += base[axis] + shift[0, axis]
        velocity[axis] += shift[1, axis]
        acceleration[axis] += shift[2, axis]
    effort = g.sample.effort
    wrench = effort.shape[0] - PER_SOLE * (plan.contact.shape[1] - row)
    force = effort[wrench + 2]
    out.load[row] = force
    out.load_weight[row] = 1.0 if kind != NONE and not is_swing(plan, section) else 0.0
    out.cop[row, 0] = -effort[wrench + 4] / force if force > 1e-6 else 0.0
    out.cop[row, 1] = effort[wrench + 3] / force if force > 1e-6 else 0.0
    out.cop_weight[row] = 0.0


@kernel
def write_joints(g: Following, out: Reference) -> None:
    """Posture and planned torque."""
    motion = g.sample.motion
    joints = SOLES + PER_SOLE * g.plan.contact.shape[1]
    for j in range(out.joint.shape[1]):
        for order in range(3):
            out.joint[order, j] = motion[order, joints + j]
        out.joint_weight[j] = 1.0
        out.torque[j] = g.sample.effort[j]
