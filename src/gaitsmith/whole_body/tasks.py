"""Cost of the whole-body QP (Han 2023, eqs. 18-23), one function a task.

Every task is a row of accelerations ``row q̈`` with a target and a weight. Targets follow the reference like a spring
and a damper.
"""

from __future__ import annotations

from typing import NamedTuple

from gaitsmith.compiled import Matrix, Vector, kernel
from gaitsmith.whole_body.contact import PITCH_MOMENT, ROLL_MOMENT, transmits
from gaitsmith.whole_body.forward_dynamics import add_joint, add_row
from gaitsmith.whole_body.frames import Frames
from gaitsmith.whole_body.problem import WholeBody
from gaitsmith.whole_body.reference import FLAT, HIPS, NONE


class Task(NamedTuple):
    """One row of the table of tasks: weight, 1/(unit of the row)²; stiffness, 1/s²; damping, 1/s."""

    weight: float
    stiffness: float
    damping: float


class TaskTable(NamedTuple):
    """All tasks, as one way of moving uses them.

    Attributes:
        stance: a bearing sole's pivot does not accelerate (eq. 18).
        stance_turn: neither does the sole turn, but about its line or edge.
        swing: a sole in the air follows its reference (eqs. 19 and 20).
        swing_turn: the same for its rotation, and for that of a sole about its edge.
        roll, pitch, yaw: of the torso, about the heading axes (eqs. 21 and 22).
        com: horizontal motion of the centre of mass.
        com_height: its vertical motion.
        hip_height: of the hip midpoint.
        leg_joint: joints of the legs (eqs. 22 and 23); the reference's share is the weight.
        posture: joints outside the legs.
        cop: cost on the distance of the centre of pressure from its target times the force, (N·m)⁻².
        load: cost on a sole's normal force, N⁻².
        torque_change: cost on the change of torque (eq. 24), (N·m)⁻².
        regularisation: cost on all variables.
    """

    stance: Task
    stance_turn: Task
    swing: Task
    swing_turn: Task
    roll: Task
    pitch: Task
    yaw: Task
    com: Task
    com_height: Task
    hip_height: Task
    leg_joint: Task
    posture: Task
    cop: float
    load: float
    torque_change: float
    regularisation: float


@kernel
def turn_error(actual: Matrix, wanted: Matrix, out: Vector) -> None:
    """Turn (rad for small ones) that brings one rotation to another, world axes."""
    out[0] = out[1] = out[2] = 0.0
    for j in range(3):
        out[0] += 0.5 * (actual[1, j] * wanted[2, j] - actual[2, j] * wanted[1, j])
        out[1] += 0.5 * (actual[2, j] * wanted[0, j] - actual[0, j] * wanted[2, j])
        out[2] += 0.5 * (actual[0, j] * wanted[1, j] - actual[1, j] * wanted[0, j])


@kernel
def _heading_axis(frames: Frames, axis: int) -> tuple[float, float, float]:
    """A heading axis in the world."""
    if axis == 0:
        return frames.cos_yaw[0], frames.sin_yaw[0], 0.0
    if axis == 1:
        return -frames.sin_yaw[0], frames.cos_yaw[0], 0.0
    return 0.0, 0.0, 1.0


@kernel
def _along(axis: tuple[float, float, float], vector: Vector, first: int) -> float:
    """Component of a world vector, three entries from ``first``."""
    return float(axis[0] * vector[first] + axis[1] * vector[first + 1] + axis[2] * vector[first + 2])


@kernel
def _row_along(axis: tuple[float, float, float], jacobian: Matrix, first: int, row: Vector) -> None:
    """The same of a world-axes Jacobian: one row, into ``row``."""
    x, y, z = axis
    for k in range(jacobian.shape[1]):
        row[k] = x * jacobian[first, k] + y * jacobian[first + 1, k] + z * jacobian[first + 2, k]


@kernel
def add_stance(g: WholeBody, tasks: TaskTable, leg: int) -> None:
    """A bearing sole's pivot does not accelerate, neither does the sole turn, but about its line or edge."""
    contacts, motion = g.contacts, g.motion
    jacobian, bias, axes = contacts.jacobian[leg], contacts.bias[leg], contacts.axes[leg]
    nv = jacobian.shape[1]
    for axis in range(3):
        row = motion.rows[motion.filled[0]]
        for k in range(nv):
            row[k] = jacobian[axis, k]
        add_row(motion, nv, -bias[axis], tasks.stance.weight)
    for axis in range(3):
        if not transmits(contacts.kind[leg], g.body.legs.half_width[leg], ROLL_MOMENT + axis):
            continue
        direction = (axes[0, axis], axes[1, axis], axes[2, axis])
        _row_along(direction, jacobian, 3, motion.rows[motion.filled[0]])
        spin = _along(direction, g.body.frames.sole_twist[leg], 3)
        target = -tasks.stance_turn.damping * spin - _along(direction, bias, 3)
        add_row(motion, nv, target, tasks.stance_turn.weight)


@kernel
def add_swing(g: WholeBody, tasks: TaskTable, leg: int) -> None:
    """A sole in the air follows its reference, in the world or relative to the hip midpoint (eqs. 19 and 20)."""
    reference, frames, task, nv = g.reference, g.body.frames, tasks.swing, g.body.v.shape[0]
    position, velocity = reference.sole_position[leg], reference.sole_velocity[leg]
    for axis in range(3):
        direction, row = _heading_axis(frames, axis), g.motion.rows[g.motion.filled[0]]
        _row_along(direction, frames.sole_jacobian[leg], 0, row)
        drift = _along(direction, frames.sole_bias[leg], 0)
        if reference.sole_frame[leg] == HIPS:
            for k in range(nv):
                row[k] -= (
                    direction[0] * frames.hip_jacobian[0, k]
                    + direction[1] * frames.hip_jacobian[1, k]
                    + direction[2] * frames.hip_jacobian[2, k]
                )
            drift -= _along(direction, frames.hip_bias, 0)
            error = position[axis] - frames.relative_position[leg, axis]
            error_rate = velocity[axis] - frames.relative_velocity[leg, axis]
            wanted = reference.sole_acceleration[leg, axis]
        else:
            error = _along(direction, position, 0) - _along(direction, frames.sole_position[leg], 0)
            error_rate = _along(direction, velocity, 0) - _along(direction, frames.sole_twist[leg], 0)
            wanted = _along(direction, reference.sole_acceleration[leg], 0)
        target = wanted + task.stiffness * error + task.damping * error_rate - drift
        add_row(g.motion, nv, target, task.weight)


@kernel
def add_sole_turn(g: WholeBody, tasks: TaskTable, leg: int) -> None:
    """A sole's rotation follows its reference: about its edge on the ground, in the air about all axes but its line."""
    reference, frames, motion, task = g.reference, g.body.frames, g.motion, tasks.swing_turn
    kind, nv = g.contacts.kind[leg], g.body.v.shape[0]
    if kind == FLAT:
        return
    axes = g.contacts.axes[leg] if kind != NONE else frames.sole_rotation[leg]
    turn_error(frames.sole_rotation[leg], reference.sole_rotation[leg], motion.turn)
    for axis in range(3):
        if kind != NONE and axis + ROLL_MOMENT != PITCH_MOMENT:
            continue
        if kind == NONE and axis == 0 and g.body.legs.half_width[leg] == 0.0:
            continue
        direction = (axes[0, axis], axes[1, axis], axes[2, axis])
        _row_along(direction, frames.sole_jacobian[leg], 3, motion.rows[motion.filled[0]])
        rate = _along(direction, reference.sole_spin[leg], 0) - _along(direction, frames.sole_twist[leg], 3)
        target = _along(direction, reference.sole_angular_acceleration[leg], 0)
        target += task.stiffness * _along(direction, motion.turn, 0) + task.damping * rate
        add_row(motion, nv, target - _along(direction, frames.sole_bias[leg], 3), task.weight)


@kernel
def add_torso(g: WholeBody, tasks: TaskTable) -> None:
    """The torso's roll, pitch and yaw behave like spring and damper about the reference (eqs. 21 and 22)."""
    reference, frames, motion, nv = g.reference, g.body.frames, g.motion, g.body.v.shape[0]
    turn_error(g.body.state.body_rotation[g.body.legs.torso[0]], reference.torso_rotation, motion.turn)
    for axis in range(3):
        task = tasks.roll if axis == 0 else (tasks.pitch if axis == 1 else tasks.yaw)
        weight = reference.torso_weight[axis] * task.weight
        if weight == 0.0:
            continue
        direction = _heading_axis(frames, axis)
        _row_along(direction, frames.hip_jacobian, 3, motion.rows[motion.filled[0]])
        rate = _along(direction, reference.torso_spin, 0) - _along(direction, frames.torso_spin, 0)
        target = _along(direction, reference.torso_angular_acceleration, 0)
        target += task.stiffness * _along(direction, motion.turn, 0) + task.damping * rate
        add_row(motion, nv, target - _along(direction, frames.hip_bias, 3), weight)


@kernel
def add_body(g: WholeBody, tasks: TaskTable) -> None:
    """Centre of mass and hip height follow their references."""
    reference, frames, state, motion = g.reference, g.body.frames, g.body.state, g.motion
    com, nv = reference.com, g.body.v.shape[0]
    for axis in range(3):
        task = tasks.com if axis < 2 else tasks.com_height
        weight = reference.com_weight[axis] * task.weight
        if weight == 0.0:
            continue
        direction = _heading_axis(frames, axis)
        _row_along(direction, state.com_jacobian, 0, motion.rows[motion.filled[0]])
        error = _along(direction, com[0], 0) - _along(direction, state.com, 0)
        error_rate = _along(direction, com[1], 0) - _along(direction, state.com_velocity, 0)
        wanted = _along(direction, com[2], 0) + task.stiffness * error + task.damping * error_rate
        add_row(motion, nv, wanted - _along(direction, state.com_bias, 0), weight)
    weight = reference.hip_height_weight[0] * tasks.hip_height.weight
    if weight > 0.0:
        height, task = reference.hip_height, tasks.hip_height
        _row_along((0.0, 0.0, 1.0), frames.hip_jacobian, 0, motion.rows[motion.filled[0]])
        wanted = height[2] + task.stiffness * (height[0] - frames.hip_position[2])
        wanted += task.damping * (height[1] - frames.hip_velocity[2])
        add_row(motion, nv, wanted - frames.hip_bias[2], weight)


@kernel
def add_joints(g: WholeBody, tasks: TaskTable) -> None:
    """Joint references (eqs. 22 and 23); joints outside the legs hold their posture."""
    reference, q, v = g.reference, g.body.q, g.body.v
    for j in range(reference.joint_weight.shape[0]):
        task = tasks.leg_joint if g.body.legs.leg_of_joint[j] >= 0 else tasks.posture
        weight = reference.joint_weight[j] * task.weight
        if weight == 0.0:
            continue
        target = reference.joint[2, j] + task.stiffness * (reference.joint[0, j] - q[7 + j])
        target += task.damping * (reference.joint[1, j] - v[6 + j])
        add_joint(g.motion, j, target, weight)


@kernel
def add_wrench(g: WholeBody, tasks: TaskTable, leg: int) -> None:
    """Soft targets of a bearing sole: its centre of pressure, ``m_y + x f_z = 0`` and ``m_x - y f_z = 0``; its load."""
    reference, qp, kind, first = g.reference, g.program, g.contacts.kind[leg], g.contacts.first[leg]
    normal, variable = first + 2, first + 3
    weight = reference.cop_weight[leg] * tasks.cop
    if weight > 0.0:
        for axis in range(2):
            moment = ROLL_MOMENT if axis == 0 else PITCH_MOMENT
            if not transmits(kind, g.body.legs.half_width[leg], moment):
                continue
            arm = -reference.cop[leg, 1] if axis == 0 else reference.cop[leg, 0]
            qp.hessian[variable, variable] += weight
            qp.hessian[variable, normal] += weight * arm
            qp.hessian[normal, variable] += weight * arm
            qp.hessian[normal, normal] += weight * arm * arm
            variable += 1
    weight = reference.load_weight[leg] * tasks.load
    if weight > 0.0:
        qp.hessian[normal, normal] += weight
        qp.gradient[normal] -= weight * reference.load[leg]
