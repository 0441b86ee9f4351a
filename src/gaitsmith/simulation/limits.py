"""Limits that a run hits: which, since when, how often; forgotten once a step has passed without any."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import Cube, IntVector, Vector, kernel
from gaitsmith.robots import Robot
from gaitsmith.robots.presets import ControlParameters
from gaitsmith.whole_body.legs import edge_table

_GRAVITY = 9.81
_SATURATED = 0.999  # of the limit
_EDGE = 1e-3  # m within which the ZMP or a foothold counts as on its bound
_STOP = 5e-3  # rad within which a joint counts as on its limit
_SLIDING = 0.1  # √(gH) above which a loaded sole slips
_BEHIND = 0.07  # H by which a swing foot that is farther from its target lags
_MISTAKEN = 0.06  # √(gH) by which the speed that the controller believes is wrong
_HELD = 5e-3  # s that a limit has to be hit without a pause; shorter ones are the solver's business


class Seen(NamedTuple):
    """What the monitor reads: telemetry of the controller, then what is true of the robot."""

    mode: Vector
    stance: Vector
    step_count: Vector
    period: Vector
    height: Vector
    yaw_rate: Vector
    joint_position: Vector
    joint_velocity: Vector
    torque: Vector
    foothold: Vector
    foothold_bound: Vector
    foot_desired: Vector
    foot_actual: Vector
    wrench: Vector
    zmp: Vector
    qp_infeasible: Vector
    touchdowns_forced: Vector
    believed_velocity: Vector
    com_velocity: Vector
    torso: Vector
    attitude: Vector
    hip_height: Vector
    sole: Vector
    force: Vector
    leg_contact: Vector
    body_contact: Vector
    diverged: Vector


class Bounds(NamedTuple):
    """Limits to compare with; joint order, SI units."""

    torque: Vector
    velocity: Vector
    position_low: Vector
    position_high: Vector
    edges: IntVector
    edge: Cube
    reach: float
    spread: float
    zmp_margin: float
    friction: float
    contact: float
    dt: float


class Flags(NamedTuple):
    """1 where a limit is hit at this tick, as views of one array; per joint, per sole, or single."""

    torque: IntVector
    velocity: IntVector
    position: IntVector
    slip: IntVector
    lag: IntVector
    reach: IntVector
    spread: IntVector
    separation: IntVector
    zmp: IntVector
    friction: IntVector
    legs: IntVector
    infeasible: IntVector
    forced: IntVector
    mistaken: IntVector


MISTAKEN = "estimated speed far from the true one"
_WORDS = {
    "torque": "torque of {} saturated",
    "velocity": "speed limit of {}",
    "position": "joint limit of {}",
    "slip": "{} sole slipping",
    "lag": "{} foot behind its target",
    "reach": "foothold at its reach bound",
    "spread": "foothold at its spread bound",
    "separation": "foothold at its separation bound",
    "zmp": "ZMP at the edge of the {} sole",
    "friction": "friction limit of the {} sole",
    "legs": "legs touching each other",
    "infeasible": "whole-body QP infeasible",
    "forced": "step ended by the clock",
    "mistaken": MISTAKEN,
}
_AT_ONCE = ("legs", "infeasible", "forced")  # count from a single tick on


class Hits(NamedTuple):
    """Limits since the last step without any."""

    flags: Flags  # of this tick
    now: IntVector  # (n,) the same in one array
    hold: IntVector  # (n,) ticks in a row that make a hit
    lasting: IntVector  # (n,) ticks in a row so far
    first: IntVector  # (n,) tick at which the first hit began; -1 for none
    disturbed: IntVector  # whether the present step has a hit
    since: IntVector  # ticks since the step began, or since one could have
    qp_infeasible: Vector  # counts at the tick before
    touchdowns_forced: Vector
    sole: Vector  # (3 n,) places at the tick before, m


class Joints(NamedTuple):
    """Per joint over the run."""

    torque_peak: Vector  # N·m
    torque_saturated: Vector  # ticks
    torque_before: Vector  # at the tick before, N·m
    torque_step: Vector  # largest change from one tick to the next while walking undisturbed, N·m
    velocity_peak: Vector  # rad/s
    velocity_over: Vector  # ticks beyond the limit


def make_bounds(robot: Robot, parameters: ControlParameters, dt: float) -> Bounds:
    """Limits of a robot and of its controller; ``dt`` is the time from one observation to the next, s."""
    limits = (robot.torque_limit, robot.velocity_limit, robot.position_low, robot.position_high)
    torque, velocity, low, high = map(np.asarray, limits)
    edges, edge = edge_table([leg.sole for leg in robot.legs])
    foothold, contact = parameters.foothold, parameters.contact
    bounds = (foothold.reach, foothold.spread, contact.zmp_margin, contact.friction)
    return Bounds(torque, velocity, low, high, edges, edge, *bounds, parameters.touchdown.force, dt)


def make_hits(joints: tuple[str, ...], soles: tuple[str, ...], dt: float) -> tuple[Hits, tuple[str, ...]]:
    """No limit hit yet, and the limits' names."""
    owners = dict.fromkeys(("torque", "velocity", "position"), joints)
    owners |= dict.fromkeys(("slip", "lag", "zmp", "friction"), soles)
    members = [[_WORDS[field].format(owner) for owner in owners.get(field, ("",))] for field in Flags._fields]
    holds = [1 if field in _AT_ONCE else max(1, round(_HELD / dt)) for field in Flags._fields]
    now = np.zeros(sum(map(len, members)), dtype=np.int64)
    ends = np.cumsum([len(names) for names in members])
    flags, hold = Flags(*np.split(now, ends[:-1])), np.repeat(holds, [len(names) for names in members])
    lasting, first, disturbed, since = np.zeros_like(now), np.full_like(now, -1), *np.zeros((2, 1), dtype=np.int64)
    hits = Hits(
        flags, now, hold, lasting, first, disturbed, since, np.zeros(1), np.zeros(1), np.full(3 * len(soles), np.nan)
    )
    return hits, tuple(name for names in members for name in names)


@kernel
def _is_saturated(torque: float, limit: float) -> bool:
    """Whether a torque counts as at its limit."""
    return abs(torque) >= _SATURATED * limit


@kernel
def _slips(seen: Seen, bounds: Bounds, hits: Hits, leg: int) -> bool:
    """Whether a loaded sole slides; keeps its place."""
    way = 0.0
    for i in range(2):
        way += (seen.sole[3 * leg + i] - hits.sole[3 * leg + i]) ** 2
        hits.sole[3 * leg + i] = seen.sole[3 * leg + i]
    fast = math.sqrt(way) > bounds.dt * _SLIDING * math.sqrt(_GRAVITY * seen.height[0])
    return bool(fast and seen.force[leg] > bounds.contact)


@kernel
def _lags(seen: Seen, leg: int) -> bool:
    """Whether the swing foot is far from where it is wanted."""
    if seen.stance[0] == leg or seen.stance[0] > 1.0:
        return False
    way = 0.0
    for i in range(2):
        way += (seen.foot_desired[3 * leg + i] - seen.foot_actual[3 * leg + i]) ** 2
    return bool(math.sqrt(way) > _BEHIND * seen.height[0])


@kernel
def _is_mistaken(seen: Seen) -> bool:
    """Whether the horizontal speed that the controller believes is far from the true one."""
    off = 0.0
    for i in range(2):
        off += (seen.believed_velocity[i] - seen.com_velocity[i]) ** 2
    return bool(math.sqrt(off) > _MISTAKEN * math.sqrt(_GRAVITY * seen.height[0]))


@kernel
def find_hits(seen: Seen, bounds: Bounds, hits: Hits) -> None:
    """Which limits are hit at this tick."""
    flags = hits.flags
    for j in range(bounds.torque.shape[0]):
        flags.torque[j] = 1 if _is_saturated(seen.torque[j], bounds.torque[j]) else 0
        flags.velocity[j] = 1 if abs(seen.joint_velocity[j]) > bounds.velocity[j] else 0
        q = seen.joint_position[j]
        flags.position[j] = 1 if q < bounds.position_low[j] + _STOP or q > bounds.position_high[j] - _STOP else 0
    bounded = seen.foothold_bound[0] > 0.0 and seen.mode[0] > 0.0
    far, wide = abs(seen.foothold[0]) > bounds.reach - _EDGE, abs(seen.foothold[1]) > bounds.spread - _EDGE
    flags.reach[0] = 1 if bounded and far else 0
    flags.spread[0] = 1 if bounded and wide and not far else 0
    flags.separation[0] = 1 if bounded and not far and not wide else 0
    for leg in range(bounds.edges.shape[0]):
        force = seen.wrench[6 * leg : 6 * leg + 3]
        loaded, room = force[2] > 1.0, math.inf
        for k in range(bounds.edges[leg]):
            a, b, distance = bounds.edge[leg, k, 0], bounds.edge[leg, k, 1], bounds.edge[leg, k, 2]
            room = min(room, distance - a * seen.zmp[2 * leg] - b * seen.zmp[2 * leg + 1])
        flags.zmp[leg] = 1 if loaded and room < bounds.zmp_margin + _EDGE else 0
        along = math.sqrt(force[0] ** 2 + force[1] ** 2)
        flags.friction[leg] = 1 if loaded and along > _SATURATED * bounds.friction * force[2] else 0
        flags.slip[leg] = 1 if _slips(seen, bounds, hits, leg) else 0
        flags.lag[leg] = 1 if seen.mode[0] > 0.0 and _lags(seen, leg) else 0
    flags.legs[0] = 1 if seen.leg_contact[0] > 0.0 else 0
    flags.infeasible[0] = 1 if seen.qp_infeasible[0] > hits.qp_infeasible[0] else 0
    flags.forced[0] = 1 if seen.touchdowns_forced[0] > hits.touchdowns_forced[0] else 0
    flags.mistaken[0] = 1 if _is_mistaken(seen) else 0
    hits.qp_infeasible[0], hits.touchdowns_forced[0] = seen.qp_infeasible[0], seen.touchdowns_forced[0]


@kernel
def remember_hits(seen: Seen, bounds: Bounds, hits: Hits, tick: int, stepped: bool) -> None:
    """Forget everything when a step ends in which no limit was hit; standing counts in steps of the same length."""
    hits.since[0] += 1
    if stepped or (seen.mode[0] == 0.0 and hits.since[0] * bounds.dt >= seen.period[0]):
        if hits.disturbed[0] == 0:
            for k in range(hits.first.shape[0]):
                hits.first[k] = -1
        hits.disturbed[0] = hits.since[0] = 0
    for k in range(hits.now.shape[0]):
        hits.lasting[k] = hits.lasting[k] + 1 if hits.now[k] == 1 else 0
        if hits.lasting[k] >= hits.hold[k]:
            hits.disturbed[0] = 1
            if hits.first[k] < 0:
                hits.first[k] = tick - hits.hold[k] + 1


@kernel
def watch_joints(seen: Seen, bounds: Bounds, joints: Joints, quiet: bool) -> None:
    """Peaks, shares, and steps of the torque; ``quiet`` if nothing has disturbed the robot lately."""
    undisturbed = quiet and seen.mode[0] > 0.0
    for j in range(bounds.torque.shape[0]):
        torque, speed = seen.torque[j], abs(seen.joint_velocity[j])
        joints.torque_peak[j] = max(joints.torque_peak[j], abs(torque))
        if _is_saturated(torque, bounds.torque[j]):
            joints.torque_saturated[j] += 1.0
        if undisturbed:
            joints.torque_step[j] = max(joints.torque_step[j], abs(torque - joints.torque_before[j]))
        joints.torque_before[j] = torque
        joints.velocity_peak[j] = max(joints.velocity_peak[j], speed)
        if speed > bounds.velocity[j]:
            joints.velocity_over[j] += 1.0
