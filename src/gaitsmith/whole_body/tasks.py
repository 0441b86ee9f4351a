"""Cost of the whole-body QP (Han 2023, eqs. 18-23), one function a task.

Every task is a row of accelerations ``row q̈`` with a target and a weight; rows are mapped to the QP's variables
through the dynamics.
"""

from __future__ import annotations

from gaitsmith.compiled import Matrix, Vector, kernel
from gaitsmith.dynamics.tree import TreeState
from gaitsmith.qp.quadratic_program import QuadraticProgram
from gaitsmith.whole_body.contact_wrench import moment_axis, wrench_size
from gaitsmith.whole_body.forward_dynamics import MotionMap
from gaitsmith.whole_body.frames import Frames, Legs
from gaitsmith.whole_body.targets import Targets, TaskGains


@kernel
def _add_row(qp: QuadraticProgram, motion: MotionMap, n: int, target: float, weight: float) -> None:
    """Add ``weight (row q̈ - target)²`` to the cost (lower triangle of the Hessian)."""
    nv = motion.row.shape[0]
    error = -target
    for j in range(n):
        motion.image[j] = 0.0
    for k in range(nv):
        value = motion.row[k]
        if value != 0.0:
            error += value * motion.free[k]
            for j in range(n):
                motion.image[j] += value * motion.map[k, j]
    for i in range(n):
        scaled = weight * motion.image[i]
        qp.gradient[i] += scaled * error
        for j in range(i + 1):
            qp.hessian[i, j] += scaled * motion.image[j]


@kernel
def add_joint(qp: QuadraticProgram, motion: MotionMap, n: int, dof: int, target: float, weight: float) -> None:
    """The same for the acceleration of one degree of freedom."""
    error = motion.free[dof] - target
    for i in range(n):
        scaled = weight * motion.map[dof, i]
        qp.gradient[i] += scaled * error
        for j in range(i + 1):
            qp.hessian[i, j] += scaled * motion.map[dof, j]


@kernel
def add_stance(
    qp: QuadraticProgram, legs: Legs, frames: Frames, gains: TaskGains, motion: MotionMap, n: int, leg: int
) -> None:
    """A stance sole does not accelerate (eq. 18), neither does it turn, except about a line sole's own axis."""
    nv = motion.row.shape[0]
    jacobian, bias, axes = frames.sole_jacobian[leg], frames.sole_bias[leg], frames.contact_rotation[leg]
    for axis in range(3):
        for k in range(nv):
            motion.row[k] = jacobian[axis, k]
        _add_row(qp, motion, n, -bias[axis], gains.stance_linear)
    for variable in range(wrench_size(legs.half_width[leg]) - 3):
        axis = moment_axis(legs.half_width[leg], variable)
        for k in range(nv):
            motion.row[k] = (
                axes[0, axis] * jacobian[3, k] + axes[1, axis] * jacobian[4, k] + axes[2, axis] * jacobian[5, k]
            )
        drift = axes[0, axis] * bias[3] + axes[1, axis] * bias[4] + axes[2, axis] * bias[5]
        _add_row(qp, motion, n, -drift, gains.stance_angular)


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
        return float(heading[1] * vector[first] + heading[2] * vector[first + 1])
    if axis == 1:
        return float(heading[1] * vector[first + 1] - heading[2] * vector[first])
    return float(vector[first + 2])


@kernel
def add_swing(
    qp: QuadraticProgram, targets: Targets, frames: Frames, gains: TaskGains, motion: MotionMap, n: int, leg: int
) -> None:
    """The swing sole follows its acceleration relative to the hip midpoint (eq. 19)."""
    nv = motion.row.shape[0]
    jacobian, bias = frames.sole_jacobian[leg], frames.sole_bias[leg]
    for axis in range(3):
        _heading_row(frames.hip_jacobian, 0, axis, frames.heading, motion.row)
        for k in range(nv):
            motion.row[k] = -motion.row[k]
            if axis == 0:
                motion.row[k] += frames.heading[1] * jacobian[0, k] + frames.heading[2] * jacobian[1, k]
            elif axis == 1:
                motion.row[k] += frames.heading[1] * jacobian[1, k] - frames.heading[2] * jacobian[0, k]
            else:
                motion.row[k] += jacobian[2, k]
        drift = _heading_component(bias, 0, axis, frames.heading) - _heading_component(
            frames.hip_bias, 0, axis, frames.heading
        )
        _add_row(qp, motion, n, targets.swing_acceleration[leg, axis] - drift, gains.swing_foot)


@kernel
def add_attitude(qp: QuadraticProgram, frames: Frames, gains: TaskGains, motion: MotionMap, n: int) -> None:
    """Torso roll and pitch behave like spring and damper (eqs. 21 and 22)."""
    for axis in range(2):
        stiffness = gains.roll_stiffness if axis == 0 else gains.pitch_stiffness
        damping = gains.roll_damping if axis == 0 else gains.pitch_damping
        _heading_row(frames.hip_jacobian, 3, axis, frames.heading, motion.row)
        drift = _heading_component(frames.hip_bias, 3, axis, frames.heading)
        target = -stiffness * frames.tilt[axis] - damping * frames.tilt[2 + axis] - drift
        _add_row(qp, motion, n, target, gains.attitude)


@kernel
def add_standing(
    qp: QuadraticProgram,
    state: TreeState,
    targets: Targets,
    frames: Frames,
    gains: TaskGains,
    motion: MotionMap,
    n: int,
) -> None:
    """On both feet: CoM over the soles, hip midpoint at its height."""
    for axis in range(3):
        if axis < 2:
            _heading_row(state.com_jacobian, 0, axis, frames.heading, motion.row)
            drift = _heading_component(state.com_bias, 0, axis, frames.heading)
        else:
            _heading_row(frames.hip_jacobian, 0, axis, frames.heading, motion.row)
            drift = frames.hip_bias[2]
        _add_row(qp, motion, n, targets.body_acceleration[axis] - drift, gains.standing)
