"""Legs and their soles as rows of a table, read from the robot; nothing here knows how many there are."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gaitsmith.compiled import Cube, IntMatrix, IntVector, Matrix, Vector

if TYPE_CHECKING:
    from gaitsmith.robots import Robot
    from gaitsmith.robots.sole import Sole


_FASTEST = 25.0  # ω: no joint's damping, as it is cancelled, is faster by itself
_SLIDES = 0.03  # ω, joint speed at which dry friction is fully cancelled


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
        edges: (n,) how many the sole has.
        edge: (n, most, 3) outward unit normal, sole axes, and distance from the sole frame's origin, m.
        end: (n, 2, 3) heel's and toe's edge: x, least and greatest y, m.
        leg_of_joint: (nj,) row of the leg, -1 outside the legs.
        position_low: (nj,) rad.
        position_high: (nj,) rad.
        torque_limit: (nj,) N·m.
        home: (nj,) angle that a joint outside the legs holds, rad.
        passive: (nj, 5) what the joints do by themselves: stiffness, N·m/rad; the angle at which its torque is zero,
            rad; damping, N·m·s/rad; dry friction, N·m, and the speed at which it is fully felt, rad/s. No rows for a
            robot whose joints do nothing.
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
    edges: IntVector
    edge: Cube
    end: Cube
    leg_of_joint: IntVector
    position_low: Vector
    position_high: Vector
    torque_limit: Vector
    home: Vector
    passive: Matrix


def edge_table(soles: Sequence[Sole]) -> tuple[IntVector, Cube]:
    """How many edges every sole has, (n,), and the edges, (n, most, 3), as :class:`Legs` has them."""
    edges = np.array([len(sole.edges) for sole in soles])
    edge = np.zeros((len(soles), edges.max(), 3))
    for row, sole in enumerate(soles):
        edge[row, : edges[row]] = sole.edges
    return edges, edge


def make_legs(robot: Robot) -> Legs:
    """Kernel form of a robot's legs."""
    legs = robot.legs
    edges, edge = edge_table([leg.sole for leg in legs])
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
        edges=edges,
        edge=edge,
        end=np.array([leg.sole.ends for leg in legs]),
        leg_of_joint=leg_of_joint,
        position_low=np.asarray(robot.position_low),
        position_high=np.asarray(robot.position_high),
        torque_limit=np.asarray(robot.torque_limit),
        home=np.asarray(robot.home),
        passive=_passive(robot),
    )


def _passive(robot: Robot) -> Matrix:
    """Springs, damping and dry friction of the joints, as far as a control in discrete time can cancel them."""
    model, dofs = robot.model, robot.joint_dofs
    joints = model.dof_jntid[dofs]
    damping, friction = model.dof_damping[dofs], model.dof_frictionloss[dofs]
    table = np.column_stack([model.jnt_stiffness[joints], model.qpos_spring[model.jnt_qposadr[joints]], damping])
    if not (table[:, (0, 2)].any() or friction.any()):
        return np.zeros((0, 5))
    rate = np.sqrt(np.linalg.norm(model.opt.gravity) / robot.card.gait.height)
    most = _FASTEST * rate * model.dof_M0[dofs]
    table[:, 2] = np.minimum(damping, most)
    return np.column_stack([table, friction, np.maximum(_SLIDES * rate, friction / most)])
