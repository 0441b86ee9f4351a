"""Forward kinematics of one leg relative to the torso: the chain of joints from the torso to the sole.

A joint turns everything below it about a line fixed in the torso at the zero pose, so the chain is the product of the
joints' own displacements times the sole's zero pose.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from gaitsmith.compiled import IntVector, Matrix, Vector, kernel
from gaitsmith.dynamics.rotation import axis_angle_entries, product_entries, turned
from gaitsmith.dynamics.tree import HINGE, SLIDE, read_tree
from gaitsmith.errors import BadInput

if TYPE_CHECKING:
    from gaitsmith.robots import Leg, Robot

Array = npt.NDArray[np.float64]

_INDEPENDENT = 1e-3  # m or rad per rad: what the weakest joint combination must still move to count as controlled


class LegKinematics(NamedTuple):
    """Constants of one leg with n joints, hip to ankle; all in the torso frame at the model's zero pose.

    Attributes:
        anchor: (n, 3) a point on each joint's axis, m.
        axis: (n, 3) unit vectors.
        slides: (n) 1 for a sliding joint, 0 for a turning one.
        zero: (n) joint values at the zero pose, rad or m.
        sole_position: (3) m.
        sole_rotation: (3, 3) sole frame to torso frame.
        turning: (3) 1 for each axis of the sole (roll, pitch, yaw) about which the leg can turn it at will.
        lower: (n) joint position limits, rad or m.
        upper: (n).
        velocity_limit: (n) rad/s or m/s.
    """

    anchor: Matrix
    axis: Matrix
    slides: IntVector
    zero: Vector
    sole_position: Vector
    sole_rotation: Matrix
    turning: IntVector
    lower: Vector
    upper: Vector
    velocity_limit: Vector


@kernel
def leg_forward(kin: LegKinematics, q: Vector, position: Vector, rotation: Matrix, jacobian: Matrix) -> None:
    """Sole pose in the torso frame, and how the joints move it.

    Args:
        kin: the leg.
        q: (n) joint values, rad or m.
        position: (3) receives the sole frame's origin, m.
        rotation: (3, 3) receives the rotation sole frame to torso frame.
        jacobian: (6, n) receives linear velocity of the origin and angular velocity, both in torso axes, per joint.
    """
    r: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    px = py = pz = 0.0
    n = q.shape[0]
    for j in range(n):
        ax, ay, az = kin.anchor[j, 0], kin.anchor[j, 1], kin.anchor[j, 2]
        ux, uy, uz = kin.axis[j, 0], kin.axis[j, 1], kin.axis[j, 2]
        dx, dy, dz = turned(r, ax, ay, az)
        cx, cy, cz = px + dx, py + dy, pz + dz
        wx, wy, wz = turned(r, ux, uy, uz)
        travel = q[j] - kin.zero[j]
        jacobian[3, j], jacobian[4, j], jacobian[5, j] = wx, wy, wz
        jacobian[0, j], jacobian[1, j], jacobian[2, j] = cx, cy, cz
        if kin.slides[j] == 1:
            px, py, pz = px + travel * wx, py + travel * wy, pz + travel * wz
            continue
        r = product_entries(r, axis_angle_entries(ux, uy, uz, travel))
        dx, dy, dz = turned(r, ax, ay, az)
        px, py, pz = cx - dx, cy - dy, cz - dz
    dx, dy, dz = turned(r, kin.sole_position[0], kin.sole_position[1], kin.sole_position[2])
    px, py, pz = px + dx, py + dy, pz + dz
    position[0], position[1], position[2] = px, py, pz
    for i in range(3):
        x, y, z = kin.sole_rotation[0, i], kin.sole_rotation[1, i], kin.sole_rotation[2, i]
        rotation[0, i], rotation[1, i], rotation[2, i] = turned(r, x, y, z)
    for j in range(n):
        wx, wy, wz = jacobian[3, j], jacobian[4, j], jacobian[5, j]
        if kin.slides[j] == 1:
            jacobian[0, j], jacobian[1, j], jacobian[2, j] = wx, wy, wz
            jacobian[3, j] = jacobian[4, j] = jacobian[5, j] = 0.0
            continue
        dx, dy, dz = px - jacobian[0, j], py - jacobian[1, j], pz - jacobian[2, j]
        jacobian[0, j], jacobian[1, j], jacobian[2, j] = wy * dz - wz * dy, wz * dx - wx * dz, wx * dy - wy * dx


def _controlled_axes(kin: LegKinematics) -> npt.NDArray[np.int64]:
    """Axes of the sole that the joints can turn it about besides placing its origin.

    A leg of n joints that moves its sole in r directions has n - r joints left for orientation. Pitch comes first
    (the sole must land flat along its length), then whichever of roll and yaw the leg controls better.
    """
    n = kin.zero.shape[0]
    bent = kin.lower + 0.4 * (kin.upper - kin.lower)
    position, rotation, jacobian = np.zeros(3), np.zeros((3, 3)), np.zeros((6, n))
    leg_forward(kin, bent, position, rotation, jacobian)
    linear, angular = jacobian[:3], rotation.T @ jacobian[3:]

    def weakest(axes: list[int]) -> float:
        moved = np.linalg.svd(np.vstack([linear, angular[axes]]), compute_uv=False)
        needed = int(np.sum(np.linalg.svd(linear, compute_uv=False) > _INDEPENDENT)) + len(axes)
        return float(moved[needed - 1]) if needed <= n else 0.0

    chosen: list[int] = []
    candidates = [1]
    while candidates:
        best = max(candidates, key=lambda axis: weakest([*chosen, axis]))
        if weakest([*chosen, best]) > _INDEPENDENT:
            chosen.append(best)
        elif len(candidates) == 1 or best != 1:
            break
        candidates = [axis for axis in (0, 2) if axis not in chosen]
    turning = np.zeros(3, dtype=np.int64)
    turning[chosen] = 1
    return turning


def make_leg_kinematics(robot: Robot, leg: Leg) -> LegKinematics:
    """Chain of one leg, read from the robot's model.

    Raises:
        BadInput: joints other than the leg's own lie between the torso and the sole, or one does not, or a joint is
            neither a hinge nor a slide.
    """
    tree = read_tree(robot.model)
    bodies: list[int] = []
    body = int(leg.sole_body)
    while body not in (0, robot.torso_body):
        bodies.insert(0, body)
        body = int(tree.body_parent[body])
    position, rotation = np.zeros(3), np.eye(3)
    anchors, axes, chain = [], [], []
    for below in bodies:
        position = position + rotation @ tree.body_offset[below]
        rotation = rotation @ tree.body_turn[below]
        first = int(tree.body_joint[below])
        for joint in range(first, first + int(tree.body_joint_count[below])):
            chain.append(joint)
            anchors.append(position + rotation @ tree.joint_anchor[joint])
            axes.append(rotation @ tree.joint_axis[joint])
    found = [robot.model.joint(joint).name for joint in chain]
    if body != robot.torso_body or found != list(leg.joints):
        valid = f"the joints from torso to sole in order: {', '.join(found)}"
        raise BadInput(f"{leg.name} leg's joints", list(leg.joints), valid)
    kinds = tree.joint_kind[chain]
    if not np.all((kinds == HINGE) | (kinds == SLIDE)):
        raise BadInput(f"{leg.name} leg's joints", list(leg.joints), "hinge or slide joints")
    own = leg.joint_indices
    kin = LegKinematics(
        anchor=np.array(anchors),
        axis=np.array(axes),
        slides=(kinds == SLIDE).astype(np.int64),
        zero=tree.joint_zero[chain],
        sole_position=position + rotation @ leg.sole_position,
        sole_rotation=rotation @ leg.sole_rotation,
        turning=np.zeros(3, dtype=np.int64),
        lower=np.array(robot.position_low[own]),
        upper=np.array(robot.position_high[own]),
        velocity_limit=np.array(robot.velocity_limit[own]),
    )
    return kin._replace(turning=_controlled_axes(kin))
