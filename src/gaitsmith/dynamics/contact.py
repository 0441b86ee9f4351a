"""Poses of frames that are fixed to a body, soles first of all."""

from __future__ import annotations

from gaitsmith.compiled import Matrix, Vector, kernel
from gaitsmith.dynamics.tree import Tree, TreeState


@kernel
def sole_pose(
    tree: Tree,
    state: TreeState,
    body: int,
    position: Vector,
    rotation: Matrix,
    position_out: Vector,
    rotation_out: Matrix,
) -> None:
    """Pose of a sole frame in the world; any frame fixed to a body works.

    Args:
        tree: the tree.
        state: filled by :func:`gaitsmith.dynamics.update_dynamics`.
        body: number of the body that carries the sole.
        position: (3,) origin of the sole frame in body axes, m.
        rotation: (3, 3) sole axes to body axes.
        position_out: (3,) receives the origin in the world, m.
        rotation_out: (3, 3) receives sole axes to world.
    """
    r = state.body_rotation
    for i in range(3):
        a, b, c = r[body, i, 0], r[body, i, 1], r[body, i, 2]
        position_out[i] = state.body_position[body, i] + a * position[0] + b * position[1] + c * position[2]
        for j in range(3):
            rotation_out[i, j] = a * rotation[0, j] + b * rotation[1, j] + c * rotation[2, j]
