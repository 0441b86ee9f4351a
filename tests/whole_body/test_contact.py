"""Planned wrenches keep to friction, normal force, sole and yaw bound; a line or edge has no moment about itself."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from tests.control.walking import ROBOTS, records, robot
from tests.whole_body.bodies import CONTACTS, Body, Engine, moving, task

from gaitsmith.whole_body.reference import FLAT, HEEL, NONE, TOE

Array = npt.NDArray[np.float64]

SLACK = 1e-6  # N and N·m
WILD = 30.0  # m/s² and rad/s², asked for so that a bound is met
WEIGHT = 1e4

names = pytest.mark.parametrize("name", ROBOTS[:2])
contacts = pytest.mark.parametrize("kinds", CONTACTS, ids=str)


def along(body: Body, leg: int, kind: int) -> float:
    """Where on the sole's x axis the contact's pivot is, m."""
    sole = body.robot.legs[leg].sole
    return {FLAT: 0.0, HEEL: -sole.heel, TOE: sole.toe}[kind]


def contact_frame(rotation: Array, kind: int, half_width: float) -> Array:
    """The sole's axes; about the line (x) or the edge (y) turned level."""
    up = np.array([0.0, 0.0, 1.0])
    if kind == FLAT and half_width > 0.0:
        return rotation
    if kind == FLAT:
        x = rotation[:, 0]
        y = np.cross(up, x) / np.linalg.norm(np.cross(up, x))
        return np.column_stack([x, y, np.cross(x, y)])
    y = rotation[:, 1]
    x = np.cross(y, up) / np.linalg.norm(np.cross(y, up))
    return np.column_stack([x, y, np.cross(x, y)])


def felt(body: Body, leg: int, kind: int) -> tuple[Array, Array]:
    """Force and moment in the contact frame, about the pivot."""
    rotation, wrench = body.frames.sole_rotation[leg], body.result.wrench[leg]
    axes = contact_frame(rotation, kind, body.robot.legs[leg].sole.half_width)
    arm = along(body, leg, kind) * rotation[:, 0]
    return axes.T @ wrench[:3], axes.T @ (wrench[3:] - np.cross(arm, wrench[:3]))


def pulled(name: str, kinds: tuple[int, int], seed: int, com: Any, spin: Any = (0.0, 0.0, 0.0)) -> Body:
    """A solved QP that was asked for a wild acceleration of the CoM (m/s²) and the torso (rad/s²)."""
    strong, torso = task(WEIGHT), task(WEIGHT * any(spin))
    body = Body(name, com=strong, com_height=strong, roll=torso, pitch=torso, yaw=torso, cop=0.0)
    body.reference.com_weight[:] = 1.0
    body.place(*moving(name, seed, 0.5))
    body.reference.com[2], body.reference.torso_angular_acceleration[:] = com, spin
    body.joints = body.joints._replace(torque_step=np.inf)
    assert body.solve(*kinds)
    return body


PULLS = [(x * WILD, y * WILD, z * WILD) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 1)]


@names
@contacts
def test_friction_and_normal_force(name: str, kinds: tuple[int, int]) -> None:
    """Inside the cone, between the least and the greatest force; and it is used to the faces that stand in for it."""
    used = []
    for seed, pull in enumerate(PULLS):
        body = pulled(name, kinds, seed, pull)
        bounds = body.bounds
        for leg, kind in enumerate(kinds):
            if kind == NONE:
                continue
            force = felt(body, leg, kind)[0]
            assert bounds.normal_low - SLACK <= force[2] <= bounds.normal_high + SLACK
            assert np.hypot(*force[:2]) <= bounds.friction * force[2] + SLACK
            used.append(np.hypot(*force[:2]) / (bounds.friction * force[2]))
    assert np.cos(np.pi / 8.0) - 1e-6 <= max(used) <= 1.0 + 1e-6


@names
@pytest.mark.parametrize(("pull", "limit"), [(-WILD, "normal_low"), (20.0 * WILD, "normal_high")])
def test_the_normal_force_has_two_ends(name: str, pull: float, limit: str) -> None:
    """A robot that is told to fall keeps its sole on the ground; one that is told to jump does not break it."""
    body = pulled(name, (FLAT, NONE), 0, (0.0, 0.0, pull))
    bounds = body.bounds._replace(normal_high=2.0 * body.robot.mass * 9.81)
    body.bounds = bounds
    assert body.solve(FLAT, NONE)
    assert felt(body, 0, FLAT)[0][2] == pytest.approx(getattr(bounds, limit), rel=1e-6)


@names
@contacts
def test_zmp_stays_inside_the_sole(name: str, kinds: tuple[int, int]) -> None:
    """The margin away from every edge; on a line or an edge there is no moment about it."""
    nearest: dict[str, float] = {}
    for seed, pull in enumerate(PULLS):
        body = pulled(name, kinds, seed, (0.0, 0.0, 0.1 * pull[2]), (5.0 * pull[0], 5.0 * pull[1], 0.0))
        for leg, kind in enumerate(kinds):
            if kind == NONE:
                continue
            force, moment = felt(body, leg, kind)
            sole, margin, slack = body.robot.legs[leg].sole, body.bounds.zmp_margin, SLACK / force[2]
            x, y = -moment[1] / force[2], moment[0] / force[2]
            room = {"toe": sole.toe - margin - x, "heel": x + sole.heel - margin} if kind == FLAT else {}
            if kind != FLAT:
                assert abs(moment[1]) <= SLACK
            if sole.half_width > 0.0:
                room |= {"left": sole.half_width - margin - y, "right": y + sole.half_width - margin}
            else:
                assert abs(moment[0]) <= SLACK
            assert min(room.values(), default=0.0) >= -slack
            nearest = {edge: min(distance, nearest.get(edge, np.inf)) for edge, distance in room.items()} | (
                {edge: distance for edge, distance in nearest.items() if edge not in room}
            )
    assert min(nearest.values(), default=0.0) < 1e-6
    assert NONE in kinds or max(nearest.values(), default=0.0) < 1e-6  # every edge is met


@names
@contacts
def test_yaw_moment_is_bounded(name: str, kinds: tuple[int, int]) -> None:
    """In both directions, and the bound is used; on an edge it is what friction at its ends bears."""
    used = []
    for seed, turn in enumerate((-10.0 * WILD, 10.0 * WILD)):
        body = pulled(name, kinds, seed, (0.0, 0.0, 0.0), (0.0, 0.0, turn))
        for leg, kind in enumerate(kinds):
            if kind != NONE:
                force, moment = felt(body, leg, kind)
                edge = body.robot.legs[leg].sole.half_width
                twist = 0.5 * body.bounds.friction * edge if kind != FLAT and edge > 0.0 else np.inf
                most = min(twist, body.bounds.yaw_friction) * force[2]
                assert abs(moment[2]) <= most + SLACK
                used.append(abs(moment[2]) / most)
    assert max(used) == pytest.approx(1.0, abs=1e-5)


@names
@contacts
def test_pivots_move_as_the_engine_says(name: str, kinds: tuple[int, int]) -> None:
    """Jacobian and velocity product at the pivot, the origin of a flat sole or the middle of an edge."""
    body = Body(name)
    for seed in range(3):
        q, v = moving(name, seed)
        body.place(q, v).solve(*kinds)
        engine = Engine(name, q, v)
        for leg, kind in enumerate(kinds):
            if kind != NONE:
                sole = engine.sole(leg, along(body, leg, kind))
                np.testing.assert_allclose(body.contacts.pivot[leg], sole.position, atol=1e-12)
                np.testing.assert_allclose(body.contacts.jacobian[leg], sole.jacobian, atol=1e-12)
                np.testing.assert_allclose(body.contacts.bias[leg], sole.bias, atol=1e-10)


@pytest.mark.parametrize("name", ROBOTS)
def test_reported_zmp_is_that_of_the_wrench(name: str) -> None:
    """On a walk: about that point of the sole the wrench has no horizontal moment; a sole in the air reports none."""
    for record in records(name)[::5]:
        frames, body = record.groups.body.frames, record.groups.whole_body.solution
        for leg, kind in enumerate(record.groups.reference.contact):
            point = np.append(record.groups.telemetry.zmp[2 * leg : 2 * leg + 2], 0.0)
            if kind == NONE:
                assert not np.any(point)
                continue
            axes = contact_frame(frames.sole_rotation[leg], kind, robot(name).legs[leg].sole.half_width)
            force, moment = axes.T @ body.wrench[leg, :3], axes.T @ body.wrench[leg, 3:]
            np.testing.assert_allclose((moment - np.cross(point, force))[:2], 0.0, atol=1e-9)
