"""Soles of any convex shape, and joints with springs, damping and dry friction of their own."""

from __future__ import annotations

import copy
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
import pytest
from tests.control.walking import robot
from tests.whole_body.bodies import Body, moving

from gaitsmith.robots.sole import Sole
from gaitsmith.whole_body.reference import FLAT, HEEL, NONE, TOE

Array = Any
NAME = "thbip_ii"
SLACK = 1e-8  # m
TRAPEZOID = ((-0.05, -0.02), (0.06, -0.045), (0.08, -0.02), (0.08, 0.02), (0.06, 0.045), (-0.05, 0.02))
DIRECTIONS = [(np.cos(angle), np.sin(angle)) for angle in np.arange(12) * np.pi / 6]


def shaped(sole: Sole, **tasks: Any) -> Body:
    """The robot with other soles."""
    machine = robot(NAME)
    return Body(NAME, replace(machine, legs=tuple(replace(leg, sole=sole) for leg in machine.legs)), **tasks)


def zmp(body: Body, along: float = 0.0) -> Array:
    """Of the left sole, sole axes, from the origin or from a point of its x axis."""
    rotation, wrench = body.frames.sole_rotation[0], body.result.wrench[0]
    moment = rotation.T @ (wrench[3:] - np.cross(along * rotation[:, 0], wrench[:3]))
    return np.array([-moment[1], moment[0]]) / (rotation.T @ wrench[:3])[2]


def pressed(body: Body, direction: tuple[float, float], kind: int = FLAT) -> Body:
    """A solution whose centre of pressure was wanted far outside the sole."""
    body.place(*moving(NAME, 0, 0.0))
    body.reference.cop[:], body.reference.cop_weight[:] = direction, 1.0
    body.joints = body.joints._replace(torque_step=np.inf)
    assert body.solve(kind, NONE)
    return body


def test_the_zmp_keeps_the_margin_from_every_edge_of_a_polygon_and_uses_all_of_them() -> None:
    body = shaped(Sole(kind="polygon", points=TRAPEZOID), cop=1e3)
    edges, least = body.robot.legs[0].sole.edges, np.inf * np.ones(len(TRAPEZOID))
    for direction in DIRECTIONS:
        place = zmp(pressed(body, direction))
        room = edges[:, 2] - edges[:, :2] @ place - body.bounds.zmp_margin
        assert room.min() > -SLACK
        least = np.minimum(least, room)
    assert least.max() < SLACK


def test_a_sole_on_its_edge_bears_within_that_edge() -> None:
    body = shaped(Sole(kind="polygon", points=TRAPEZOID), cop=1e3)
    body.bounds = body.bounds._replace(zmp_margin=0.005)
    for kind, along in ((HEEL, -0.05), (TOE, 0.08)):
        found = sorted(zmp(pressed(body, direction, kind), along)[1] for direction in DIRECTIONS[3:10:6])
        assert found == pytest.approx([-0.015, 0.015], abs=SLACK), kind


def test_a_rectangle_of_points_is_the_rectangle() -> None:
    plain = robot(NAME).legs[0].sole
    solutions = []
    for sole in (plain, Sole(kind="polygon", points=tuple(map(tuple, plain.corners.tolist())))):
        body = pressed(shaped(sole), (1.0, 0.3))
        solutions.append(body.result.torque.copy())
    np.testing.assert_array_equal(*solutions)


@pytest.mark.parametrize("felt", ["spring", "damping", "friction", "all"])
@pytest.mark.parametrize("name", [NAME, "with_arms"])
def test_accelerations_are_met_with_joints_that_act_by_themselves(name: str, felt: str) -> None:
    """M q̈ + h = Sᵀτ + Jᵀλ + τ_p: MuJoCo moves as the solution says, dry friction included where joints move."""
    model = copy.deepcopy(robot(name).model)
    if felt in ("spring", "all"):
        model.jnt_stiffness[1:], model.qpos_spring[7:] = 12.0, 0.1
    if felt in ("damping", "all"):
        model.dof_damping[6:] = 0.15
    if felt in ("friction", "all"):
        model.dof_frictionloss[6:] = 0.6
    body = Body(name, replace(robot(name), model=model))
    q, v = moving(name, 4, 0.3)
    v[6:] += 3.0 * np.sign(v[6:])
    assert body.place(q, v).solve(FLAT, NONE)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT  # the engine's dry friction is soft
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = q, v
    data.qfrc_applied[6:] = body.result.torque - model.dof_frictionloss[6:] * np.sign(v[6:])
    data.qfrc_applied[:] += body.frames.sole_jacobian[0].T @ body.result.wrench[0]
    mujoco.mj_forward(model, data)
    loose = 1e-3 if felt in ("friction", "all") else 1e-9  # its sign is smooth
    size = np.abs(body.result.acceleration).max()
    np.testing.assert_allclose(data.qacc, body.result.acceleration, atol=loose * size)


def test_a_joint_at_rest_is_not_pushed_by_its_dry_friction() -> None:
    """Without motion nothing is cancelled: the solution is that of the joint without friction."""
    torques = []
    for friction in (0.0, 0.6):
        model = copy.deepcopy(robot(NAME).model)
        model.dof_frictionloss[6:] = friction
        body = Body(NAME, replace(robot(NAME), model=model))
        assert len(body.legs.passive) == (0 if friction == 0.0 else body.nj)
        q, v = moving(NAME, 4, 0.3)
        assert body.place(q, 0.0 * v).solve(FLAT, NONE)
        torques.append(body.result.torque.copy())
    np.testing.assert_allclose(*torques, atol=1e-9)
