"""Whole-body QP (Han 2023, eqs. 17-26): joint torques and sole wrenches that follow the tasks best.

The accelerations are eliminated through the dynamics, ``q̈ = M⁻¹(Sᵀτ + Jᵀλ - h)``, so the variables are the joint
torques and one local wrench per sole in contact, and every bound is a bound on the variables alone: the problem
always has a solution. A line sole transmits no moment about its own axis; that variable is left out.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import IntVector, Matrix, Vector, kernel
from gaitsmith.control.frames import Frames, Legs
from gaitsmith.control.quadratic_program import QuadraticProgram, solve
from gaitsmith.dynamics.linear_algebra import cholesky, cholesky_solve_matrix
from gaitsmith.dynamics.tree import TreeState
from gaitsmith.robots.parameters import ControlParameters

_CONTACT_ROWS = 10  # friction 4, ZMP along 2, ZMP across 2, yaw moment 2
_ITERATIONS = 60


class TaskGains(NamedTuple):
    """Weights and bounds of a preset as a kernel reads them."""

    stance_linear: float
    stance_angular: float
    swing_foot: float
    attitude: float
    knee: float
    swing_joint: float
    swing_ankle: float
    other_joint: float
    ankle_torque: float
    torque_change: float
    regularisation: float
    standing: float
    friction: float
    normal_low: float
    normal_high: float
    zmp_margin: float
    yaw_friction: float
    roll_stiffness: float
    roll_damping: float
    pitch_stiffness: float
    pitch_damping: float


class Targets(NamedTuple):
    """What the tick asks of the whole body.

    Attributes:
        in_contact: (2,) 1 for a sole that bears the robot.
        swing_acceleration: (2, 3) of each sole relative to the hip midpoint, heading frame, m/s².
        joint_acceleration: (nj,) rad/s².
        joint_weight: (nj,) cost of each joint's acceleration error.
        body_acceleration: (3,) CoM forward and lateral and hip vertical, heading frame, used on both feet, m/s².
        ankle_torque: (2,) soft target of each ankle pitch torque, N·m.
        torque_limit: (nj,) N·m.
    """

    in_contact: IntVector
    swing_acceleration: Matrix
    joint_acceleration: Vector
    joint_weight: Vector
    body_acceleration: Vector
    ankle_torque: Vector
    torque_limit: Vector


class WholeBody(NamedTuple):
    """Result and scratch of the whole-body QP.

    Attributes:
        torque: (nj,) N·m, the last accepted solution.
        wrench: (2, 6) force and moment on each sole, world axes, N and N·m; 0 for a sole in the air.
        acceleration: (nv,) that the solution predicts.
        counts: (4,) solves, fallbacks, infeasible, consecutive fallbacks.
        status: (2,) status and iterations of the last solve.
        factor: (nv, nv) Cholesky factor of M.
        map: (nv, nj + 13) accelerations per unit of each variable; the last column is scratch.
        free: (nv,) accelerations with all variables zero.
        row: (nv,) one task's Jacobian.
        image: (nj + 12,) the same in terms of the variables.
        contact: (2,) contacts of the last solve, to know when the active set no longer applies.
    """

    torque: Vector
    wrench: Matrix
    acceleration: Vector
    counts: IntVector
    status: IntVector
    factor: Matrix
    map: Matrix
    free: Vector
    row: Vector
    image: Vector
    contact: IntVector


def make_task_gains(parameters: ControlParameters) -> TaskGains:
    """Kernel form of a preset's weights, contact bounds and attitude gains."""
    weights, contact, attitude = parameters.weights, parameters.contact, parameters.attitude
    return TaskGains(
        weights.stance_linear,
        weights.stance_angular,
        weights.swing_foot,
        weights.attitude,
        weights.knee,
        weights.swing_joint,
        weights.swing_ankle,
        weights.other_joint,
        weights.ankle_torque,
        weights.torque_change,
        weights.regularisation,
        parameters.standing.weight,
        contact.friction,
        contact.normal_force[0],
        contact.normal_force[1],
        contact.zmp_margin,
        contact.yaw_friction,
        attitude.roll_stiffness,
        attitude.roll_damping,
        attitude.pitch_stiffness,
        attitude.pitch_damping,
    )


def make_targets(torque_limit: Vector) -> Targets:
    """Targets of a robot standing still."""
    n_joints = len(torque_limit)
    return Targets(
        in_contact=np.ones(2, dtype=np.int64),
        swing_acceleration=np.zeros((2, 3)),
        joint_acceleration=np.zeros(n_joints),
        joint_weight=np.zeros(n_joints),
        body_acceleration=np.zeros(3),
        ankle_torque=np.zeros(2),
        torque_limit=np.array(torque_limit, dtype=np.float64),
    )


def make_whole_body(nv: int, n_joints: int) -> WholeBody:
    """Storage for a robot with ``nv`` degrees of freedom and ``n_joints`` joints."""
    n = n_joints + 12
    return WholeBody(
        torque=np.zeros(n_joints),
        wrench=np.zeros((2, 6)),
        acceleration=np.zeros(nv),
        counts=np.zeros(4, dtype=np.int64),
        status=np.zeros(2, dtype=np.int64),
        factor=np.zeros((nv, nv)),
        map=np.zeros((nv, n + 1)),
        free=np.zeros(nv),
        row=np.zeros(nv),
        image=np.zeros(n),
        contact=np.zeros(2, dtype=np.int64),
    )


def problem_size(n_joints: int) -> tuple[int, int]:
    """Largest number of variables and of rows of the QP."""
    return n_joints + 12, 2 * _CONTACT_ROWS


@kernel
def wrench_size(half_width: float) -> int:
    """Number of wrench variables of a sole: a line sole has no moment about its axis."""
    return 6 if half_width > 0.0 else 5


@kernel
def _moment_axis(half_width: float, index: int) -> int:
    """Axis of the ``index``-th moment variable."""
    return index if half_width > 0.0 else index + 1


@kernel
def _fill_map(state: TreeState, legs: Legs, targets: Targets, frames: Frames, body: WholeBody) -> int:
    """Fill ``map`` and ``free``; returns the number of variables, or -1 if M is not positive definite."""
    nv = body.free.shape[0]
    n_joints = body.torque.shape[0]
    n = n_joints
    for i in range(nv):
        for j in range(n_joints):
            body.map[i, j] = 0.0
    for j in range(n_joints):
        body.map[6 + j, j] = 1.0
    for leg in range(2):
        if targets.in_contact[leg] == 0:
            continue
        axes = frames.contact_rotation[leg]
        jacobian = frames.sole_jacobian[leg]
        for variable in range(wrench_size(legs.half_width[leg])):
            first, axis = 0, variable
            if variable >= 3:
                first, axis = 3, _moment_axis(legs.half_width[leg], variable - 3)
            for k in range(nv):
                body.map[k, n] = (
                    axes[0, axis] * jacobian[first, k]
                    + axes[1, axis] * jacobian[first + 1, k]
                    + axes[2, axis] * jacobian[first + 2, k]
                )
            n += 1
    for k in range(nv):
        body.map[k, n] = -state.bias[k]
    if not cholesky(state.mass_matrix, body.factor, nv):
        return -1
    cholesky_solve_matrix(body.factor, body.map, nv, n + 1)
    for k in range(nv):
        body.free[k] = body.map[k, n]
    return n


@kernel
def _add_row(qp: QuadraticProgram, body: WholeBody, n: int, target: float, weight: float) -> None:
    """Add ``weight (row q̈ - target)²`` to the cost (lower triangle of the Hessian)."""
    nv = body.row.shape[0]
    error = -target
    for j in range(n):
        body.image[j] = 0.0
    for k in range(nv):
        value = body.row[k]
        if value != 0.0:
            error += value * body.free[k]
            for j in range(n):
                body.image[j] += value * body.map[k, j]
    for i in range(n):
        scaled = weight * body.image[i]
        qp.gradient[i] += scaled * error
        for j in range(i + 1):
            qp.hessian[i, j] += scaled * body.image[j]


@kernel
def _add_joint(qp: QuadraticProgram, body: WholeBody, n: int, dof: int, target: float, weight: float) -> None:
    """The same for the acceleration of one degree of freedom."""
    error = body.free[dof] - target
    for i in range(n):
        scaled = weight * body.map[dof, i]
        qp.gradient[i] += scaled * error
        for j in range(i + 1):
            qp.hessian[i, j] += scaled * body.map[dof, j]


@kernel
def _stance_cost(
    qp: QuadraticProgram, legs: Legs, frames: Frames, gains: TaskGains, body: WholeBody, n: int, leg: int
) -> None:
    """A stance sole does not accelerate (eq. 18), neither does it turn, except about a line sole's own axis."""
    nv = body.row.shape[0]
    jacobian, bias, axes = frames.sole_jacobian[leg], frames.sole_bias[leg], frames.contact_rotation[leg]
    for axis in range(3):
        for k in range(nv):
            body.row[k] = jacobian[axis, k]
        _add_row(qp, body, n, -bias[axis], gains.stance_linear)
    for variable in range(wrench_size(legs.half_width[leg]) - 3):
        axis = _moment_axis(legs.half_width[leg], variable)
        for k in range(nv):
            body.row[k] = (
                axes[0, axis] * jacobian[3, k] + axes[1, axis] * jacobian[4, k] + axes[2, axis] * jacobian[5, k]
            )
        drift = axes[0, axis] * bias[3] + axes[1, axis] * bias[4] + axes[2, axis] * bias[5]
        _add_row(qp, body, n, -drift, gains.stance_angular)


@kernel
def _heading_row(jacobian: Matrix, first: int, axis: int, heading: Vector, out: Vector) -> None:
    """Row of a world-axes Jacobian along heading axis ``axis``."""
    cos_yaw, sin_yaw = heading[1], heading[2]
    for k in range(out.shape[0]):
        if axis == 0:
            out[k] = cos_yaw * jacobian[first, k] + sin_yaw * jacobian[first + 1, k]
        elif axis == 1:
            out[k] = cos_yaw * jacobian[first + 1, k] - sin_yaw * jacobian[first, k]
        else:
            out[k] = jacobian[first + 2, k]


@kernel
def _heading_component(vector: Vector, first: int, axis: int, heading: Vector) -> float:
    """Component of a world vector along heading axis ``axis``."""
    if axis == 0:
        return heading[1] * vector[first] + heading[2] * vector[first + 1]
    if axis == 1:
        return heading[1] * vector[first + 1] - heading[2] * vector[first]
    return vector[first + 2]


@kernel
def _swing_cost(
    qp: QuadraticProgram, targets: Targets, frames: Frames, gains: TaskGains, body: WholeBody, n: int, leg: int
) -> None:
    """The swing sole follows its acceleration relative to the hip midpoint (eq. 19)."""
    nv = body.row.shape[0]
    jacobian, bias = frames.sole_jacobian[leg], frames.sole_bias[leg]
    for axis in range(3):
        _heading_row(frames.hip_jacobian, 0, axis, frames.heading, body.row)
        for k in range(nv):
            body.row[k] = -body.row[k]
            if axis == 0:
                body.row[k] += frames.heading[1] * jacobian[0, k] + frames.heading[2] * jacobian[1, k]
            elif axis == 1:
                body.row[k] += frames.heading[1] * jacobian[1, k] - frames.heading[2] * jacobian[0, k]
            else:
                body.row[k] += jacobian[2, k]
        drift = _heading_component(bias, 0, axis, frames.heading) - _heading_component(
            frames.hip_bias, 0, axis, frames.heading
        )
        _add_row(qp, body, n, targets.swing_acceleration[leg, axis] - drift, gains.swing_foot)


@kernel
def _attitude_cost(qp: QuadraticProgram, frames: Frames, gains: TaskGains, body: WholeBody, n: int) -> None:
    """Torso roll and pitch behave like spring and damper (eqs. 21 and 22)."""
    for axis in range(2):
        stiffness = gains.roll_stiffness if axis == 0 else gains.pitch_stiffness
        damping = gains.roll_damping if axis == 0 else gains.pitch_damping
        _heading_row(frames.hip_jacobian, 3, axis, frames.heading, body.row)
        drift = _heading_component(frames.hip_bias, 3, axis, frames.heading)
        target = -stiffness * frames.tilt[axis] - damping * frames.tilt[2 + axis] - drift
        _add_row(qp, body, n, target, gains.attitude)


@kernel
def _standing_cost(
    qp: QuadraticProgram,
    state: TreeState,
    targets: Targets,
    frames: Frames,
    gains: TaskGains,
    body: WholeBody,
    n: int,
) -> None:
    """On both feet: CoM over the soles, hip midpoint at its height."""
    for axis in range(3):
        if axis < 2:
            _heading_row(state.com_jacobian, 0, axis, frames.heading, body.row)
            drift = _heading_component(state.com_bias, 0, axis, frames.heading)
        else:
            _heading_row(frames.hip_jacobian, 0, axis, frames.heading, body.row)
            drift = frames.hip_bias[2]
        _add_row(qp, body, n, targets.body_acceleration[axis] - drift, gains.standing)


@kernel
def _new_row(qp: QuadraticProgram, m: int) -> int:
    """Clear row ``m`` and make it ``row · x ≥ 0``; the caller fills the coefficients."""
    for j in range(qp.rows.shape[1]):
        qp.rows[m, j] = 0.0
    qp.row_lower[m] = 0.0
    qp.row_upper[m] = math.inf
    return m + 1


@kernel
def _contact_bounds(qp: QuadraticProgram, legs: Legs, gains: TaskGains, leg: int, first: int, row: int) -> int:
    """Friction pyramid, ZMP (eq. 26) and yaw moment of one sole; returns the next free row.

    In the contact frame the ZMP is at ``x = -m_y / f_z`` and ``y = m_x / f_z``.
    """
    m = row
    qp.lower[first + 2] = gains.normal_low
    qp.upper[first + 2] = gains.normal_high
    for axis in range(2):
        for sign in (-1.0, 1.0):
            m = _new_row(qp, m)
            qp.rows[m - 1, first + 2] = gains.friction
            qp.rows[m - 1, first + axis] = sign
    size = wrench_size(legs.half_width[leg])
    pitch = first + size - 2
    yaw = first + size - 1
    m = _new_row(qp, m)
    qp.rows[m - 1, first + 2] = max(legs.toe[leg] - gains.zmp_margin, 0.0)
    qp.rows[m - 1, pitch] = 1.0
    m = _new_row(qp, m)
    qp.rows[m - 1, first + 2] = max(legs.heel[leg] - gains.zmp_margin, 0.0)
    qp.rows[m - 1, pitch] = -1.0
    for sign in (-1.0, 1.0):
        m = _new_row(qp, m)
        qp.rows[m - 1, first + 2] = gains.yaw_friction
        qp.rows[m - 1, yaw] = sign
    if size == 6:
        for sign in (-1.0, 1.0):
            m = _new_row(qp, m)
            qp.rows[m - 1, first + 2] = max(legs.half_width[leg] - gains.zmp_margin, 0.0)
            qp.rows[m - 1, first + 3] = sign
    return m


@kernel
def _assemble(
    qp: QuadraticProgram,
    state: TreeState,
    legs: Legs,
    targets: Targets,
    frames: Frames,
    gains: TaskGains,
    body: WholeBody,
    n: int,
) -> None:
    """Cost and bounds of the tick's QP."""
    n_joints = body.torque.shape[0]
    for i in range(n):
        qp.gradient[i] = 0.0
        qp.lower[i] = -math.inf
        qp.upper[i] = math.inf
        for j in range(i + 1):
            qp.hessian[i, j] = 0.0
    for j in range(n_joints):
        qp.lower[j] = -targets.torque_limit[j]
        qp.upper[j] = targets.torque_limit[j]
        if targets.joint_weight[j] > 0.0:
            _add_joint(qp, body, n, 6 + j, targets.joint_acceleration[j], targets.joint_weight[j])
        qp.hessian[j, j] += gains.torque_change
        qp.gradient[j] -= gains.torque_change * body.torque[j]
    first, m = n_joints, 0
    for leg in range(2):
        if targets.in_contact[leg] == 1:
            _stance_cost(qp, legs, frames, gains, body, n, leg)
            m = _contact_bounds(qp, legs, gains, leg, first, m)
            first += wrench_size(legs.half_width[leg])
            ankle = legs.ankle_pitch[leg]
            qp.hessian[ankle, ankle] += gains.ankle_torque
            qp.gradient[ankle] -= gains.ankle_torque * targets.ankle_torque[leg]
        else:
            _swing_cost(qp, targets, frames, gains, body, n, leg)
    _attitude_cost(qp, frames, gains, body, n)
    if targets.in_contact[0] + targets.in_contact[1] == 2:
        _standing_cost(qp, state, targets, frames, gains, body, n)
    for i in range(n):
        qp.hessian[i, i] += gains.regularisation
        for j in range(i):
            qp.hessian[j, i] = qp.hessian[i, j]
    qp.size[0] = n
    qp.size[1] = m


@kernel
def _accept(qp: QuadraticProgram, legs: Legs, targets: Targets, frames: Frames, body: WholeBody, n: int) -> None:
    """Copy the solution into torque, world wrenches and predicted accelerations."""
    nv = body.free.shape[0]
    n_joints = body.torque.shape[0]
    for j in range(n_joints):
        body.torque[j] = qp.solution[j]
    for k in range(nv):
        body.acceleration[k] = body.free[k]
        for j in range(n):
            body.acceleration[k] += body.map[k, j] * qp.solution[j]
    first = n_joints
    for leg in range(2):
        for i in range(6):
            body.wrench[leg, i] = 0.0
        if targets.in_contact[leg] == 0:
            continue
        size = wrench_size(legs.half_width[leg])
        for variable in range(size):
            base, axis = 0, variable
            if variable >= 3:
                base, axis = 3, _moment_axis(legs.half_width[leg], variable - 3)
            for i in range(3):
                body.wrench[leg, base + i] += frames.contact_rotation[leg, i, axis] * qp.solution[first + variable]
        first += size


@kernel
def solve_whole_body(
    qp: QuadraticProgram,
    state: TreeState,
    legs: Legs,
    targets: Targets,
    frames: Frames,
    gains: TaskGains,
    body: WholeBody,
) -> bool:
    """Solve eq. 25 for this tick; on failure ``body.torque`` keeps the last accepted solution.

    Returns:
        True if the QP was solved. ``body.counts`` and ``body.status`` say what happened.
    """
    body.counts[0] += 1
    for leg in range(2):
        if body.contact[leg] != targets.in_contact[leg]:
            for i in range(qp.active.shape[0]):
                qp.active[i] = 0
        body.contact[leg] = targets.in_contact[leg]
    n = _fill_map(state, legs, targets, frames, body)
    if n < 0:
        body.status[0], body.status[1] = 3, 0
    else:
        _assemble(qp, state, legs, targets, frames, gains, body, n)
        body.status[0], body.status[1] = solve(qp, _ITERATIONS)
        if body.status[0] == 0:
            _accept(qp, legs, targets, frames, body, n)
            body.counts[3] = 0
            return True
    body.counts[1] += 1
    body.counts[3] += 1
    if body.status[0] == 1:
        body.counts[2] += 1
    return False
