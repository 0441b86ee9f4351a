"""Joints outside the legs: towards the posture that was commanded, smoothly and no faster than allowed."""

from __future__ import annotations

from collections.abc import Mapping
from numbers import Real
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from gaitsmith.compiled import Matrix, Vector, kernel
from gaitsmith.errors import BadInput
from gaitsmith.whole_body.legs import Legs
from gaitsmith.whole_body.reference import Reference

if TYPE_CHECKING:
    from gaitsmith.robots import Robot


class Posture(NamedTuple):
    """Commanded posture and the motion towards it; nj joints, those of the legs without meaning.

    Attributes:
        mailbox: (2, nj) angles and greatest speeds as last commanded, rad, rad/s; its letters are those of the gait.
        goal: (2, nj) the same as taken over.
        motion: (2, nj) angle and rate of the reference.
        rate: (1,) of the critically damped approach, 1/s.
    """

    mailbox: Matrix
    goal: Matrix
    motion: Matrix
    rate: Vector


def make_posture(home: Vector, velocity_limit: Vector, rate: float) -> Posture:
    """Joints at home."""
    goal = np.array([home, velocity_limit])
    return Posture(goal, goal.copy(), np.array([home, np.zeros_like(home)]), np.array([rate]))


def commanded(
    before: Matrix, robot: Robot, angles: Mapping[str, float], rates: Mapping[str, float]
) -> npt.NDArray[np.float64]:
    """A goal, (2, nj), that differs from another by some angles, rad, and greatest speeds, rad/s, of joints.

    Raises:
        BadInput: no joint outside the legs, or an angle or speed outside the joint's limits.
    """
    goal, limit = before.copy(), robot.velocity_limit
    legs = {name for leg in robot.legs for name in leg.joints}
    outside = {name: j for j, name in enumerate(robot.joint_names) if name not in legs}
    ranges = (robot.position_low, robot.position_high, "rad"), (np.zeros_like(limit), limit, "rad/s")
    for row, (given, (low, high, unit)) in enumerate(zip((angles, rates), ranges, strict=True)):
        for name, value in given.items():
            if name not in outside:
                raise BadInput("posture", name, f"a joint outside the legs: {', '.join(outside) or 'there is none'}")
            j = outside[name]
            if isinstance(value, bool) or not isinstance(value, Real) or not low[j] <= value <= high[j]:
                raise BadInput(f"posture: {name}", value, f"{low[j]:g} to {high[j]:g} {unit}")
            goal[row, j] = value
            if name not in rates:
                goal[1, j] = limit[j]
    return goal


@kernel
def hold_posture(posture: Posture, legs: Legs, reference: Reference, dt: float) -> None:
    """Joints outside the legs move towards their posture; those of the legs have no reference yet."""
    rate = posture.rate[0]
    for j in range(legs.leg_of_joint.shape[0]):
        reference.joint_weight[j] = reference.joint[2, j] = 0.0
        if legs.leg_of_joint[j] >= 0:
            continue
        before, fastest = posture.motion[1, j], posture.goal[1, j]
        wanted = rate * rate * (posture.goal[0, j] - posture.motion[0, j]) - 2.0 * rate * before
        speed = min(max(before + dt * wanted, -fastest), fastest)
        posture.motion[0, j] += dt * speed
        posture.motion[1, j] = speed
        reference.joint_weight[j] = 1.0
        reference.joint[0, j], reference.joint[1, j] = posture.motion[0, j], speed
        reference.joint[2, j] = (speed - before) / dt
