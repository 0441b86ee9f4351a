"""One call that fills a tree's state."""

from __future__ import annotations

from gaitsmith.compiled import Vector, kernel
from gaitsmith.dynamics.inertia import gather, project, weigh
from gaitsmith.dynamics.kinematics import move, place
from gaitsmith.dynamics.tree import Tree, TreeState


@kernel
def update(tree: Tree, state: TreeState, q: Vector, v: Vector) -> None:
    """Fill ``state`` for one configuration and velocity.

    Args:
        tree: constants from :func:`gaitsmith.dynamics.read_tree`.
        state: arrays from :func:`gaitsmith.dynamics.make_tree_state`, all overwritten.
        q: (nq,) MuJoCo's ``qpos``; quaternions w x y z of any length.
        v: (nv,) MuJoCo's ``qvel``; a free joint's linear part in world axes, its angular part in body axes.
    """
    place(tree, state, q)
    move(tree, state, v)
    weigh(tree, state)
    gather(tree, state)
    project(tree, state, v)
