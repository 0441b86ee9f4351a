"""Pinocchio as a second oracle: its model built number by number from MuJoCo's, its conventions converted here.

Pinocchio's free joint has its linear velocity in body axes, so v_pin = X(q) v with X = diag(Rᵀ, 1), and MuJoCo's
accelerations at rest are Pinocchio's ẊV. Its quaternions end with w.
"""

from __future__ import annotations

from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin

from gaitsmith.compiled import Matrix, Vector

_FREE, _BALL, _SLIDE = 0, 1, 2


class Oracle(NamedTuple):
    """Everything that the package computes, by Pinocchio, in the package's conventions."""

    mass_matrix: Matrix
    bias: Vector
    com: Vector
    com_velocity: Vector
    com_jacobian: Matrix
    com_bias: Vector
    pose: pin.SE3
    jacobian: Matrix
    point_bias: Vector


def build(model: mujoco.MjModel) -> tuple[pin.Model, list[tuple[int, pin.SE3]]]:
    """The same tree; with it, for every MuJoCo body, Pinocchio's joint and the body's placement in it."""
    built = pin.Model()
    built.gravity.linear = np.array(model.opt.gravity)
    places = [(0, pin.SE3.Identity())]
    for body in range(1, model.nbody):
        joint, place = places[model.body_parentid[body]]
        place = place * pin.SE3(_matrix(model.body_quat[body]), model.body_pos[body].copy())
        first = model.body_jntadr[body]
        for k in range(first, first + model.body_jntnum[body]):
            kind = int(model.jnt_type[k])
            anchor = pin.SE3(np.eye(3), model.jnt_pos[k].copy())
            axis = model.jnt_axis[k].copy()
            if kind == _FREE:
                joint_model, anchor, place = pin.JointModelFreeFlyer(), pin.SE3.Identity(), pin.SE3.Identity()
            elif kind == _BALL:
                joint_model = pin.JointModelSpherical()
            else:
                joint_model = (pin.JointModelPrismaticUnaligned if kind == _SLIDE else pin.JointModelRevoluteUnaligned)(
                    axis
                )
            joint = built.addJoint(joint, joint_model, place * anchor, f"{body}-{k}")
            place = anchor.inverse()
        inertia = pin.Inertia(
            model.body_mass[body],
            model.body_ipos[body].copy(),
            _matrix(model.body_iquat[body]) @ np.diag(model.body_inertia[body]) @ _matrix(model.body_iquat[body]).T,
        )
        built.appendBodyToJoint(joint, inertia, place)
        places.append((joint, place))
    built.armature = model.dof_armature.copy()
    return built, places


def _matrix(quaternion: Vector) -> Matrix:
    out = np.zeros(9)
    mujoco.mju_quat2Mat(out, quaternion)
    return out.reshape(3, 3)


def convert(model: mujoco.MjModel, q: Vector, v: Vector) -> tuple[Vector, Vector, Vector, Matrix]:
    """(q, v, Ẋv, X) in Pinocchio's conventions."""
    q_out, v_out, drift, x = q.copy(), v.copy(), np.zeros(model.nv), np.eye(model.nv)
    for k in range(model.njnt):
        kind, i, j = int(model.jnt_type[k]), model.jnt_qposadr[k], model.jnt_dofadr[k]
        if kind in (_FREE, _BALL):
            i += 3 if kind == _FREE else 0
            quaternion = q[i : i + 4] / np.linalg.norm(q[i : i + 4])
            q_out[i : i + 4] = np.roll(quaternion, -1)
            if kind == _FREE:
                x[j : j + 3, j : j + 3] = _matrix(quaternion).T
                drift[j : j + 3] = -np.cross(v[j + 3 : j + 6], x[j : j + 3, j : j + 3] @ v[j : j + 3])
        else:
            q_out[i] -= model.qpos0[i]
    v_out = x @ v
    return q_out, v_out, drift, x


def evaluate(model: mujoco.MjModel, q: Vector, v: Vector, body: int, point_in_body: Vector) -> Oracle:
    """All quantities at one state; the frame quantities for one point of one body."""
    built, places = build(model)
    joint, place = places[body]
    frame = built.addFrame(pin.Frame("point", joint, place * pin.SE3(np.eye(3), point_in_body), pin.FrameType.OP_FRAME))
    data = built.createData()
    q, v, drift, x = convert(model, q, v)
    mass_matrix = pin.crba(built, data, q)
    mass_matrix = np.triu(mass_matrix) + np.triu(mass_matrix, 1).T
    bias = pin.rnea(built, data, q, v, drift)
    pin.centerOfMass(built, data, q, v, drift)
    com, com_velocity, com_bias = data.com[0].copy(), data.vcom[0].copy(), data.acom[0].copy()
    com_jacobian = pin.jacobianCenterOfMass(built, data, q) @ x
    pin.computeJointJacobians(built, data, q)
    pin.forwardKinematics(built, data, q, v, drift)
    pin.updateFramePlacements(built, data)
    aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    return Oracle(
        mass_matrix=x.T @ mass_matrix @ x,
        bias=x.T @ bias,
        com=com,
        com_velocity=com_velocity,
        com_jacobian=com_jacobian,
        com_bias=com_bias,
        pose=data.oMf[frame].copy(),
        jacobian=pin.getFrameJacobian(built, data, frame, aligned) @ x,
        point_bias=pin.getFrameClassicalAcceleration(built, data, frame, aligned).vector.copy(),
    )
