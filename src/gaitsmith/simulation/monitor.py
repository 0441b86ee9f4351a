"""Watches a run tick by tick, compiled: vital signs, touchdowns, torques used, limits hit, and whether it fell."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gaitsmith.compiled import Arena, IntMatrix, IntVector, Matrix, Vector, bind, kernel

if TYPE_CHECKING:
    from gaitsmith.control import Controller
    from gaitsmith.robots import Robot
    from gaitsmith.simulation.plant import Plant

MEMORY = 1500  # ticks of limits kept to explain a fall
UPRIGHT, TILTED, SANK, TOUCHED, DIVERGED = range(5)
"""What :meth:`Monitor.watch` returns; all but the first are falls."""

VITALS = ("com_velocity_x", "com_velocity_y", "hip_height", "roll", "pitch", "yaw", "torso_x", "torso_y")
"""Columns of :attr:`Monitor.vitals`; the hip height is above the stance sole."""

_MAX_TILT = math.radians(60.0)
_SATURATED = 0.999  # of the limit
_EDGE = 1e-3  # m within which the ZMP or a foothold counts as on its bound
_STOP = 5e-3  # rad within which a joint counts as on its limit
SINGLE = (
    "foothold at its reach bound",
    "foothold at its spread bound",
    "foothold at its separation bound",
    "ZMP at the edge of the left sole",
    "ZMP at the edge of the right sole",
    "friction limit of the left sole",
    "friction limit of the right sole",
    "legs touching each other",
    "whole-body QP infeasible",
    "step ended by the clock",
)


class Seen(NamedTuple):
    """What the monitor reads, shared with the controller's telemetry and the plant."""

    observed: Vector
    mode: Vector
    stance: Vector
    step_count: Vector
    command: Vector
    joint_position: Vector
    torque: Vector
    foothold: Vector
    foothold_bound: Vector
    wrench: Vector
    zmp: Vector
    qp_infeasible: Vector
    touchdowns_forced: Vector


class Bounds(NamedTuple):
    """Limits to compare with; joint order, SI units."""

    torque: Vector
    position_low: Vector
    position_high: Vector
    heel: Vector
    toe: Vector
    reach: float
    spread: float
    zmp_margin: float
    friction: float


class Kept(NamedTuple):
    """What the monitor writes.

    Attributes:
        ticks: (1,) watched so far.
        vitals: (n, 8), see :data:`VITALS`.
        touchdowns: (m, 2) tick and stance leg (0 left, 1 right) of every step that began.
        n_touchdowns: (1,).
        limits: (MEMORY, 2 nj + 10) 1 where a limit was hit; a ring over ticks.
        torque_peak: (nj,) N·m.
        torque_saturated: (nj,) ticks.
        last: step count, QP infeasibilities, forced touchdowns at the tick before.
    """

    ticks: IntVector
    vitals: Matrix
    touchdowns: IntMatrix
    n_touchdowns: IntVector
    limits: IntMatrix
    torque_peak: Vector
    torque_saturated: Vector
    last: Vector


class Watched(NamedTuple):
    """All that the monitor's kernel reads and writes."""

    seen: Seen
    bounds: Bounds
    kept: Kept


@kernel
def _limits_hit(seen: Seen, bounds: Bounds, kept: Kept, hit: IntVector) -> None:
    """Fill one row of the ring of limits."""
    nj = bounds.torque.shape[0]
    for j in range(nj):
        hit[j] = 1 if abs(seen.torque[j]) >= _SATURATED * bounds.torque[j] else 0
        q = seen.joint_position[j]
        hit[nj + j] = 1 if q < bounds.position_low[j] + _STOP or q > bounds.position_high[j] - _STOP else 0
    for k in range(2 * nj, hit.shape[0]):
        hit[k] = 0
    at = 2 * nj
    if seen.foothold_bound[0] > 0.0 and seen.mode[0] > 0.0:
        if abs(seen.foothold[0]) > bounds.reach - _EDGE:
            hit[at] = 1
        elif abs(seen.foothold[1]) > bounds.spread - _EDGE:
            hit[at + 1] = 1
        else:
            hit[at + 2] = 1
    for leg in range(2):
        normal = seen.wrench[6 * leg + 2]
        if normal > 1.0:
            x, margin = seen.zmp[2 * leg], bounds.zmp_margin + _EDGE
            if x > bounds.toe[leg] - margin or x < margin - bounds.heel[leg]:
                hit[at + 3 + leg] = 1
            sideways = math.sqrt(seen.wrench[6 * leg] ** 2 + seen.wrench[6 * leg + 1] ** 2)
            if sideways > _SATURATED * bounds.friction * normal:
                hit[at + 5 + leg] = 1
    hit[at + 7] = 1 if seen.observed[20] > 0.0 else 0
    hit[at + 8] = 1 if seen.qp_infeasible[0] > kept.last[1] else 0
    hit[at + 9] = 1 if seen.touchdowns_forced[0] > kept.last[2] else 0


@kernel
def _watch(address: int) -> int:
    """One tick; returns UPRIGHT or the kind of fall."""
    watched = bind(Watched, address)
    seen, bounds, kept = watched.seen, watched.bounds, watched.kept
    tick = kept.ticks[0]
    _limits_hit(seen, bounds, kept, kept.limits[tick % MEMORY])
    for j in range(bounds.torque.shape[0]):
        used = abs(seen.torque[j])
        kept.torque_peak[j] = max(kept.torque_peak[j], used)
        if used >= _SATURATED * bounds.torque[j]:
            kept.torque_saturated[j] += 1.0
    observed, stance = seen.observed, int(seen.stance[0])
    if tick < kept.vitals.shape[0]:
        row = kept.vitals[tick]
        row[0], row[1] = observed[0], observed[1]
        row[2] = 0.5 * (observed[9] + observed[10]) if stance > 1 else observed[9 + stance]
        row[3], row[4], row[5] = observed[6], observed[7], observed[8]
        row[6], row[7] = observed[3], observed[4]
    if seen.step_count[0] > kept.last[0] and kept.n_touchdowns[0] < kept.touchdowns.shape[0]:
        kept.touchdowns[kept.n_touchdowns[0], 0] = tick
        kept.touchdowns[kept.n_touchdowns[0], 1] = stance
        kept.n_touchdowns[0] += 1
    kept.last[0], kept.last[1], kept.last[2] = seen.step_count[0], seen.qp_infeasible[0], seen.touchdowns_forced[0]
    kept.ticks[0] = tick + 1

    if not math.cos(observed[6]) * math.cos(observed[7]) > math.cos(_MAX_TILT):
        return TILTED
    if max(observed[9], observed[10]) < 0.5 * seen.command[4]:
        return SANK
    if observed[21] > 0.0:
        return TOUCHED
    return UPRIGHT


class Monitor:
    """Watches one run.

    Args:
        robot: whose limits apply.
        controller: its telemetry is read, and the bounds of its parameters apply.
        plant: its observed values are read.
        duration: of the run, s.

    Attributes:
        vitals: (n, 8), see :data:`VITALS`; rows beyond :attr:`ticks` are not filled yet.
        limit_names: of the columns of ``kept.limits``.
    """

    def __init__(self, robot: Robot, controller: Controller, plant: Plant, duration: float) -> None:
        parameters = controller.parameters
        nj, ticks = len(robot.joint_names), math.ceil(duration / plant.control_step) + 1
        self._plant = plant
        self.control_step = plant.control_step
        self.joint_names = tuple(robot.joint_names)
        self.limit_names = (
            *(f"torque of {name} saturated" for name in robot.joint_names),
            *(f"joint limit of {name}" for name in robot.joint_names),
            *SINGLE,
        )
        telemetry = controller.telemetry
        seen = Seen(plant.observed, *(getattr(telemetry, field) for field in Seen._fields[1:]))
        bounds = Bounds(
            torque=np.asarray(robot.torque_limit),
            position_low=np.asarray(robot.position_low),
            position_high=np.asarray(robot.position_high),
            heel=np.array([leg.sole.heel for leg in robot.legs]),
            toe=np.array([leg.sole.toe for leg in robot.legs]),
            reach=parameters.foothold.reach,
            spread=parameters.foothold.spread,
            zmp_margin=parameters.contact.zmp_margin,
            friction=parameters.contact.friction,
        )
        kept = Kept(
            ticks=np.zeros(1, dtype=np.int64),
            vitals=np.empty((ticks, len(VITALS))),
            touchdowns=np.zeros((ticks // 20 + 16, 2), dtype=np.int64),
            n_touchdowns=np.zeros(1, dtype=np.int64),
            limits=np.zeros((MEMORY, len(self.limit_names)), dtype=np.int64),
            torque_peak=np.zeros(nj),
            torque_saturated=np.zeros(nj),
            last=np.zeros(3),
        )
        self._arena = Arena(Watched(seen, bounds, kept))
        for shared, given in zip(self._arena.view.seen, seen, strict=True):
            if not np.shares_memory(shared, given):
                raise TypeError("the controller's telemetry must be float64 views of one buffer")
        self.kept: Kept = self._arena.view.kept
        self._address = self._arena.address

    def watch(self) -> int:
        """Take note of the present tick; returns UPRIGHT or the kind of fall."""
        state: int = _watch(self._address)
        return DIVERGED if self._plant.diverged else state

    @property
    def ticks(self) -> int:
        """Ticks watched."""
        return int(self.kept.ticks[0])

    @property
    def touchdowns(self) -> IntMatrix:
        """(m, 2) tick and new stance leg of the steps so far."""
        return self.kept.touchdowns[: self.kept.n_touchdowns[0]]
