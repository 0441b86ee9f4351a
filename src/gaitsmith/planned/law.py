"""Numbers and memory of the law that follows a plan; the numbers scale with the robot's height, mass and gravity."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gaitsmith.compiled import Cube, IntVector, Matrix, Vector
from gaitsmith.planned.clock import PlanClock, make_plan_clock
from gaitsmith.planned.evaluate import PlanSample, make_plan_sample
from gaitsmith.planned.table import Plan, PlanTable, empty_table
from gaitsmith.whole_body.legs import edge_table

if TYPE_CHECKING:
    from gaitsmith.robots import Robot


@dataclass(frozen=True)
class FollowParameters:
    """Dimensionless numbers of the law; z is the plan's mean CoM height, ω = √(g/z), U = √(gz).

    Attributes:
        touchdown_force: of the weight.
        earliest: share of a swing after which a landing counts.
        window: before the planned landing in which a landing is on time, 1/ω.
        longest_wait: for a late landing, 1/ω.
        descent_speed: of a sole that waits for the ground, U.
        room_share: of the CoP's room that is left to its feedback before the foothold moves.
        margin: of the CoP from the sole's edge, z.
        reach: largest shift of a foothold, forward and lateral, z.
        separation: gap between the soles' edges, z.
        landing_gain: share of a miss by which the next landing is corrected.
        landing_bias: largest such correction, z.
        pace: change of the clock's rate in a swing by the lateral error of the divergent component, 1/z.
        pace_slack: error that changes nothing, z.
        slowest: rate of the clock in a swing; it is never faster than time.
        horizon: before landing, from which on the foothold is chosen, 1/ω.
        frozen: before landing, from which on it is kept, 1/ω.
        on_line: share of the CoM's lateral task while a line sole bears alone: no CoP moves the CoM there, and what
            else could (the torso's roll, the swing leg) has its own task.
    """

    touchdown_force: float = 0.05
    earliest: float = 0.6
    window: float = 0.15
    longest_wait: float = 0.6
    descent_speed: float = 0.07
    room_share: float = 0.7
    margin: float = 0.02
    reach: tuple[float, float] = (0.4, 0.3)
    separation: float = 0.02
    landing_gain: float = 0.5
    landing_bias: float = 0.1
    pace: float = 5.0
    pace_slack: float = 0.02
    slowest: float = 0.4
    horizon: float = 2.5
    frozen: float = 0.4
    on_line: float = 0.0


class FollowLaw(NamedTuple):
    """:class:`FollowParameters` of one robot and plan, in SI units, and the soles' sizes.

    Attributes:
        turns: 1 if the legs can turn the torso about the vertical.
        separation: least lateral distance between the soles' origins, m.
        edges: (n,) how many every sole has.
        edge: (n, most, 3) outward unit normal and distance from the sole frame's origin, m.
        end: (n, 2, 3) heel's and toe's edge: x, least and greatest y, m.
    """

    omega: float
    touchdown_force: float
    earliest: float
    window: float
    longest_wait: float
    descent_speed: float
    room_share: float
    margin: float
    reach: Vector
    separation: float
    landing_gain: float
    landing_bias: float
    pace: float
    pace_slack: float
    slowest: float
    horizon: float
    frozen: float
    on_line: float
    turns: int
    edges: IntVector
    edge: Cube
    end: Cube


class FollowState(NamedTuple):
    """What the law remembers; "shift" is against the plan, whose place in the world the support sole decides.

    Attributes:
        heading: (1,) of the support sole in the world, rad: as planned from the first one's on; with legs that cannot
            turn it goes with the soles as they stand. Plan's axes below.
        support: (1,) row of the last tick's support sole, -1 before the first.
        place: (n, 3) a_i: the plan's origin in the world as each sole on the ground says, m.
        anchor: (3, 3) C: the plan's origin as the CoM follows it, its rate and its acceleration, world, m.
        shift: (n, 3, 3) of every sole against the support sole's a_i, its rate and acceleration, world axes, m.
        foothold: (n, 2) Δ of the soles that land next, plan's axes, m.
        goal: (2,) the same of the one that lands next, world axes, m.
        expected: (n, 2) where a sole that has landed should stand, world, m.
        bias: (n, 2) by which a sole is sent beyond its foothold, as it landed short of those before, plan's axes, m.
        error: (2,) of ξ against the support sole's Ξ, plan's axes, m.
    """

    heading: Vector
    support: IntVector
    place: Matrix
    anchor: Matrix
    shift: Cube
    foothold: Matrix
    goal: Vector
    expected: Matrix
    bias: Matrix
    error: Vector


class Following(NamedTuple):
    """A plan that is followed: what it says, how, and how far it is."""

    plan: PlanTable
    law: FollowLaw
    clock: PlanClock
    sample: PlanSample
    state: FollowState


def make_following(
    robot: Robot, plan: Plan | None = None, parameters: FollowParameters | None = None, turns: bool = True
) -> Following:
    """A plan at its beginning; without one, room for none. ``turns``: whether the legs can turn the torso."""
    soles, joints = len(robot.legs), len(robot.joint_names)
    state = FollowState(
        heading=np.zeros(1),
        support=np.full(1, -1, dtype=np.int64),
        place=np.zeros((soles, 3)),
        anchor=np.zeros((3, 3)),
        shift=np.zeros((soles, 3, 3)),
        foothold=np.zeros((soles, 2)),
        goal=np.zeros(2),
        expected=np.zeros((soles, 2)),
        bias=np.zeros((soles, 2)),
        error=np.zeros(2),
    )
    table = empty_table(soles, joints) if plan is None else plan.table
    law = _law(robot, 1.0 if plan is None else plan.height, parameters or FollowParameters(), turns)
    return Following(table, law, make_plan_clock(), make_plan_sample(soles, joints), state)


def restart_following(following: Following) -> None:
    """Put a plan back to its beginning."""
    for array in (*following.clock, *following.state):
        array[...] = 0
    following.clock.rate[0], following.state.support[0] = 1.0, -1


def _law(robot: Robot, z: float, given: FollowParameters, turns: bool) -> FollowLaw:
    gravity = float(np.linalg.norm(robot.model.opt.gravity))
    omega, speed = math.sqrt(gravity / z), math.sqrt(gravity * z)
    soles = [leg.sole for leg in robot.legs]
    edges, edge = edge_table(soles)
    return FollowLaw(
        omega=omega,
        touchdown_force=given.touchdown_force * robot.mass * gravity,
        earliest=given.earliest,
        window=given.window / omega,
        longest_wait=given.longest_wait / omega,
        descent_speed=given.descent_speed * speed,
        room_share=given.room_share,
        margin=given.margin * z,
        reach=z * np.array(given.reach),
        separation=sum(sole.half_width for sole in soles[:2]) + given.separation * z,
        landing_gain=given.landing_gain,
        landing_bias=given.landing_bias * z,
        pace=given.pace / z,
        pace_slack=given.pace_slack * z,
        slowest=given.slowest,
        horizon=given.horizon / omega,
        frozen=given.frozen / omega,
        on_line=given.on_line,
        turns=int(turns),
        edges=edges,
        edge=edge,
        end=np.array([sole.ends for sole in soles]),
    )
