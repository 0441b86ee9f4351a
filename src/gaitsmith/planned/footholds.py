"""Where a plan's soles land, and how the plan moves with them.

The plan's motion is relative to its soles. Their real places a_i (less the planned ones) shift it: the ZMP by
Z = Σ w_i a_i, with weights that move linearly from sole to sole in double support. The linear inverted pendulum under
that ZMP then has its divergent component ξ shifted by

    Ξ(t) = ∫ ω e^{-ω(s-t)} Z(s) ds  from t on,

and its CoM by C with C' = ω (Ξ - C): a reference that the robot can follow, whatever the footholds are. What ξ deviates
from it by more than the CoP can take back shifts the next foothold by Δ, so that Ξ agrees with ξ.
"""

from __future__ import annotations

import math

from gaitsmith.compiled import Cube, Matrix, kernel
from gaitsmith.planned.clock import PlanClock, flies, next_stretch
from gaitsmith.planned.law import Following, FollowLaw, FollowState
from gaitsmith.planned.table import PER_SOLE, SOLES, PlanTable
from gaitsmith.whole_body.reference import HEEL, NONE, TOE

_SHORTEST = 0.03  # s, least time in which a swing sole's shift is brought to its goal


@kernel
def locate(plan: PlanTable, law: FollowLaw, section: int, state: FollowState, position: Matrix, rotation: Cube) -> None:
    """a_i of every sole on the ground; of one that stands on an edge, by where the edge is."""
    cos, sin = math.cos(state.heading[0]), math.sin(state.heading[0])
    for row in range(plan.contact.shape[1]):
        kind = plan.contact[section, row]
        if kind == NONE:
            continue
        arm = across = 0.0
        if kind in (HEEL, TOE):
            end = law.end[row, 0 if kind == HEEL else 1]
            arm, across = end[0], 0.5 * (end[1] + end[2])
        x, y, z = plan.place[section, row, 0], plan.place[section, row, 1], plan.place[section, row, 2]
        state.place[row, 0] = position[row, 0] - (cos * x - sin * y)
        state.place[row, 1] = position[row, 1] - (sin * x + cos * y)
        state.place[row, 2] = position[row, 2] + arm * rotation[row, 2, 0] + across * rotation[row, 2, 1] - z
        if kind in (HEEL, TOE):
            own = state.heading[0] + plan.place[section, row, 3]
            c, s = math.cos(own), math.sin(own)
            state.place[row, 0] += arm * (rotation[row, 0, 0] - c) + across * (rotation[row, 0, 1] + s)
            state.place[row, 1] += arm * (rotation[row, 1, 0] - s) + across * (rotation[row, 1, 1] - c)


@kernel
def move_origin(plan: PlanTable, before: int, section: int, state: FollowState) -> None:
    """Give C in terms of the present support sole; at the beginning, the weighted place of all soles.

    The heading is the present support sole's already.
    """
    support = plan.support[section]
    if state.support[0] < 0:
        for axis in range(3):
            state.anchor[0, axis] = 0.0
            for row in range(plan.contact.shape[1]):
                state.anchor[0, axis] += plan.weight_from[section, row] * state.place[row, axis]
    elif state.support[0] != support:
        heading = state.heading[0] - plan.place[before, support, 3]
        cos, sin = math.cos(heading), math.sin(heading)
        x, y = plan.place[before, support, 0], plan.place[before, support, 1]
        state.anchor[0, 0] += cos * x - sin * y
        state.anchor[0, 1] += sin * x + cos * y
        state.anchor[0, 2] += plan.place[before, support, 2]
    state.support[0] = support


@kernel
def expect_landing(plan: PlanTable, before: int, section: int, state: FollowState) -> None:
    """Remember where the soles that land now should come to stand."""
    cos, sin = math.cos(state.heading[0]), math.sin(state.heading[0])
    base = state.place[plan.support[before]]
    for row in range(plan.contact.shape[1]):
        if plan.contact[before, row] == NONE and plan.contact[section, row] != NONE:
            dx = plan.place[section, row, 0] + state.foothold[row, 0]
            dy = plan.place[section, row, 1] + state.foothold[row, 1]
            state.expected[row, 0] = base[0] + cos * dx - sin * dy
            state.expected[row, 1] = base[1] + sin * dx + cos * dy


@kernel
def learn_landing(law: FollowLaw, row: int, state: FollowState) -> None:
    """Correct the next landings by what the sole that bears alone from now on missed its foothold.

    This is the speed's integral: steps are as long as planned on average, whatever the masses and the tracking.
    """
    cos, sin = math.cos(state.heading[0]), math.sin(state.heading[0])
    dx, dy = state.place[row, 0] - state.expected[row, 0], state.place[row, 1] - state.expected[row, 1]
    forward, lateral, most = cos * dx + sin * dy, cos * dy - sin * dx, law.landing_bias
    for other in range(state.bias.shape[0]):  # soles miss alike ahead, and each for itself sideways
        state.bias[other, 0] = min(max(state.bias[other, 0] - law.landing_gain * forward, -most), most)
    state.bias[row, 1] = min(max(state.bias[row, 1] - law.landing_gain * lateral, -most), most)


@kernel
def _held(plan: PlanTable, law: FollowLaw, following: int) -> float:
    """How much of Δ is in Ξ at touchdown: (1 - e^{-ωD}) / (ωD) for a double support of D."""
    span = law.omega * plan.stretch_duration[following]
    return float((1.0 - math.exp(-span)) / span)


@kernel
def _room(g: Following, row: int, axis: int, sign: float) -> float:
    """Way of the planned CoP of a sole along an axis, towards ``sign``, to where it is the margin from an edge, m."""
    effort, law = g.sample.effort, g.law
    wrench = effort.shape[0] - PER_SOLE * (law.edges.shape[0] - row)
    force = max(effort[wrench + 2], 1e-6)
    x, y, room = -effort[wrench + 4] / force, effort[wrench + 3] / force, math.inf
    for k in range(law.edges[row]):
        edge = law.edge[row, k]
        towards = sign * edge[axis]
        if towards > 1e-9:
            room = min(room, (edge[2] - law.margin - edge[0] * x - edge[1] * y) / towards)
    return float(max(room, 0.0)) if room < math.inf else 0.0


@kernel
def choose_footholds(g: Following, section: int, following: int, left: float) -> None:
    """Δ of the soles that land next from the divergent component's error, with time left to the landing, s."""
    plan, law, state = g.plan, g.law, g.state
    support = plan.support[section]
    growth = math.exp(law.omega * left)
    cos, sin = math.cos(state.heading[0]), math.sin(state.heading[0])
    for row in range(plan.contact.shape[1]):
        if plan.contact[section, row] != NONE or plan.contact[following, row] == NONE:
            continue
        for axis in range(2):
            if left < law.frozen:
                break
            sign = 1.0 if state.error[axis] > 0.0 else -1.0
            room = law.room_share * _room(g, support, axis, sign) * (1.0 - 1.0 / growth)
            beyond = sign * max(abs(state.error[axis]) - room, 0.0)
            wanted = beyond * growth / _held(plan, law, following) if left < law.horizon else 0.0
            wanted = min(max(wanted, -law.reach[axis]), law.reach[axis])
            side = plan.place[following, row, 1] - plan.place[following, support, 1]
            if axis == 1 and side > 0.0:
                wanted = max(wanted, min(law.separation - side, 0.0))
            elif axis == 1:
                wanted = min(wanted, max(-law.separation - side, 0.0))
            state.foothold[row, axis] = wanted
        state.goal[0] = cos * state.foothold[row, 0] - sin * state.foothold[row, 1]
        state.goal[1] = sin * state.foothold[row, 0] + cos * state.foothold[row, 1]


@kernel
def swing_pace(plan: PlanTable, law: FollowLaw, section: int, state: FollowState) -> float:
    """Rate of the plan's clock in a swing, 1 in flight: the divergent component's lateral place tells the time.

    It grows towards the side of the swing sole. Pushed over its stance leg, the robot waits until the CoP has brought
    it back; pushed the other way it keeps the time, and the foothold makes up for it.
    """
    lead = 0.0
    if flies(plan, section):
        return 1.0
    for row in range(plan.contact.shape[1]):
        if plan.contact[section, row] == NONE and state.support[0] == plan.support[section]:
            away = plan.motion[section, 0, SOLES + PER_SOLE * row + 1]
            lead = state.error[1] if away > 0.0 else -state.error[1]
    return float(min(max(1.0 + law.pace * min(lead + law.pace_slack, 0.0), law.slowest), 1.0))


@kernel
def move_anchor(plan: PlanTable, law: FollowLaw, clock: PlanClock, section: int, state: FollowState, dt: float) -> None:
    """Z and Ξ of this instant, and the CoM's shift C after them."""
    span, omega = plan.stretch_duration[section], law.omega
    share = min(max((plan.stretch_start[section] + clock.time[0]) / span, 0.0), 1.0)
    decay = math.exp(-omega * span * (1.0 - share))
    visit = next_stretch(plan, clock)
    held = _held(plan, law, plan.sequence[visit]) * decay if visit >= 0 else 0.0
    for axis in range(3):
        zmp = change = 0.0
        for row in range(plan.contact.shape[1]):
            begin, end = plan.weight_from[section, row], plan.weight_to[section, row]
            zmp += (begin + share * (end - begin)) * state.place[row, axis]
            change += (end - begin) * state.place[row, axis]
        divergent = zmp + change * (1.0 - decay) / (omega * span)
        if axis < 2:
            divergent += state.goal[axis] * held
        rate = omega * (divergent - state.anchor[0, axis])
        state.anchor[1, axis] = rate
        state.anchor[2, axis] = omega * (omega * (divergent - zmp) - rate)
        state.anchor[0, axis] += dt * rate


@kernel
def move_swing(shift: Matrix, goal_x: float, goal_y: float, left: float, dt: float) -> None:
    """Bring a swing sole's shift to its goal at rest, with least jerk over the time that is left, s."""
    span = max(left, _SHORTEST)
    for axis in range(3):
        goal = goal_x if axis == 0 else goal_y if axis == 1 else 0.0
        jerk = 60.0 * (goal - shift[0, axis]) / span - 36.0 * shift[1, axis] - 9.0 * shift[2, axis] * span
        jerk /= span * span
        shift[0, axis] += dt * (shift[1, axis] + 0.5 * dt * shift[2, axis])
        shift[1, axis] += dt * (shift[2, axis] + 0.5 * dt * jerk)
        shift[2, axis] += dt * jerk
