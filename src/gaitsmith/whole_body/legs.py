"""Legs and their soles as rows of a table, read from the robot; nothing here knows how many there are."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gaitsmith.compiled import Cube, IntMatrix, IntVector, Matrix, Vector

if TYPE_CHECKING:
    from gaitsmith.robots import Robot


class Legs(NamedTuple):
    """Constants of all legs (one row each, in the robot's order) and of the torso.

    Attributes:
        torso: (1,) body id.
        hip_midpoint: (3,) torso frame, m.
        side: (n,) +1 for a leg to the left of the torso's middle, -1 to the right.
        other: (n,) row of the leg that takes over from this one.
        sole_body: (n,) body ids.
        sole_position: (n, 3) sole frame's origin in its body, m.
        sole_rotation: (n, 3, 3) sole frame to body.
        joints: (n, n_leg) joint indices, hip to ankle.
        knee: (n,) joint indices.
        ankle_pitch: (n,) joint indices.
        ankle_roll: (n,) joint indices, -1 without one.
        heel: (n,) m, behind the sole frame's origin.
        toe: (n,) m, ahead of it.
        half_width: (n,) m; 0 for a line sole.
        leg_of_joint: (nj,) row of the leg, -1 outside the legs.
        position_low: (nj,) rad.
        position_high: (nj,) rad.
        torque_limit: (nj,) N·m.
        home: (nj,) angle that a joint outside the legs holds, rad.
    """

    torso: IntVector
    hip_midpoint: Vector
    side: Vector
    other: IntVector
    sole_body: IntVector
    sole_position: Matrix
    sole_rotation: Cube
    joints: IntMatrix
    knee: IntVector
    ankle_pitch: IntVector
    ankle_roll: IntVector
    heel: Vector
    toe: Vector
    half_width: Vector
    leg_of_joint: IntVector
    position_low: Vector
    position_high: Vector
    torque_limit: Vector
    home: Vector


def make_legs(robot: Robot) -> Legs:
    """Kernel form of a robot's legs."""
    legs = robot.legs
    leg_of_joint = np.full(len(robot.joint_names), -1, dtype=np.int64)
    for row, leg in enumerate(legs):
        leg_of_joint[leg.joint_indices] = row
    return Legs(
        torso=np.array([robot.torso_body]),
        hip_midpoint=np.asarray(robot.hip_midpoint),
        side=np.array([float(leg.side) for leg in legs]),
        other=np.roll(np.arange(len(legs)), -1),
        sole_body=np.array([leg.sole_body for leg in legs]),
        sole_position=np.array([leg.sole_position for leg in legs]),
        sole_rotation=np.array([leg.sole_rotation for leg in legs]),
        joints=np.array([leg.joint_indices for leg in legs]),
        knee=np.array([leg.knee for leg in legs]),
        ankle_pitch=np.array([leg.ankle_pitch for leg in legs]),
        ankle_roll=np.array([leg.ankle_roll for leg in legs]),
        heel=np.array([leg.sole.heel for leg in legs]),
        toe=np.array([leg.sole.toe for leg in legs]),
        half_width=np.array([leg.sole.half_width for leg in legs]),
        leg_of_joint=leg_of_joint,
        position_low=np.asarray(robot.position_low),
        position_high=np.asarray(robot.position_high),
        torque_limit=np.asarray(robot.torque_limit),
        home=np.clip(0.0, robot.position_low, robot.position_high),
    )
