"""Motion of the base from the joints' for many instants, while one sole stands still, by the compiled dynamics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from gaitsmith.compiled import Matrix, Vector, kernel
from gaitsmith.dynamics.contact import sole_pose
from gaitsmith.dynamics.inertia import accumulate_subtrees, body_inertia_and_force
from gaitsmith.dynamics.kinematics import forward_kinematics, forward_velocities
from gaitsmith.dynamics.points import point_bias, point_velocity
from gaitsmith.dynamics.rotation import quaternion_from_entries
from gaitsmith.dynamics.tree import Tree, TreeState, make_tree_state, read_tree
from gaitsmith.robots import Robot

Array = npt.NDArray[np.float64]


@kernel
def _stand(
    tree: Tree,
    state: TreeState,
    body: int,
    position: Vector,
    rotation: Matrix,
    footholds: Matrix,
    q: Matrix,
    v: Matrix,
    a: Matrix,
    com: Matrix,
    place: Vector,
    axes: Matrix,
    twist: Vector,
    bias: Vector,
) -> None:
    """Fill the base's part of every row of q, v and a so that a sole frame stands at the foothold; and the CoM.

    The last four arguments are scratch: (3,), (3, 3), (6,), (6,).
    """
    base = tree.dof_body[0]
    for k in range(len(q)):
        q[k, :3] = 0.0
        q[k, 3], q[k, 4], q[k, 5], q[k, 6] = 1.0, 0.0, 0.0, 0.0
        v[k, :6] = 0.0
        a[k, :6] = 0.0
        forward_kinematics(tree, state, q[k])
        sole_pose(tree, state, body, position, rotation, place, axes)
        for i in range(3):
            q[k, i] = footholds[k, i] - (axes[0, i] * place[0] + axes[1, i] * place[1] + axes[2, i] * place[2])
        q[k, 3], q[k, 4], q[k, 5], q[k, 6] = quaternion_from_entries(
            (axes[0, 0], axes[1, 0], axes[2, 0], axes[0, 1], axes[1, 1], axes[2, 1], axes[0, 2], axes[1, 2], axes[2, 2])
        )
        forward_kinematics(tree, state, q[k])
        turn = state.body_rotation[base]
        x, y, z = footholds[k, 0] - q[k, 0], footholds[k, 1] - q[k, 1], footholds[k, 2] - q[k, 2]
        bias[:] = 0.0
        for out in (v[k], a[k]):  # the base undoes what the joints, and then the velocities, do to the sole
            point_velocity(tree, state, body, footholds[k], out, twist)
            u0, u1, u2 = twist[0] + bias[0], twist[1] + bias[1], twist[2] + bias[2]
            w0, w1, w2 = twist[3] + bias[3], twist[4] + bias[4], twist[5] + bias[5]
            out[0], out[1], out[2] = w1 * z - w2 * y - u0, w2 * x - w0 * z - u1, w0 * y - w1 * x - u2
            for i in range(3):
                out[3 + i] = -(turn[0, i] * w0 + turn[1, i] * w1 + turn[2, i] * w2)
            forward_velocities(tree, state, v[k])
            point_bias(tree, state, body, footholds[k], bias)
        body_inertia_and_force(tree, state)
        accumulate_subtrees(tree, state)
        for i in range(3):
            com[k, i] = state.reference[i] + state.composite[0, 1 + i] / tree.total_mass


@dataclass(frozen=True, eq=False)
class FullStates:
    """A robot at N instants; MuJoCo's order and axes.

    Attributes:
        position: (N, nq) base position and quaternion w x y z, joint angles.
        velocity, acceleration: (N, nv) base linear (world), angular (body), joints.
        com: (N, 3) centre of mass, world, m.
    """

    position: Array
    velocity: Array
    acceleration: Array
    com: Array


class BaseMotion:
    """Full states of a robot one of whose soles lies flat and still, axes along the world's.

    The same as :class:`gaitsmith.synthesis.gaits.full_state.StateFinder` gives one by one, for a whole array.

    Args:
        robot: the robot.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot, self._tree = robot, read_tree(robot.model)
        self._state = make_tree_state(self._tree)
        self._legs = {leg.name: leg for leg in robot.legs}

    def states(self, support: str, footholds: Array, q: Array, v: Array, a: Array) -> FullStates:
        """The robot's states.

        Args:
            support: left or right.
            footholds: (N, 2) x and y of the sole frame, world, m.
            q, v, a: (n, N) joint angles, velocities and accelerations.
        """
        leg, count = self._legs[support], q.shape[1]
        feet = np.column_stack([footholds, np.zeros(count)])
        position = np.hstack([np.zeros((count, 7)), q.T])
        velocity, acceleration = (np.hstack([np.zeros((count, 6)), values.T]) for values in (v, a))
        com = np.zeros((count, 3))
        sole = (leg.sole_body, leg.sole_position.copy(), leg.sole_rotation.copy())
        scratch = (np.zeros(3), np.zeros((3, 3)), np.zeros(6), np.zeros(6))
        _stand(self._tree, self._state, *sole, feet, position, velocity, acceleration, com, *scratch)
        return FullStates(position, velocity, acceleration, com)
