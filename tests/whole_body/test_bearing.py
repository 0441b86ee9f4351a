"""Bearing soles stay where they are, and their pressure and load go where they are wanted."""

from __future__ import annotations

import numpy as np
import pytest
from tests.control.walking import robot
from tests.whole_body.bodies import Body, Engine, moving, task

from gaitsmith.whole_body.problem import JointBounds
from gaitsmith.whole_body.reference import FLAT, HEEL, NONE

HEAVY, DAMPED = 1e6, 9.0  # weight; 1/s
FREE = JointBounds(torque_step=np.inf, stop_rate=1e6)


@pytest.mark.parametrize("name", ["bhr_b2", "thbip_ii"])
@pytest.mark.parametrize("kinds", [(FLAT, FLAT), (FLAT, NONE), (NONE, FLAT), (FLAT, HEEL)])
def test_bearing_soles_stay(name: str, kinds: tuple[int, int]) -> None:
    """Eq. 18: the pivot does not accelerate; the sole turns about its line or edge at most, and its spin is braked."""
    body = Body(name, stance=task(HEAVY), stance_turn=task(HEAVY, 0.0, DAMPED))
    q, v = moving(name, 2, 0.3)
    body.joints = FREE
    assert body.place(q, v).solve(*kinds)
    engine = Engine(name, q, v)
    for leg, kind in enumerate(kinds):
        if kind == NONE:
            continue
        flat = kind == FLAT
        sole = engine.sole(leg, 0.0 if flat else -body.robot.legs[leg].sole.heel)
        motion = sole.jacobian @ body.result.acceleration + sole.bias
        assert np.linalg.norm(motion[:3]) < 0.05
        held = [axis for axis in range(3) if body_transmits(name, flat, axis)]
        frame = body.contacts.axes[leg]
        spin, turn = frame.T @ (sole.jacobian[3:] @ v), frame.T @ motion[3:]
        np.testing.assert_allclose(turn[held], -DAMPED * spin[held], atol=0.05)


def body_transmits(name: str, flat: bool, axis: int) -> bool:
    """Whether a moment about this axis of the contact can be transmitted: not about a line, not about an edge."""
    line = robot(name).legs[0].sole.half_width == 0.0
    return axis == 2 or (axis == 0 and not line) or (axis == 1 and flat)


@pytest.mark.parametrize("target", [(0.0, 0.0), (0.04, 0.02), (-0.03, -0.01)])
def test_the_centre_of_pressure_goes_where_it_is_wanted(target: tuple[float, float]) -> None:
    """In the sole's axes, from its origin; m_y = -x f_z, m_x = y f_z."""
    body = Body("thbip_ii", cop=1e3)
    body.place(*moving("thbip_ii", 3, 0.3))
    body.reference.cop[:], body.reference.cop_weight[:] = target, 1.0
    assert body.solve(FLAT, NONE)
    axes_, wrench = body.frames.sole_rotation[0], body.result.wrench[0]
    force, moment = axes_.T @ wrench[:3], axes_.T @ wrench[3:]
    np.testing.assert_allclose([-moment[1] / force[2], moment[0] / force[2]], target, atol=1e-3)


def test_a_load_is_carried() -> None:
    """The normal force of each sole follows its share of the reference."""
    body = Body("thbip_ii", load=1e3)
    body.place(*moving("thbip_ii", 4, 0.1))
    body.reference.load[:], body.reference.load_weight[:] = (120.0, 50.0), 1.0
    assert body.solve(FLAT, FLAT)
    normal = [body.frames.sole_rotation[leg, :, 2] @ body.result.wrench[leg, :3] for leg in range(2)]
    np.testing.assert_allclose(normal, (120.0, 50.0), atol=1.0)
