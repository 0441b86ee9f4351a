"""The dynamics and kinematics of one point of a gait as CasADi expressions; with them changes the machine code."""

from __future__ import annotations

from typing import Any

import casadi as ca

from gaitsmith.dynamics import symbolic
from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.point.layout import PointLayout

NAMES = ("value", "jacobian", "hessian")


def point_expressions(biped: Biped) -> list[Any]:
    """The three functions as CasADi expressions in the virtual machine."""
    model, layout = biped.model, PointLayout(biped.joints)
    n = layout.joints
    z, pivot = ca.SX.sym("z", layout.inputs), ca.SX.sym("pivot", 3)
    q, v, a = ca.SX.zeros(model.nq), ca.SX.zeros(model.nv), ca.SX.zeros(model.nv)
    for joint in range(n):
        q[biped.qpos[joint]], v[biped.dof[joint]], a[biped.dof[joint]] = z[joint], z[n + joint], z[2 * n + joint]
    u = z[layout.wrench :]
    support, other = biped.leg("right"), biped.leg("left")
    turn = support.sole_rotation.T
    start = symbolic.at_rest(model, turn, -turn @ support.sole_position)
    point = ca.DM(other.sole_position) + ca.mtimes(ca.DM(other.sole_rotation), pivot)
    wrench = symbolic.ExternalWrench(other.sole_body, point, u[:3], u[3:])
    found = symbolic.newton_euler(model, support.sole_body, start, q, v, a, (wrench,))
    torque = ca.vertcat(*(found.generalized[dof] for dof in biped.dof))
    force = ca.mtimes(ca.DM(turn), found.root_force)
    moment = ca.mtimes(ca.DM(turn), found.root_moment) + ca.cross(start.position, force)
    foot, torso = found.motion[other.sole_body], found.motion[biped.robot.torso_body]
    sole = ca.mtimes(foot.rotation, ca.DM(other.sole_rotation))
    spin = ca.cross(foot.omega, point)
    local = foot.acceleration + ca.cross(foot.alpha, point) + ca.cross(foot.omega, spin)
    hip = torso.position + ca.mtimes(torso.rotation, ca.DM(biped.robot.hip_midpoint))
    outputs = ca.vertcat(
        torque,
        force,
        moment,
        foot.position + ca.mtimes(foot.rotation, point),
        sole[1, 0],
        -sole[2, 0],
        sole[2, 1],
        ca.mtimes(foot.rotation, foot.velocity + spin),
        ca.mtimes(foot.rotation, foot.omega),
        ca.mtimes(foot.rotation, local) + ca.DM(model.opt.gravity),
        ca.mtimes(foot.rotation, foot.alpha),
        hip[2],
        torso.rotation[1, 0],
        -torso.rotation[2, 0],
        torso.rotation[2, 1],
        foot.position,
        ca.mtimes(foot.rotation, foot.velocity),
        sole[0, 0],
        ca.dot(moment, force) / biped.weight,
        ca.dot(u[3:], u[:3]) / biped.weight,
        force[2] ** 2 / biped.weight,
        u[2] ** 2 / biped.weight,
    )
    multipliers, weight = ca.SX.sym("l", layout.outputs), ca.SX.sym("w")
    jacobian = ca.jacobian(outputs, z)
    torque_jacobian = ca.jacobian(torque, z)
    hessian = ca.hessian(ca.dot(multipliers, outputs), z)[0]
    hessian = hessian + 2 * weight * ca.mtimes(torque_jacobian.T, torque_jacobian)
    return [
        ca.Function("value", [z, pivot], [outputs]),
        ca.Function("jacobian", [z, pivot], [outputs, jacobian]),
        ca.Function("hessian", [z, pivot, multipliers, weight], [hessian]),
    ]
