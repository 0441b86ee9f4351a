"""Standing posture: torso upright, both soles flat, the centre of mass above the ankles."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from gaitsmith.dynamics.algorithms import update_dynamics
from gaitsmith.dynamics.tree import make_tree_state, read_tree
from gaitsmith.errors import BadInput
from gaitsmith.kinematics.inverse import LegKinematics, make_leg_kinematics, solve_leg
from gaitsmith.robots import Robot

Array = npt.NDArray[np.float64]

_BALANCED = 1e-9  # m, centre of mass ahead of the soles
_ROUNDS = 50
_HEIGHTS = 40  # tried, evenly, to say which ones are in reach
_BISECTIONS = 10
_AHEAD = (0.0, 0.1, 0.2, -0.1)  # of the height, tried besides: an ankle may reach a crouch only near its balance
_WIDTHS = (0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0)  # tried, of half the hips' distance


def _place_soles(
    robot: Robot, chains: list[LegKinematics], ahead: float, height: float, width: float, last: Array | None
) -> Array:
    """Configuration with the soles ``ahead`` of the hip midpoint; raises BadInput out of reach."""
    q = np.zeros(7 + len(robot.joint_names))
    q[2], q[3] = height - robot.hip_midpoint[2], 1.0
    q[7:] = robot.home
    for leg, chain in zip(robot.legs, chains, strict=True):
        sole = robot.hip_midpoint + np.array([ahead, 0.0, -height])
        sole[1] += leg.side * width
        q[7 + leg.joint_indices] = solve_leg(
            chain, sole, np.eye(3), None if last is None else last[7 + leg.joint_indices]
        )
    return q


def _in_reach(robot: Robot, chains: list[LegKinematics], ahead: float, height: float, width: float) -> bool:
    try:
        _place_soles(robot, chains, ahead, height, width, None)
    except BadInput:
        return False
    return True


def _reachable_heights(robot: Robot, chains: list[LegKinematics], ahead: float, width: float) -> str:
    """The heights that are in reach, in words; "" if none was found."""
    longest = 1.1 * float(max(-chain.sole_position[2] + robot.hip_midpoint[2] for chain in chains))
    heights = np.linspace(longest / _HEIGHTS, longest, _HEIGHTS)
    found = [height for height in heights if _in_reach(robot, chains, ahead, float(height), width)]
    if not found:
        return ""
    ends = []
    for inside, outward in ((found[0], -1.0), (found[-1], 1.0)):
        good, bad = float(inside), float(inside) + outward * longest / _HEIGHTS
        for _ in range(_BISECTIONS):
            middle = 0.5 * (good + bad)
            good, bad = (middle, bad) if _in_reach(robot, chains, ahead, middle, width) else (good, middle)
        ends.append(good)
    return f"{math.ceil(1000.0 * ends[0]) / 1000.0:g} to {math.floor(1000.0 * ends[1]) / 1000.0:g} m"


def standing_posture(robot: Robot, height: float, width: float, com_ahead: float = 0.0) -> Array:
    """Configuration in which the robot stands still on both feet.

    The torso is upright above the world's origin; the soles' origins are at z = 0, ±``width`` to the sides, and
    ``com_ahead`` behind the centre of mass; the soles are level about the axes that the legs control. Joints outside
    the legs are at home.

    Args:
        height: hip midpoint above the soles, m.
        width: half the distance between the soles' origins, m.
        com_ahead: of the centre of mass, forward from the soles' origins, m.

    Returns:
        (7 + nj) base position, base quaternion w x y z, joint values.

    Raises:
        BadInput: height or width is not positive, not finite, or out of the legs' reach.
    """
    for name, value in (("height", height), ("width", width)):
        if not (math.isfinite(value) and value > 0.0):
            raise BadInput(name, value, "a positive length in m")
    chains = [make_leg_kinematics(robot, leg) for leg in robot.legs]
    tree = read_tree(robot.model)
    state = make_tree_state(tree)
    still = np.zeros(len(tree.dof_body))
    upright = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, *robot.home])
    update_dynamics(tree, state, upright, still)
    straight, missed = float(state.com[0] - robot.hip_midpoint[0]), None
    for ahead in (0.0, *(straight + share * height for share in _AHEAD)):
        q = None
        try:
            for _ in range(_ROUNDS):
                q = _place_soles(robot, chains, ahead, height, width, q)
                update_dynamics(tree, state, q, still)
                error = float(state.com[0]) - com_ahead - float(robot.hip_midpoint[0]) - ahead
                if abs(error) < _BALANCED:
                    return q
                ahead += error
        except BadInput:
            missed = ahead if missed is None else missed
    if missed is None:
        raise BadInput("height", height, "a height at which the legs can balance the torso", "try a lower one")
    heights = _reachable_heights(robot, chains, missed, width)
    if heights:
        raise BadInput("height", height, f"{heights} at a width of {width:g} m")
    hip = float(np.mean([abs(leg.hip_anchor[1]) for leg in robot.legs]))
    widths = [share * hip for share in _WIDTHS if _reachable_heights(robot, chains, missed, share * hip)]
    if widths:
        raise BadInput("width", width, f"about {widths[0]:.3g} to {widths[-1]:.3g} m, in reach at some height")
    valid = "joint limits that let both soles lie flat below an upright torso"
    raise BadInput("limits", "no flat foot at any height and width", valid, "check the sole frames too")
