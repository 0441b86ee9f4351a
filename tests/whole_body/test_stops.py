"""Joints do not pass their stops while the torques can prevent it; a tick that cannot is solved without, and counted."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from tests.control.walking import DT
from tests.whole_body.bodies import Body, standing, task

from gaitsmith.whole_body.reference import FLAT, NONE

FROM = 0.3  # rad, from the stop at first
PASSED = 2e-3  # rad, by a rate that is bounded, sampled and not linear
NEAR = 0.02  # rad: what is asked for beyond the stop is followed up to there

NAMES = ("bhr_b2", "thbip_ii")
CASES = [(name, joint, end) for name, count in zip(NAMES, (4, 6), strict=True) for joint in range(count) for end in (-1, 1)]


def driven(name: str, column: int, end: int, beyond: float) -> Body:
    """A robot on its left sole whose right leg has one joint near its stop and told to go beyond."""
    body = Body(name, leg_joint=task(10.0, 400.0, 40.0), swing=task(0.0))
    joint = body.robot.legs[1].joint_indices[column]
    stop = (body.robot.position_low if end < 0 else body.robot.position_high)[joint]
    q = standing(name).copy()
    q[7 + joint] = stop - end * FROM
    body.place(q, np.zeros(body.robot.model.nv))
    body.reference.joint_weight[body.robot.legs[1].joint_indices] = 1.0
    body.reference.joint[0, joint] = stop + end * beyond
    return body


def distance(body: Body, column: int, end: int) -> float:
    """How far the joint is inside its stop, rad."""
    joint = body.robot.legs[1].joint_indices[column]
    stop = (body.robot.position_low if end < 0 else body.robot.position_high)[joint]
    return float(end * (stop - body.q[7 + joint]))


@pytest.mark.parametrize(("name", "column", "end"), CASES)
def test_a_joint_driven_towards_its_stop_does_not_pass_it(name: str, column: int, end: int) -> None:
    """The predicted motion, integrated for 0.6 s: it comes near the stop and stays inside."""
    body = driven(name, column, end, 0.5)
    reference = body.reference.joint.copy()
    nearest = FROM
    for tick in range(600):
        assert body.solve(FLAT, NONE, fresh=tick == 0)
        v = body.v + DT * body.result.acceleration
        q = body.q.copy()
        mujoco.mj_integratePos(body.robot.model, q, v, DT)
        body.place(q, v)
        body.reference.joint[:] = reference
        nearest = min(nearest, distance(body, column, end))
    assert nearest > -PASSED
    assert nearest < NEAR
    assert body.result.stops_dropped[0] == 0


def test_without_the_bound_the_joint_would_pass() -> None:
    """The case above is one in which the bound decides."""
    body = driven("thbip_ii", 3, 1, 0.5)
    body.joints = body.joints._replace(stop_rate=1e4)
    joint = body.robot.legs[1].joint_indices[3]
    for tick in range(600):
        body.solve(FLAT, NONE, fresh=tick == 0)
        q, v = body.q.copy(), body.v + DT * body.result.acceleration
        mujoco.mj_integratePos(body.robot.model, q, v, DT)
        wanted = body.reference.joint[0, joint]
        body.place(q, v).reference.joint[0, joint] = wanted
    assert distance(body, 3, 1) < NEAR


@pytest.mark.parametrize("name", NAMES)
def test_an_impossible_stop_is_dropped_and_counted(name: str) -> None:
    """A joint that runs into its stop faster than any torque can brake: the tick is solved without the rows."""
    body = driven(name, 2, -1, 0.0)
    joint = body.robot.legs[1].joint_indices[2]
    v = np.zeros(body.robot.model.nv)
    v[6 + joint] = -300.0
    body.place(body.q, v)
    assert body.solve(FLAT, NONE)
    assert (body.result.stops_dropped[0], body.result.fallbacks[0], body.result.infeasible[0]) == (1, 0, 0)
    body.place(standing(name), np.zeros(body.robot.model.nv))
    assert body.solve(FLAT, NONE)
    assert body.result.stops_dropped[0] == 1


@pytest.mark.parametrize("name", NAMES)
def test_stops_that_are_far_do_not_matter(name: str) -> None:
    """In the standing posture the torques are those of a robot without stops."""
    torques = []
    for room in (0.0, 10.0):
        body = Body(name)
        legs = body.legs
        body.legs = legs._replace(position_low=legs.position_low - room, position_high=legs.position_high + room)
        body.place(standing(name), np.zeros(body.robot.model.nv)).solve(FLAT, FLAT)
        torques.append(body.result.torque.copy())
    np.testing.assert_allclose(*torques, rtol=0.0, atol=1e-9)
