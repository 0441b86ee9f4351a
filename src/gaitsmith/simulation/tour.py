"""The public teleoperation test of walking: waypoints, punches and the arms' walk, all named by a run id.

As https://github.com/rhoyn/teleop-walking-benchmark (2026) describes it: 90 s, a waypoint every 5 s, a punch soon after
each, arms that never rest. Streams of random numbers are drawn in the same sequence as there.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import mujoco
import numpy as np
import numpy.typing as npt

from gaitsmith.simulation.disturbances import Push
from gaitsmith.simulation.loop import Observer, Order
from gaitsmith.simulation.random_stream import RandomStream
from gaitsmith.simulation.summary import TourReport

if TYPE_CHECKING:
    from gaitsmith.control import Controller
    from gaitsmith.robots import Robot
    from gaitsmith.simulation.plant import Plant
    from gaitsmith.simulation.scenario import Tour

LENGTH, SEGMENT = 90.0, 5.0  # s
_WAYPOINTS = round(LENGTH / SEGMENT)
_CENTRE, _RADIUS = 0.3, 1.0  # m ahead of the start, and of the disc of waypoints
_WALK, _PUNCH, _ARMS = 2, 3, 4  # streams of a run id
_PERIOD = 0.02  # s from one command to the next
_GAIN = 1.5  # 1/s, on position and on heading
_REACHED, _LEFT_AGAIN = np.array([0.02, 0.03]), np.array([0.04, 0.08])  # m, rad; of these every controller has its own
_FORCE, _FLOOR, _RAMP = 500.0, 1.0 / 3.0, 60.0  # N; share of it at first; s until all of it
_DELAY, _DURATION = 0.1, 0.08  # s
_ARM_STEP, _ARM_PERIOD, _ARM_DRAWS = 0.06, 0.5, 8  # rad, s, tries
_ARM_TICKS = round(_ARM_PERIOD / _PERIOD)
_TURN = 2.0 * math.pi


class Waypoint(NamedTuple):
    """A place and a heading, m and rad, seen from where the walk begins."""

    x: float
    y: float
    yaw: float


def waypoints(run_id: int) -> list[Waypoint]:
    """Where a run leads."""
    stream, found = RandomStream(run_id, _WALK), []
    for _ in range(_WAYPOINTS):
        radius, bearing, yaw = stream.uniform(0.0, 1.0, 3).tolist()
        radius, bearing = _RADIUS * math.sqrt(radius), _TURN * bearing
        place = (_CENTRE + radius * math.cos(bearing), radius * math.sin(bearing))
        found.append(Waypoint(*place, math.remainder(_TURN * yaw, _TURN)))
    return found


def punches(run_id: int, robot: Robot, begin: float, factor: float = 1.0) -> tuple[Push, ...]:
    """The punches of a run, each on a joint's body at the joint's anchor.

    Args:
        begin: of the walk, s.
        factor: on every force; 0 for none.
    """
    stream, found = RandomStream(run_id, _PUNCH), []
    for k in range(_WAYPOINTS):
        joint = stream.below(len(robot.joint_names))
        z, phi, share = stream.uniform(0.0, 1.0, 3).tolist()
        z, phi, share = 2.0 * z - 1.0, _TURN * phi, 0.5 + 0.5 * share
        flat = math.sqrt(max(0.0, 1.0 - z * z))
        ceiling = _FORCE * (_FLOOR + (1.0 - _FLOOR) * min(SEGMENT * k / _RAMP, 1.0))
        size = factor * ceiling * share * _DURATION
        impulse = (size * flat * math.cos(phi), size * flat * math.sin(phi), size * z)
        time = begin + _DELAY + SEGMENT * k
        found.append(Push(time=time, impulse=impulse, duration=_DURATION, joint=robot.joint_names[joint]))
    return tuple(found) if factor else ()


class ArmWalk:
    """Random walk of a pair of arms, the right one the mirror image of the left.

    Arms are the joints outside the legs that have a mirror image on the other side. Hands stay ahead of where they
    were at first, and below the shoulders.

    Args:
        robot: with or without arms.
        home: (nj,) first posture, rad.
    """

    def __init__(self, robot: Robot, run_id: int, home: npt.NDArray[np.float64]) -> None:
        self._stream, self._model, self._data = RandomStream(run_id, _ARMS), robot.model, mujoco.MjData(robot.model)
        self._left, self._right, self._sign = _arms(robot, self._data)
        self._names = robot.joint_names
        ends = np.stack([robot.position_low, robot.position_high])
        image = np.sort(self._sign * ends[:, self._right], axis=0)
        self._low, self._high = np.maximum(ends[0, self._left], image[0]), np.minimum(ends[1, self._left], image[1])
        self._now = np.asarray(home)[self._left]
        self._from = self._to = self._now
        self._window = -1
        self._data.qpos[7:] = home
        self._front = self._hands(self._now)[0]

    def posture(self, elapsed: float) -> dict[str, float]:
        """Angles of the arms' joints at a time since the walk began, s; rad."""
        if not len(self._left):
            return {}
        window = int(elapsed / _ARM_PERIOD)
        if window != self._window:
            self._window, self._from, self._to = window, self._now, self._next()
        phase = min((elapsed - window * _ARM_PERIOD + _PERIOD) / _ARM_PERIOD, 1.0)
        self._now = np.clip(self._from + (self._to - self._from) * phase, self._low, self._high)
        names = [self._names[joint] for joint in (*self._left, *self._right)]
        return dict(zip(names, [*self._now.tolist(), *(self._sign * self._now).tolist()], strict=True))

    def _next(self) -> npt.NDArray[np.float64]:
        """Where to go next; where it is already if all tries leave the hands' space."""
        for _ in range(_ARM_DRAWS):
            wanted = self._now
            for step in self._stream.uniform(-1.0, 1.0, _ARM_TICKS * len(wanted)).reshape(_ARM_TICKS, -1):
                wanted = np.clip(wanted + _ARM_STEP * step, self._low, self._high)
            front, above = self._hands(wanted)
            if front >= self._front and above <= 0.0:
                return wanted
        return self._now

    def _hands(self, left: npt.NDArray[np.float64]) -> tuple[float, float]:
        """Of the last bodies' centres in the trunk's frame: the least x, and the largest height above the shoulders."""
        if not len(left):
            return 0.0, 0.0
        model, data = self._model, self._data
        data.qpos[7 + self._left], data.qpos[7 + self._right] = left, self._sign * left
        mujoco.mj_kinematics(model, data)
        shoulder = int(model.jnt_bodyid[self._left[0] + 1])
        trunk = int(model.body_parentid[shoulder])
        hands = model.jnt_bodyid[[self._left[-1] + 1, self._right[-1] + 1]]
        seen = (data.xipos[hands] - data.xpos[shoulder]) @ data.xmat[trunk].reshape(3, 3)
        return float(seen[:, 0].min()), float(seen[:, 2].max())


def _arms(robot: Robot, data: mujoco.MjData) -> tuple[npt.NDArray[np.int64], ...]:
    """Joints of the left arm, their partners, and the partners' signs."""
    data.qpos[:7] = 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0
    mujoco.mj_kinematics(robot.model, data)
    legs = {int(joint) for leg in robot.legs for joint in leg.joint_indices}
    others = [joint for joint in range(len(robot.joint_names)) if joint not in legs]
    near = 1e-2 * float(np.ptp(data.xpos[1:, 2]))
    anchors, axes = data.xanchor[1:], data.xaxis[1:]
    found = []
    for one in others:
        for two in others:
            alike = np.abs(anchors[one] * (1.0, -1.0, 1.0) - anchors[two]).max() < near
            along = float(axes[one] * (-1.0, 1.0, -1.0) @ axes[two])
            if anchors[one, 1] > near and alike and abs(along) > 0.99:
                found.append((one, two, round(along)))
                break
    left, right, sign = np.array(found, dtype=np.int64).reshape(-1, 3).T
    return left, right, sign


class Guide(Observer):
    """Leads a robot through a tour: a source of commands, and an observer that keeps the score.

    Args:
        plant: with the robot; its true place and heading are known to the guide.
        begin: of the walk, s.
    """

    def __init__(self, tour: Tour, plant: Plant, controller: Controller, begin: float) -> None:
        self._tour, self._plant, self._controller, self._begin = tour, plant, controller, begin
        self._waypoints = waypoints(tour.id)
        self._arms = ArmWalk(controller.robot, tour.id, plant.q[7:].copy())
        self._asked = 0  # commands so far
        self._start = np.zeros(3)
        self._index, self._reached = -1, np.zeros(2, dtype=bool)
        self._error, self._errors = np.zeros(2), list[npt.NDArray[np.float64]]()
        self._energy = 0.0

    def poll(self, time: float) -> list[Order]:
        """The next command, 50 times a second."""
        elapsed = self._asked * _PERIOD
        if time < self._begin + elapsed - 0.5 * self._plant.control_step:
            return []
        first, self._asked = self._asked == 0, self._asked + 1
        command, posture = self._command(elapsed), self._arms.posture(elapsed)
        return [Order(command, "walk" if first else "", first, posture)]

    def _command(self, elapsed: float) -> dict[str, Any]:
        """Speed and yaw rate towards the waypoint of a time since the walk began, s."""
        truth, limits = self._plant.truth, self._tour
        pose = np.array([truth.torso[0], truth.torso[1], truth.attitude[2]])
        if self._asked == 1:
            self._start = pose
        index = min(int(elapsed / SEGMENT + 1e-9), _WAYPOINTS - 1)
        if index != self._index:
            if self._index >= 0:
                self._errors.append(self._error)
            self._index, self._reached = index, np.zeros(2, dtype=bool)
        x, y, yaw = self._waypoints[index]
        away = self._start[:2] + _rotated((x, y), self._start[2]) - pose[:2]
        turn = math.remainder(self._start[2] + yaw - pose[2], _TURN)
        self._error = np.array([math.hypot(*away), abs(turn)])
        self._reached = self._error < np.where(self._reached, _LEFT_AGAIN, _REACHED)
        speed = np.zeros(2) if self._reached[0] else _GAIN * _rotated(away, -pose[2])
        ahead, side = np.clip(speed, *np.outer((-1.0, 1.0), (limits.forward, limits.lateral))).tolist()
        rate = 0.0 if self._reached[1] else min(max(_GAIN * turn, -limits.yaw_rate), limits.yaw_rate)
        # Turning and stepping sideways at once brings the feet together: neither quite at its limit then.
        both = ((side / limits.lateral) ** 6 + (rate / limits.yaw_rate if rate else 0.0) ** 6) ** (1.0 / 6.0)
        return {"speed": (ahead, side / max(both, 1.0)), "yaw_rate": rate / max(both, 1.0)}

    def observe(self, tick: int) -> bool:
        """Count the mechanical work of the joints; never ends the run."""
        if self._asked:
            power = self._controller.telemetry.torque * self._plant.v[6:]
            self._energy += float(np.abs(power).sum()) * self._plant.control_step
        return False

    def report(self) -> TourReport:
        """The score so far; the waypoint that the robot is on its way to counts with its present error."""
        errors = np.array([*self._errors, self._error] if self._asked else np.zeros((0, 2))).reshape(-1, 2)
        yaw = np.degrees(errors[:, 1]).tolist()
        return TourReport(position_error=tuple(errors[:, 0].tolist()), yaw_error_deg=tuple(yaw), energy=self._energy)


def _rotated(vector: Any, angle: float) -> npt.NDArray[np.float64]:
    """A vector (2,) turned by an angle, rad."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])
