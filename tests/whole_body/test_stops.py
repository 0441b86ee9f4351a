"""Joints do not pass their stops while torques can prevent it; a tick that cannot brakes them, and is counted."""

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
CASES = [
    (name, joint, end) for name, count in zip(NAMES, (4, 6), strict=True) for joint in range(count) for end in (-1, 1)
]


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


def nearest(body: Body, column: int, end: int) -> float:
    """Least distance from the stop while the predicted motion is integrated for 0.4 s, rad."""
    reference, joint = body.reference.joint.copy(), body.robot.legs[1].joint_indices[column]
    stop = (body.robot.position_low if end < 0 else body.robot.position_high)[joint]
    least = FROM
    for tick in range(400):
        assert body.solve(FLAT, NONE, fresh=tick == 0)
        v = body.v + DT * body.result.acceleration
        q = body.q.copy()
        mujoco.mj_integratePos(body.robot.model, q, v, DT)
        body.place(q, v).reference.joint[:] = reference
        least = min(least, float(end * (stop - body.q[7 + joint])))
    return least


@pytest.mark.parametrize(("name", "column", "end"), CASES)
def test_a_joint_driven_towards_its_stop_does_not_pass_it(name: str, column: int, end: int) -> None:
    """It comes near the stop and stays inside, though its first torque may be the largest and changes are bounded."""
    body = driven(name, column, end, 0.5)
    least = nearest(body, column, end)
    assert least > -PASSED
    assert least < NEAR


def test_without_the_stop_the_joint_goes_on() -> None:
    """The case above is one in which the stop decides."""
    body = driven("thbip_ii", 3, 1, 0.5)
    body.legs = body.legs._replace(position_high=body.legs.position_high + 10.0)
    assert nearest(body, 3, 1) < -0.3


@pytest.mark.parametrize("name", NAMES)
def test_an_impossible_stop_is_dropped_and_counted(name: str) -> None:
    """A joint that runs into its stop faster than any torque can brake: it is braked as hard as can be."""
    body = driven(name, 2, -1, 0.0)
    joint = body.robot.legs[1].joint_indices[2]
    v = np.zeros(body.robot.model.nv)
    v[6 + joint] = -30.0
    body.legs = body.legs._replace(torque_limit=np.full(body.nj, 5.0))
    body.place(body.q, v)
    assert body.solve(FLAT, NONE)
    assert (body.result.stops_dropped[0], body.result.fallbacks[0], body.result.infeasible[0]) == (1, 0, 0)
    braked = body.result.acceleration[6 + joint]
    body.legs = (legs := body.legs)._replace(position_low=legs.position_low - 100.0)
    assert body.solve(FLAT, NONE)
    assert braked > body.result.acceleration[6 + joint]
    body.legs = legs
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
