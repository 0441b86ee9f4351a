"""A walk whose truth is known in closed form, and what ideal or noisy sensors would have said about it.

The base follows smooth curves, the stance sole is nailed to the ground, the swing sole is carried to its next place;
joint angles come from Newton steps, velocities from the Jacobian. No dynamics are involved.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import Matrix, Vector
from gaitsmith.dynamics import Tree, make_tree_state, point_jacobian, read_tree, sole_pose, update_dynamics
from gaitsmith.robots import Robot, load_robot
from gaitsmith.whole_body.legs import Legs, make_legs

DT = 1e-3
PERIOD, DOUBLE = 0.4, 0.06  # s: a step, and its first part with both soles loaded
HEIGHT, HALF_WIDTH, LIFT = 0.66, 0.08, 0.06  # m
_NEAR = 1e-4  # s, central differences


class Sensors(NamedTuple):
    """Standard deviations; the paper's robot of section 4.3 as the specification puts it."""

    gyro: float = 0.02
    accelerometer: float = 0.1
    bias: float = 0.1
    encoder: float = 3e-4
    step: float = 1e-4
    attitude: float = 0.005


IDEAL = Sensors(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class Walk(NamedTuple):
    """Truth, one row a tick: q, v, specific force and gyro at the IMU, sole forces."""

    robot: Robot
    tree: Tree
    legs: Legs
    q: Matrix
    v: Matrix
    accelerometer: Matrix
    gyro: Matrix
    sole_force: Matrix


def _base(t: float, speed: float, climb: float) -> tuple[Vector, Matrix]:
    """Position and rotation of the torso: forward, sway, bob, and a little of every angle."""
    w = math.pi / PERIOD
    z = HEIGHT + climb * t / (2 * PERIOD) + 0.008 * math.cos(2 * w * t)
    position = np.array([speed * t + 0.01 * math.sin(2 * w * t), 0.03 * math.sin(w * t), z])
    roll, pitch, yaw = 0.02 * math.sin(w * t), 0.03 * math.sin(2 * w * t), 0.05 * math.sin(0.7 * t)
    cr, sr, cp, sp, cy, sy = (f(a) for a in (roll, pitch, yaw) for f in (math.cos, math.sin))
    rotation = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]]) @ np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    return position, rotation @ np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])


def _sole(leg: int, t: float, speed: float, climb: float) -> Vector:
    """Leg 0 swings in odd steps, leg 1 in even ones; rest except between the double support and the touchdown."""
    step = math.floor(t / PERIOD)
    stride = 2 * PERIOD * speed
    swings = (step + leg) % 2 == 1
    count = (step + leg + 1) // 2
    places = count + (0.25 if leg == 0 else -0.25) - (1 if swings else 0)
    lifted = 0.0
    if swings:
        share = np.clip((t - step * PERIOD - DOUBLE) / (PERIOD - DOUBLE), 0.0, 1.0)
        smooth = share**3 * (10 - 15 * share + 6 * share**2)
        places += smooth
        lifted = LIFT * 64 * (share * (1 - share)) ** 3
    return np.array([stride * places, HALF_WIDTH if leg == 0 else -HALF_WIDTH, climb * places + lifted])


def _quaternion(r: Matrix) -> Vector:
    w = math.sqrt(1.0 + np.trace(r)) / 2.0
    return np.array([w, (r[2, 1] - r[1, 2]) / (4 * w), (r[0, 2] - r[2, 0]) / (4 * w), (r[1, 0] - r[0, 1]) / (4 * w)])


@functools.cache
def synthetic_walk(duration: float, speed: float = 0.4, climb: float = 0.0) -> Walk:
    """The truth of one walk of BHR-B2; ``climb`` is how much higher every foothold lies than the last of its leg."""
    robot = load_robot("bhr_b2")
    tree = read_tree(robot.model)
    legs = make_legs(robot)
    state = make_tree_state(tree)
    place, axes, jacobian = np.zeros(3), np.zeros((3, 3)), np.zeros((6, robot.model.nv))

    def rows(leg: int) -> tuple[Matrix, float]:
        """Jacobian of a sole's position and of minus its x axis' slope, and that slope."""
        body = legs.sole_body[leg]
        sole_pose(tree, state, body, legs.sole_position[leg], legs.sole_rotation[leg], place, axes)
        point_jacobian(tree, state, body, place, jacobian)
        return np.vstack([jacobian[:3], axes[0, 0] * jacobian[4] - axes[1, 0] * jacobian[3]]), axes[2, 0]

    def solve(t: float, q: Vector, v: Vector) -> None:
        """Newton steps from the last tick's joints, then the velocities that keep the soles on their curves."""
        before, now, after = (_base(t + dt, speed, climb) for dt in (-_NEAR, 0.0, _NEAR))
        q[:3], q[3:7] = now[0], _quaternion(now[1])
        spin = now[1].T @ (after[1] - before[1]) / (2 * _NEAR)
        v[:6] = *((after[0] - before[0]) / (2 * _NEAR)), spin[2, 1], spin[0, 2], spin[1, 0]
        for _ in range(10):
            update_dynamics(tree, state, q, v)
            worst = 0.0
            for leg in range(2):
                columns = 6 + legs.joints[leg]
                matrix, slope = rows(leg)
                error = np.append(_sole(leg, t, speed, climb) - place, slope)
                q[1 + columns] += np.linalg.solve(matrix[:, columns], error)
                worst = max(worst, float(np.max(np.abs(error))))
            if worst < 1e-8:
                break
        for leg in range(2):
            columns = 6 + legs.joints[leg]
            matrix = rows(leg)[0]
            moved = _sole(leg, t + _NEAR, speed, climb) - _sole(leg, t - _NEAR, speed, climb)
            wanted = np.append(moved / (2 * _NEAR), 0.0) - matrix[:, :6] @ v[:6]
            v[columns] = np.linalg.solve(matrix[:, columns], wanted)

    def imu(t: float) -> Vector:
        position, rotation = _base(t, speed, climb)
        return position + rotation @ robot.imu_position

    ticks = round(duration / DT)
    nj = len(robot.joint_names)
    walk = Walk(
        robot, tree, legs, np.zeros((ticks, 7 + nj)), np.zeros((ticks, 6 + nj)),
        np.zeros((ticks, 3)), np.zeros((ticks, 3)), np.zeros((ticks, 2)),
    )  # fmt: skip
    q = np.zeros(7 + nj)
    q[7 + legs.knee] = 0.6
    for k in range(ticks):
        t = 1e-2 + k * DT
        q[7:] += DT * walk.v[k - 1, 6:]
        solve(t, q, walk.v[k])
        walk.q[k], walk.gyro[k] = q, walk.v[k, 3:6]
        rotation = _base(t, speed, climb)[1]
        h = 1e-3
        acceleration = (imu(t + h) - 2 * imu(t) + imu(t - h)) / h**2
        walk.accelerometer[k] = rotation.T @ (acceleration - tree.gravity)
        step, phase = math.floor(t / PERIOD), t % PERIOD
        swing = 1 if step % 2 == 0 else 0
        share = np.clip(1.0 - phase / DOUBLE, 0.0, 1.0) * 0.5
        walk.sole_force[k, swing] = 400.0 * share
        walk.sole_force[k, 1 - swing] = 400.0 * (1.0 - share)
    return walk
