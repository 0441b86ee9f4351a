"""One call that fills a tree's state."""

from __future__ import annotations

from gaitsmith.compiled import Vector, kernel
from gaitsmith.dynamics.inertia import accumulate_subtrees, body_inertia_and_force, mass_matrix_and_bias
from gaitsmith.dynamics.kinematics import forward_kinematics, forward_velocities
from gaitsmith.dynamics.tree import Tree, TreeState


@kernel
def update_dynamics(tree: Tree, state: TreeState, q: Vector, v: Vector) -> None:
    """Fill ``state`` for one configuration and velocity.

    Args:
        q: (nq,) MuJoCo's ``qpos``; quaternions w x y z of any length.
        v: (nv,) MuJoCo's ``qvel``; a free joint's linear part in world axes, its angular part in body axes.
    """
    forward_kinematics(tree, state, q)
    forward_velocities(tree, state, v)
    body_inertia_and_force(tree, state)
    accumulate_subtrees(tree, state)
    mass_matrix_and_bias(tree, state, v)
