"""The whole-body QP (Han 2023, eqs. 17-26) in NumPy: torques and sole wrenches, accelerations eliminated."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from tests.reference.quadratic_program import minimise
from tests.reference.rigid_body import Instant

from gaitsmith.robots import Robot
from gaitsmith.robots.parameters import ControlParameters

Array = npt.NDArray[np.float64]


@dataclass
class Wishes:
    """What the tick asks for; ``stance`` lists the soles that bear the robot."""

    joint_acceleration: Array  # (nj,)
    joint_weight: Array  # (nj,)
    stance: tuple[int, ...] = (0, 1)
    swing_acceleration: Array | None = None  # (3,) relative to the hip midpoint, heading frame
    body_acceleration: Array | None = None  # (3,) CoM x, y and hip z, heading frame, on both feet
    ankle_torque: float = 0.0  # of the stance ankle


class Cost:
    """Sum of ½ w ‖A q̈ - a‖² with q̈ = free + map x, as a quadratic form in x."""

    def __init__(self, free: Array, to_acceleration: Array) -> None:
        self.free, self.map = free, to_acceleration
        n = to_acceleration.shape[1]
        self.hessian, self.gradient = np.zeros((n, n)), np.zeros(n)

    def add(self, weight: float, rows: Array, target: Array) -> None:
        image = rows @ self.map
        self.hessian += weight * image.T @ image
        self.gradient += weight * image.T @ (rows @ self.free - target)

    def pull(self, index: int | slice, weight: float, target: float | Array = 0.0) -> None:
        """Add ½ w (x - target)² of one variable, or of several."""
        diagonal = np.einsum("ii->i", self.hessian)
        diagonal[index] += weight
        self.gradient[index] -= weight * target


def sole_axes(half_width: float) -> list[int]:
    """Axes of a sole's moment: a line sole transmits none about its own axis."""
    return [0, 1, 2] if half_width > 0.0 else [1, 2]


def contact_rows(heel: float, toe: float, half_width: float, friction: float, margin: float, yaw: float) -> Array:
    """Rows R with R w ≥ 0 for a wrench w = (f, m of ``sole_axes``) in the contact frame: friction, ZMP, yaw moment."""
    x, y, z, along, across, up = np.eye(6)
    rows = [friction * z + sign * axis for axis in (x, y) for sign in (-1, 1)]
    rows += [max(toe - margin, 0.0) * z + across, max(heel - margin, 0.0) * z - across]  # ZMP x = -m_y / f_z
    rows += [yaw * z - up, yaw * z + up]
    if half_width > 0.0:
        side = max(half_width - margin, 0.0)
        return np.array([*rows, side * z - along, side * z + along])  # ZMP y = m_x / f_z
    return np.array(rows)[:, [0, 1, 2, 4, 5]]


@dataclass
class Problem:
    """½ xᵀH x + gᵀx, low ≤ x ≤ high, rows x ≥ 0; x is torques, then wrenches; q̈ = cost.free + cost.map x."""

    cost: Cost
    low: Array
    high: Array
    rows: Array


def assemble(robot: Robot, parameters: ControlParameters, now: Instant, wishes: Wishes, last_torque: Array) -> Problem:
    """Eqs. 17-26 for one tick."""
    weights, contact, attitude = parameters.weights, parameters.contact, parameters.attitude
    n_joints, nv = len(last_torque), len(now.bias)
    columns = [np.vstack([np.zeros((6, n_joints)), np.eye(n_joints)])]
    low, high, blocks = [-robot.torque_limit], [robot.torque_limit], []
    for leg in wishes.stance:
        sole = robot.legs[leg].sole
        frame, kept = now.contact_axes(leg, sole.half_width), sole_axes(sole.half_width)
        jacobian = now.soles[leg].jacobian
        columns.append(np.hstack([jacobian[:3].T @ frame, (jacobian[3:].T @ frame)[:, kept]]))
        normal = np.arange(3 + len(kept)) == 2
        low.append(np.where(normal, contact.normal_force[0], -np.inf))
        high.append(np.where(normal, contact.normal_force[1], np.inf))
        margins = contact.friction, contact.zmp_margin, contact.yaw_friction
        blocks.append(contact_rows(sole.heel, sole.toe, sole.half_width, *margins))
    to_acceleration = np.linalg.solve(now.mass_matrix, np.hstack(columns))
    cost = Cost(np.linalg.solve(now.mass_matrix, -now.bias), to_acceleration)

    for leg in wishes.stance:  # eq. 18, and the turns that the sole's shape prevents
        sole, half_width = now.soles[leg], robot.legs[leg].sole.half_width
        frame = now.contact_axes(leg, half_width)[:, sole_axes(half_width)]
        cost.add(weights.stance_linear, sole.jacobian[:3], -sole.bias[:3])
        cost.add(weights.stance_angular, frame.T @ sole.jacobian[3:], -frame.T @ sole.bias[3:])
    to_heading = now.heading.T
    if wishes.swing_acceleration is not None:  # eq. 19, relative to the hip midpoint
        swing = now.soles[1 - wishes.stance[0]]
        rows = to_heading @ (swing.jacobian[:3] - now.hip.jacobian[:3])
        drift = to_heading @ (swing.bias[:3] - now.hip.bias[:3])
        cost.add(weights.swing_foot, rows, wishes.swing_acceleration - drift)
        cost.pull(robot.legs[wishes.stance[0]].ankle_pitch, weights.ankle_torque, wishes.ankle_torque)
    stiffness = np.array([attitude.roll_stiffness, attitude.pitch_stiffness])
    damping = np.array([attitude.roll_damping, attitude.pitch_damping])
    spring = -stiffness * now.tilt - damping * now.turning[:2]  # eq. 21
    drift = (to_heading @ now.hip.bias[3:])[:2]
    cost.add(weights.attitude, (to_heading @ now.hip.jacobian[3:])[:2], spring - drift)
    for joint in range(n_joints):  # eq. 22
        cost.add(wishes.joint_weight[joint], np.eye(nv)[[6 + joint]], wishes.joint_acceleration[[joint]])
    if wishes.body_acceleration is not None:
        rows = np.vstack([(to_heading @ now.com.jacobian[:3])[:2], now.hip.jacobian[2]])
        drift = np.array([*(to_heading @ now.com.bias[:3])[:2], now.hip.bias[2]])
        cost.add(parameters.standing.weight, rows, wishes.body_acceleration - drift)
    cost.pull(slice(0, n_joints), weights.torque_change, last_torque)  # eq. 24
    cost.pull(slice(None), weights.regularisation)
    return Problem(cost, np.concatenate(low), np.concatenate(high), _stack(blocks, n_joints))


def _stack(blocks: list[Array], n_joints: int) -> Array:
    """Contact rows of all soles, over all variables."""
    n, m = n_joints + sum(block.shape[1] for block in blocks), sum(len(block) for block in blocks)
    rows, top, left = np.zeros((m, n)), 0, n_joints
    for block in blocks:
        rows[top : top + len(block), left : left + block.shape[1]] = block
        top, left = top + len(block), left + block.shape[1]
    return rows


def solve_whole_body(
    robot: Robot, parameters: ControlParameters, now: Instant, wishes: Wishes, last_torque: Array
) -> tuple[Array, Array]:
    """Torques (nj,) and accelerations (nv,) that follow the wishes best."""
    problem = assemble(robot, parameters, now, wishes, last_torque)
    cost = problem.cost
    rows_low = np.zeros(len(problem.rows))
    solution = minimise(cost.hessian, cost.gradient, problem.low, problem.high, problem.rows, rows_low)
    return solution[: len(last_torque)], cost.free + cost.map @ solution
