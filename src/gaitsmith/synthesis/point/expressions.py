"""The dynamics and kinematics of one point of a gait as CasADi expressions; with them changes the machine code.

All outputs but the last four are *plain*: at most linear in accelerations and in u. Twist and load are products of
plain ones, so their curvature, and that of the squared torques, is a product of Jacobians. Only the plain outputs'
Hessian is expanded, which makes the code a fifth of what expanding everything takes.
"""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from gaitsmith.dynamics import symbolic, symbolic_root
from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.motions.motion import Side, opposite
from gaitsmith.synthesis.point.layout import PointLayout, layout_of, sides_of


def point_expressions(biped: Biped) -> list[Any]:
    """Value, Jacobian and Hessian for every support foot of :func:`sides_of`, in CasADi's virtual machine."""
    layout = layout_of(biped)
    z, pivot = ca.SX.sym("z", layout.inputs), ca.SX.sym("pivot", 6 if biped.slopes else 3)
    multipliers = ca.SX.sym("l", layout.twist)
    cores = []
    for side in sides_of(biped):
        plain = _plain(biped, side, z, pivot)
        products = _products(layout, plain, z, biped.weight)
        outputs = ca.vertcat(plain, products)
        curved = ca.hessian(ca.dot(multipliers, plain), z)[0]
        cores.append((outputs, ca.jacobian(outputs, z), curved))
    # One pattern for both feet, so that their points mix in one program.
    patterns = [[core[k].sparsity() for core in cores] for k in (1, 2)]
    slopes, curves = (pattern[0] if len(pattern) == 1 else pattern[0].unite(pattern[1]) for pattern in patterns)
    found = []
    for side, (outputs, slope, curved) in zip(sides_of(biped), cores, strict=True):
        value = ca.Function(f"value_{side}", [z, pivot], [outputs], {"cse": True})
        jacobian = ca.Function(f"jacobian_{side}", [z, pivot], [outputs, ca.project(slope, slopes)], {"cse": True})
        core = ca.Function(f"curved_{side}", [z, pivot, multipliers], [ca.project(curved, curves)], {"cse": True})
        found += [value, jacobian, _hessian(f"hessian_{side}", layout, biped.weight, jacobian, core)]
    return found


def _plain(biped: Biped, side: Side, z: Any, pivot: Any) -> Any:
    """Plain outputs with a foot as support; for the left one all in the mirrored frame."""
    model, n = biped.model, biped.joints
    left = side == "left"
    mirror = ca.DM(np.diag([1.0, -1.0, 1.0]) if left else np.eye(3))  # of a vector
    axial = -mirror if left else mirror  # of a moment or an angular velocity
    sign = biped.sign if left else np.ones(n)
    order = biped.partner if left else np.arange(n)
    q, v, a = ca.SX.zeros(model.nq), ca.SX.zeros(model.nv), ca.SX.zeros(model.nv)
    layout = layout_of(biped)
    for local, joint in enumerate(biped.index[order].tolist()):
        places = (layout.position + local, layout.velocity + local, layout.acceleration + local)
        q[7 + joint], v[6 + joint], a[6 + joint] = (sign[local] * z[k] for k in places)
    u = z[layout.wrench :]
    gravity = pivot[3:] if biped.slopes else ca.DM(model.opt.gravity)
    pivot = pivot[:3]
    support, other = biped.leg(side), biped.leg(opposite(side))
    turn = support.sole_rotation.T
    start = symbolic.at_rest(model, turn, -turn @ support.sole_position, gravity)
    if layout.leans:
        poses = [ca.SX.zeros(6) for _ in range(3)]
        for pose, first in zip(poses, (layout.position, layout.velocity, layout.acceleration), strict=True):
            pose[5] = (-1.0 if left else 1.0) * z[first + n]
        start = symbolic_root.flying(gravity, turn, support.sole_position, *poses)
    if layout.poses == 1:
        x, right, far = biped.sole(side).ends[1]
        about = np.array([x, 0.5 * (right + far), 0.0])
        poses = [ca.vertcat(*about, 0, z[layout.position + layout.pose], 0)]
        poses += [ca.vertcat(0, 0, 0, 0, z[k + layout.pose], 0) for k in (layout.velocity, layout.acceleration)]
        toe = support.sole_position + support.sole_rotation @ about
        start = symbolic_root.flying(gravity, turn, toe, *poses)
    elif layout.poses:
        sides = ca.DM([1, -1, 1, -1, 1, -1] if left else [1] * 6)
        firsts = [k + layout.pose for k in (layout.position, layout.velocity, layout.acceleration)]
        start = symbolic_root.flying(gravity, turn, support.sole_position, *(sides * z[k : k + 6] for k in firsts))
    point = ca.DM(other.sole_position) + ca.mtimes(ca.DM(other.sole_rotation), ca.mtimes(mirror, pivot))
    wrench = symbolic.ExternalWrench(other.sole_body, point, ca.mtimes(mirror, u[:3]), ca.mtimes(axial, u[3:]))
    held = {6 + joint: float(biped.home[joint]) for joint in biped.held.tolist()}
    found = symbolic.newton_euler(model, support.sole_body, start, q, v, a, (wrench,), held)
    torque = [sign[k] * found.generalized[6 + joint] for k, joint in enumerate(biped.index[order].tolist())]
    force = ca.mtimes(start.rotation, found.root_force)
    moment = ca.mtimes(start.rotation, found.root_moment) + ca.cross(start.position, force)
    foot, torso = found.motion[other.sole_body], found.motion[biped.robot.torso_body]
    sole = ca.mtimes([mirror, foot.rotation, ca.DM(other.sole_rotation), mirror])
    body = ca.mtimes([mirror, torso.rotation, mirror])
    spin = ca.cross(foot.omega, point)
    pull = foot.acceleration + ca.cross(foot.alpha, point) + ca.cross(foot.omega, spin)
    turned, turned_axial = ca.mtimes(mirror, foot.rotation), ca.mtimes(axial, foot.rotation)
    hip = torso.position + ca.mtimes(torso.rotation, ca.DM(biped.robot.hip_midpoint))
    return ca.vertcat(
        *torque,
        ca.mtimes(mirror, force),
        ca.mtimes(axial, moment),
        ca.mtimes(mirror, foot.position) + ca.mtimes(turned, point),
        sole[1, 0],
        -sole[2, 0],
        sole[2, 1],
        ca.mtimes(turned, foot.velocity + spin),
        ca.mtimes(turned_axial, foot.omega),
        ca.mtimes(turned, pull) + gravity,
        ca.mtimes(turned_axial, foot.alpha),
        hip[2],
        body[1, 0],
        -body[2, 0],
        body[2, 1],
        ca.mtimes(mirror, foot.position),
        ca.mtimes(turned, foot.velocity),
        sole[0, 0],
        *([_lean_gap(sole, z[layout.position + n + 1])] if layout.leans else []),
        *(_own(start, support, mirror) if layout.poses else []),
        *(_places(layout, model, found, torso, mirror, axial) if layout.places else []),
        *([moment[1] + biped.sole(side).ends[1][0] * force[2]] if layout.poses == 1 else []),
    )


def _places(layout: PointLayout, model: Any, found: Any, torso: Any, mirror: Any, axial: Any) -> list[Any]:
    """Centre of mass, its velocity, the torso's frame, and in flight the angular momentum about the foothold."""
    place, speed, spin = symbolic_root.momentum(model, found)
    vectors = [ca.mtimes(mirror, vector) for vector in (place, speed, torso.position)]
    return [*vectors, *([ca.mtimes(axial, spin)] if layout.poses == 6 else [])]


def _own(start: Any, support: Any, mirror: Any) -> list[Any]:
    """Place, yaw, pitch and roll of the support sole."""
    place = start.position + ca.mtimes(start.rotation, ca.DM(support.sole_position))
    sole = ca.mtimes([mirror, start.rotation, ca.DM(support.sole_rotation), mirror])
    return [ca.mtimes(mirror, place), sole[1, 0], -sole[2, 0], sole[2, 1]]


def _lean_gap(sole: Any, lean: Any) -> Any:
    """Sine of a sole's roll about its line, which points along x, less its lean."""
    return sole[2, 1] * ca.cos(lean) - sole[2, 2] * ca.sin(lean)


def _products(layout: PointLayout, plain: Any, z: Any, weight: float) -> Any:
    """Twist and load of the support sole and of the other."""
    force, moment = plain[layout.force : layout.force + 3], plain[layout.moment : layout.moment + 3]
    u = z[layout.wrench :]
    products = ca.dot(moment, force), ca.dot(u[3:], u[:3]), force[2] ** 2, u[2] ** 2
    return ca.vertcat(*products) / weight


def _hessian(name: str, layout: PointLayout, weight: float, jacobian: Any, core: Any) -> Any:
    """(z, pivot, multipliers, weight) -> Hessian of multipliersᵀ o, and twice the weight times JᵀJ of the torques."""
    z, pivot, w = ca.MX.sym("z", layout.inputs), ca.MX.sym("pivot", jacobian.size1_in(1)), ca.MX.sym("w")
    multipliers = ca.MX.sym("l", layout.outputs)
    o, J = jacobian(z, pivot)
    twist, load = multipliers[layout.twist :][:2] / weight, multipliers[layout.load :][:2] / weight
    force, moment, n = layout.force, layout.moment, layout.joints
    pressed = ca.vertcat(0, 0, 2 * load[0])
    chained = ca.vertcat(
        ca.MX(n, 1), twist[0] * o[moment : moment + 3] + pressed * o[force : force + 3], twist[0] * o[force : force + 3]
    )
    plain = multipliers[: layout.twist] + ca.vertcat(chained, ca.MX(layout.twist - n - 6, 1))
    torque, push, turn = J[:n, :], J[force : force + 3, :], J[moment : moment + 3, :]
    stack = ca.vertcat(torque, push, turn)
    weighed = ca.vertcat(2 * w * torque, twist[0] * turn + ca.mtimes(ca.diag(pressed), push), twist[0] * push)
    cross = ca.vertcat(
        ca.horzcat(ca.diag(ca.vertcat(0, 0, 2 * load[1])), twist[1] * ca.DM.eye(3)),
        ca.horzcat(twist[1] * ca.DM.eye(3), ca.MX(3, 3)),
    )
    last = ca.diagcat(ca.MX(layout.wrench, layout.wrench), cross)
    total = core(z, pivot, plain) + ca.mtimes(stack.T, weighed) + last
    return ca.Function(name, [z, pivot, multipliers, w], [total])
